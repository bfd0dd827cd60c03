# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# --backend, the options of the GPU backends, and bench --table of GL. Vulkan itself is in vulkan.sh. Times are never judged here.
# shellcheck shell=sh disable=SC2154
. "${SOURCE:?}/tests/tools/tap.sh"
. "${SOURCE:?}/tests/tools/drivers.sh"
in=$work/in.exr
out=$work/o/out.exr
lens="--fstop 2 --focal-length 50 --focus 4"
"$FIXTURE" make "$in" 64 48 float 32 R=noise G=0.5 B=ramp:0:1 Z=ramp:1:20
# shellcheck disable=SC2086
{
# --- what does the work
for pair in auto:cpu cpu:cpu reference:reference; do
    passes "--backend ${pair%:*}" "$DDOF" render "$in" -o "$out" $lens --backend "${pair%:*}" --json
    check "--backend ${pair%:*} is ${pair#*:}" test "$(member backend)" = "${pair#*:}"
    if member solver >/dev/null 2>&1; then not_ok "--backend ${pair%:*}: no solver"; else ok "--backend ${pair%:*}: no solver"; fi
done
passes "bench, no --backend" "$DDOF" bench --size 32x32 --runs 1 --json
check "bench, no --backend is cpu" test "$(member backend)" = cpu
rm -f "$work/o/"*

# --- options that belong to a GPU backend
for pair in "--solver cr:the GL backend; add --backend gl" "--solver line:the Vulkan backend; add --backend vulkan" \
    "--solver cr4+pack:the GPU backends; add --backend gl or --backend vulkan" "--surface rgba32f:the GPU backends; add --backend gl or" \
    "--shared-chain:the GL backend; add --backend gl" "--device 0:the Vulkan backend; add --backend vulkan"; do
    option=${pair%%:*}
    name=${option%% *}
    pattern="$name: belongs to $(echo "${pair#*:}" | sed 's/add/(add|take)/')"
    refuses "render $option without a GPU backend" 2 "$pattern" "$DDOF" render "$in" -o "$out" $lens $option
    refuses "render $option with cpu" 2 "$pattern" "$DDOF" render "$in" -o "$out" $lens $option --backend cpu
    refuses "bench $option with reference" 2 "$pattern" "$DDOF" bench $option --backend reference
    [ "$name" = --device ] || refuses "coc $option" 2 "$name: not an option of 'ddof coc'" "$DDOF" coc "$in" -o "$out" $lens $option
done
for command in "render $in -o $out $lens" bench; do
    refuses "${command%% *}: a solver that GL lacks" 2 "--solver: the GL backend has no 'line'; it has: cr4.pack, cr-vanilla, cr, cr.pack, cr4, cr.pcr$" "$DDOF" $command --backend gl --solver line
    refuses "${command%% *}: a solver that Vulkan lacks" 2 "--solver: the Vulkan backend has no 'cr4'; it has: line, pcr, pcr3.sweep, cr4.pack$" "$DDOF" $command --backend vulkan --solver cr4
    refuses "${command%% *}: --shared-chain with vulkan" 2 '--shared-chain: belongs to the GL backend; take --backend gl' "$DDOF" $command --backend vulkan --shared-chain
    refuses "${command%% *}: --device with gl" 2 '--device: belongs to the Vulkan backend; take --backend vulkan' "$DDOF" $command --backend gl --device 0
    refuses "${command%% *}: --device with auto" 2 '--device: belongs to the Vulkan backend; take --backend vulkan' "$DDOF" $command --backend auto --device 0 --solver line
    refuses "${command%% *}: auto, a solver of Vulkan and an option of GL" 2 '--shared-chain: belongs to the GL backend' "$DDOF" $command --backend auto --solver line --shared-chain
done
refuses "bench: layout with vulkan" 2 '--layout: the images of the Vulkan backend are interleaved' "$DDOF" bench --backend vulkan --layout planar
refuses "bench: channels with vulkan" 2 '--channels: the images of the Vulkan backend have 3 or 4' "$DDOF" bench --backend vulkan --channels 2
refuses "bench: CoC beyond half floats" 2 '--coc: 70000 does not fit into half floats' "$DDOF" bench --backend vulkan --type half --coc 70000
refuses "table of vulkan with the reference" 2 '--reference: makes no row of the table' "$DDOF" bench --backend vulkan --table --reference

# --- the table's options
refuses "--format without --table" 2 '--format: is for --table' "$DDOF" bench --format csv
refuses "--reference without --table" 2 '--reference: is for --table' "$DDOF" bench --reference
refuses "--table --backend reference" 2 '--backend: reference alone makes no table' "$DDOF" bench --table --backend reference
refuses "--table --backend cpu --surface" 2 '--surface: belongs to the GPU backends' "$DDOF" bench --table --backend cpu --surface rgba32f
refuses "--table --json --format csv" 2 '--format: csv contradicts --json' "$DDOF" bench --table --json --format csv
for option in "--solver cr" --shared-chain "--type half" "--layout planar" "--channels 3" --in-place; do
    refuses "--table $option" 2 "${option%% *}: is not for --table" "$DDOF" bench --table $option
    refuses "--table $option, vulkan" 2 "${option%% *}: is not for --table" "$DDOF" bench --table --backend vulkan $option
done
refuses "--table --device without vulkan" 2 '--device: belongs to the Vulkan backend' "$DDOF" bench --table --device 0

# --- the table without GL
tiny="--table --size 40x30 --runs 1"
passes "table of the CPU" "$DDOF" bench $tiny --backend cpu
check "table of the CPU: row" grep -Eq '^\| 40x30 \| .cpu. \| [0-9.]+ \|' "$work/out"
check "table of the CPU: no GL" sh -c "! grep -q 'cr4' '$work/out'"
passes "table with the reference" "$DDOF" bench $tiny --backend cpu --reference --format json
has_members "table: members" machine compiler version commit runs gl_timing cpu_timing rows.0.width rows.0.solver rows.0.shared_chain \
    rows.0.backend rows.0.device rows.0.median_ms rows.0.q1_ms rows.0.q3_ms rows.0.min_ms rows.0.max_ms rows.0.ratio_to_cr \
    rows.0.surface_bytes rows.0.surface_bytes_per_pixel rows.0.published_mb rows.0.published_hd5870_ms rows.0.published_gtx480_ms
check "table with the reference: rows" test "$(member rows.0.backend) $(member rows.1.backend)" = "cpu reference"
passes "table --json" "$DDOF" bench $tiny --backend cpu --json --quiet
check "table --json: one run" test "$(member runs)" = 1
passes "table as CSV" "$DDOF" bench $tiny --backend cpu --format csv
check "table as CSV: as many fields in each line" awk -F'"' '{ gsub(/,/, "", $2); n = gsub(/,/, ",", $0) } NR == 1 { m = n } n < m { exit 1 }' "$work/out"
passes "table --quiet" "$DDOF" bench $tiny --backend cpu --quiet
check "table --quiet prints nothing" test ! -s "$work/out"

# --- no GL
run env __EGL_VENDOR_LIBRARY_DIRS=/nonexistent "$DDOF" bench --backend gl --size 8x8 --runs 1
if [ $status -ne 0 ]; then
    for command in "render $in -o $out $lens" "coc $in -o $out $lens" bench "bench --table"; do
        refuses "no GL: ${command%% *}" 1 '--backend gl: .*; use --backend cpu' env __EGL_VENDOR_LIBRARY_DIRS=/nonexistent "$DDOF" $command --backend gl
    done
    refuses "no GL is said before the picture is read" 1 '--backend gl' env __EGL_VENDOR_LIBRARY_DIRS=/nonexistent "$DDOF" render "$work/nothing.exr" -o "$out" $lens --backend gl
    passes "no GL: auto" env __EGL_VENDOR_LIBRARY_DIRS=/nonexistent "$DDOF" render "$in" -o "$out" $lens --json
    check "no GL: auto is cpu" test "$(member backend)" = cpu
    passes "no GL: auto with a solver" env __EGL_VENDOR_LIBRARY_DIRS=/nonexistent "$DDOF" render "$in" -o "$out" $lens --backend auto --solver cr --json
    check "no GL: auto with a solver falls back" test "$(member backend)" = cpu
    check "no GL: and says so" grep -q 'note: --backend auto: .*; the CPU engine does the work' "$work/err"
    passes "no GL: table" env __EGL_VENDOR_LIBRARY_DIRS=/nonexistent "$DDOF" bench $tiny --json
    check "no GL: table says so" grep -q 'note: no rows of the GL backend: ' "$work/err"
    check "no GL: table has the CPU" test "$(member rows.0.backend)" = cpu
else
    skip "no GL" "this EGL cannot be taken away"
fi

# --- GL
run "$DDOF" bench --backend gl --size 8x8 --runs 1
if grep -q '^ddof: --backend gl: .*; use --backend cpu' "$work/err"; then
    for what in render solvers bench table; do skip "--backend gl: $what" "$(sed 's/^ddof: //; s/#//g' "$work/err" | head -1)"; done
    done_testing
    exit
fi
passes "the CPU's picture" "$DDOF" render "$in" -o "$work/cpu.exr" $lens -q
passes "render --backend gl" "$DDOF" render "$in" -o "$out" $lens --backend gl --json
has_members "gl: members" backend device solver surface shared_chain surface_bytes surface_bytes_per_pixel solve_ms
check "gl: what they say" test "$(member backend) $(member solver) $(member surface) $(member shared_chain)" = "gl cr4+pack rgba16f false"
near "gl: bytes per pixel" "$(member surface_bytes_per_pixel)" "$(awk -v b="$(member surface_bytes)" 'BEGIN { print b / 3072 }')" 0.001
passes "auto with a solver" "$DDOF" render "$in" -o "$out" $lens --backend auto --solver cr --json
check "auto with a solver is gl" test "$(member backend)" = gl
passes "render --backend gl, for people" "$DDOF" render "$in" -o "$out" $lens --backend gl --solver cr --surface rgba32f
check "gl, for people" grep -Eq '^gl: cr, rgba32f, [0-9.]+ bytes of surfaces per pixel' "$work/out"
for solver in cr-vanilla cr cr+pack cr4 cr4+pack cr+pcr; do
    for more in "" "--surface rgba32f --shared-chain"; do
        passes "--solver $solver $more" "$DDOF" render "$in" -o "$out" $lens --backend gl --solver $solver $more --json
        check "--solver $solver $more: named" test "$(member solver)" = $solver
        "$DDOF" compare "$work/cpu.exr" "$out" --json >"$work/out" 2>/dev/null
        above "--solver $solver $more: near the CPU" 0.004 "$(member max_error)"
    done
done
passes "coc --backend gl" "$DDOF" coc "$in" -o "$work/o/coc.exr" $lens --backend gl --json
"$DDOF" coc "$in" -o "$work/coc.exr" $lens -q
near "coc --backend gl: near the CPU" "$("$FIXTURE" value "$work/o/coc.exr" CoC 63 40)" "$("$FIXTURE" value "$work/coc.exr" CoC 63 40)" 0.001
passes "bench --backend gl" "$DDOF" bench --size 40x30 --runs 1 --backend gl --solver cr4 --shared-chain --json
has_members "bench --backend gl: members" median_ms solver surface_bytes surface_bytes_per_pixel
check "bench --backend gl: shared chain" test "$(member shared_chain)" = true
passes "bench --backend gl, for people" "$DDOF" bench --size 40x30 --runs 1 --backend gl
check "bench --backend gl: surfaces" grep -Eq '^gl +[0-9.]+ bytes of surfaces per pixel' "$work/out"
for format in markdown csv json; do
    passes "table, $format" "$DDOF" bench $tiny --backend gl --format $format
    check "table, $format: cr4+pack" grep -q 'cr4+pack' "$work/out"
done
check "table: rows" test "$(for i in 0 1 2 3 4 5 6 7; do member rows.$i.solver; done | tr '\n' ' ')" = "cr cr+pack cr4 cr4+pack cr-vanilla cr+pcr cr4+pack cpu "
near "table: cr is 1" "$(member rows.0.ratio_to_cr)" 1 0
check "table: shared chain" test "$(member rows.6.shared_chain)" = true
above "table: shared chain needs less" "$(member rows.3.surface_bytes)" "$(member rows.6.surface_bytes)"
check "table: not a published size" test "$(member rows.0.published_mb)" = null
passes "table, other settings" "$DDOF" bench $tiny --backend gl --surface rgba32f --depth --coc 20 --conductance classic --substeps 2 --json
check "table, other settings: surface" test "$(member rows.0.surface)" = rgba32f
rm -f "$work/o/"*
refuses "a picture too large for GL" 1 'gl.*textures' "$DDOF" bench --table --size 100000x1 --runs 1 --backend gl
}
done_testing
