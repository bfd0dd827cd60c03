# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# --backend vulkan: render, bench and its table; --device. Skipped where there is no Vulkan. Times are never judged here.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
. "${SOURCE:?}/tests/tools/drivers.sh"
in=$work/in.exr
out=$work/o/out.exr
lens="--fstop 2 --focal-length 50 --focus 4"
"$FIXTURE" make "$in" 64 48 float 32 R=noise G=0.5 B=ramp:0:1 Z=ramp:1:20

# --- no Vulkan
run $no_vulkan "$DDOF" render "$in" -o "$out" $lens --backend vulkan
if [ $status -ne 0 ]; then
    for command in "render $in -o $out $lens" "coc $in -o $out $lens" "bench --size 8x8" "bench --table"; do
        refuses "no Vulkan: ${command%% *}" 1 '--backend vulkan: .*; use --backend cpu' $no_vulkan "$DDOF" $command --backend vulkan
    done
    refuses "no Vulkan is said before the picture is read" 1 '--backend vulkan' $no_vulkan "$DDOF" render "$work/nothing.exr" -o "$out" $lens --backend vulkan
    for command in "render $in -o $out $lens" "bench --size 8x8 --runs 1"; do
        passes "no Vulkan: ${command%% *}, auto with a solver of Vulkan" $no_vulkan "$DDOF" $command --backend auto --solver line --json
        check "no Vulkan: ${command%% *}, falls back" test "$(member backend)" = cpu
        check "no Vulkan: ${command%% *}, says so" grep -q 'note: --backend auto: .*; the CPU engine does the work, without --solver' "$work/err"
    done
else
    skip "no Vulkan" "this loader finds one all the same"
fi
rm -f "$work/o/"*

# --- Vulkan
run "$DDOF" devices --json
if [ "$(member vulkan.devices.0.usable 2>/dev/null)" != true ]; then
    why=$(member vulkan.why_none 2>/dev/null)
    [ "${why:-null}" = null ] && why=$(member vulkan.devices.0.refused 2>/dev/null)
    why=$(echo "$why" | tr -d '#')
    for what in render solvers device bench table; do skip "--backend vulkan: $what" "${why:-no device}"; done
    done_testing
    exit
fi
name=$(member vulkan.devices.0.name)
refuses "a device that is not there" 2 "--device: there is no Vulkan device 1000; 'ddof devices' lists those" "$DDOF" render "$in" -o "$out" $lens --backend vulkan --device 1000
refuses "bench on a device that is not there" 2 "--device: there is no Vulkan device 1000; 'ddof devices' lists those" "$DDOF" bench --backend vulkan --device 1000
passes "the CPU's picture" "$DDOF" render "$in" -o "$work/cpu.exr" $lens -q
passes "render --backend vulkan" "$DDOF" render "$in" -o "$out" $lens --backend vulkan --json
has_members "vulkan: members" backend device device_index solver surface surface_bytes surface_bytes_per_pixel scratch_bytes solve_ms
check "vulkan: what they say" test "$(member backend) $(member device_index) $(member solver) $(member surface)" = "vulkan 0 line rgba16f"
check "vulkan: the device of the list" sh -c "case '$(member device)' in *'$name'*) ;; *) exit 1 ;; esac"
if member shared_chain >/dev/null 2>&1; then not_ok "vulkan: no shared chain"; else ok "vulkan: no shared chain"; fi
passes "render --device 0" "$DDOF" render "$in" -o "$out" $lens --backend vulkan --device 0 --json
passes "auto with a solver of Vulkan" "$DDOF" render "$in" -o "$out" $lens --backend auto --solver line --json
check "auto with a solver of Vulkan is vulkan" test "$(member backend)" = vulkan
passes "render --backend vulkan, for people" "$DDOF" render "$in" -o "$out" $lens --backend vulkan --surface rgba32f
check "vulkan, for people" grep -Eq '^vulkan: line, rgba32f, [0-9.]+ bytes of surfaces per pixel' "$work/out"
for solver in line pcr pcr3+sweep cr4+pack; do
    for surface in rgba16f rgba32f; do
        passes "--solver $solver --surface $surface" "$DDOF" render "$in" -o "$out" $lens --backend vulkan --solver $solver --surface $surface --json
        check "--solver $solver --surface $surface: named" test "$(member solver) $(member surface)" = "$solver $surface"
        "$DDOF" compare "$work/cpu.exr" "$out" --json >"$work/out" 2>/dev/null
        above "--solver $solver --surface $surface: near the CPU" 0.004 "$(member max_error)"
    done
done
row=$SOURCE/samples/row
"$DDOF" render "$row/pinhole.exr" -o "$work/row.exr" --camera "$row/scene.json" -q 2>"$work/err"
passes "the sample frame" "$DDOF" render "$row/pinhole.exr" -o "$out" --camera "$row/scene.json" --backend vulkan --json
passes "the sample frame: compared" "$DDOF" compare "$work/row.exr" "$out" --json
above "the sample frame: near the CPU" 0.01 "$(member max_error)"
above "the sample frame: PSNR" "$(member psnr)" 60
passes "coc --backend vulkan" "$DDOF" coc "$in" -o "$work/o/coc.exr" $lens --backend vulkan --device 0 --json
"$DDOF" coc "$in" -o "$work/coc.exr" $lens -q
near "coc --backend vulkan: near the CPU" "$("$FIXTURE" value "$work/o/coc.exr" CoC 63 40)" "$("$FIXTURE" value "$work/coc.exr" CoC 63 40)" 0.001
rm -f "$work/o/"*

# --- bench
small="--size 40x30 --runs 2 --backend vulkan"
measure="median_ms min_ms q1_ms q3_ms max_ms copy_ms copy_min_ms copy_q1_ms copy_q3_ms copy_ratio moved_bytes moved_bytes_per_pixel
    gigabytes_per_s copy_gigabytes_per_s megapixels_per_s scratch_bytes scratch_bytes_per_pixel plan.solver plan.dispatches
    plan.pixels_per_thread plan.workgroup plan.strip plan.subgroup"
where="machine compiler version commit backend device device_index driver is_software timing runs surface"
passes "bench" "$DDOF" bench $small --json
has_members "bench: members" $where $measure solver width height channels type in_place
check "bench: what they say" test "$(member backend) $(member solver) $(member surface) $(member runs) $(member device)" = "vulkan line rgba16f 2 $name"
near "bench: moved bytes" "$(member moved_bytes)" 48000 0
near "bench: ratio is the quotient" "$(member copy_ratio)" "$(awk -v a="$(member median_ms)" -v b="$(member copy_ms)" 'BEGIN { print a / b }')" "$(awk -v a="$(member copy_ratio)" 'BEGIN { print 0.01 * a }')"
near "bench: scratch per pixel" "$(member scratch_bytes_per_pixel)" "$(awk -v a="$(member scratch_bytes)" 'BEGIN { print a / 1200 }')" 0.001
software=$(member is_software)
passes "bench, auto with a solver of Vulkan" "$DDOF" bench --size 40x30 --runs 1 --backend auto --solver pcr --json
check "bench, auto with a solver of Vulkan: vulkan" test "$(member backend) $(member solver)" = "vulkan pcr"
for pair in "--surface rgba32f:72" "--type half:36" "--surface rgba32f --type half:68" "--substeps 2:80" --channels\ 3:40 --in-place:40 --depth:40 \
    "--depth --type half --in-place:36" "--conductance classic --coc 1000:40" "--solver pcr:40" "--solver pcr3+sweep:40" "--solver cr4+pack:40" "--size 1x1:40" \
    "--size 3x700:40" "--size 700x3:40"; do
    passes "bench ${pair%:*}" "$DDOF" bench $small ${pair%:*} --json
    near "bench ${pair%:*}: bytes per pixel" "$(member moved_bytes_per_pixel)" "${pair#*:}" 0
done
for pair in "highlights --append counter:highlights counter instanced" "full --append arguments:full arguments instanced"; do
    passes "bench --bokeh ${pair%:*}" "$DDOF" bench $small --coc 8 --bokeh ${pair%:*} --json
    check "bench --bokeh ${pair%:*}: named" test "$(member bokeh) $(member append) $(member quads)" = "${pair#*:}"
    if [ "$(member timing)" = timestamps ]; then has_members "bench --bokeh ${pair%:*}: members" append_ms draw_ms draw_append_ratio; fi
done
passes "bench --bokeh highlights" "$DDOF" bench $small --coc 8 --bokeh highlights --json
above "bench --bokeh highlights: a ratio" "$(member highlights_ratio)" 0
passes "bench, for people" "$DDOF" bench $small
for line in '^solver +line in [0-9]+ dispatch' '^solve +[0-9.]+ ms median' '^copy +[0-9.]+ ms median' '^ratio +[0-9.]+ times the copy' '^scratch +[0-9.]+ bytes per pixel'; do
    check "bench, for people: $line" grep -Eq "$line" "$work/out"
done
if [ "$software" = true ]; then
    check "bench: a software driver is said" grep -q 'computes on the CPU: its times say nothing about GPUs' "$work/out"
else
    skip "bench: a software driver is said" "this one is a GPU"
fi
passes "bench --quiet" "$DDOF" bench $small --quiet
check "bench --quiet prints nothing" test ! -s "$work/out"
refuses "bench: a picture too large" 1 '--backend vulkan: .*make --size smaller' "$DDOF" bench --backend vulkan --size 1000000x1 --runs 1

# --- the table
for format in markdown csv json; do
    passes "table, $format" "$DDOF" bench --table $small --format $format
    check "table, $format: pcr3+sweep" grep -q 'pcr3+sweep' "$work/out"
    [ $format != csv ] || check "table as CSV: as many fields in each line" awk -F'"' '{ gsub(/,/, "", $2); n = gsub(/,/, ",", $0) } NR == 1 { m = n } n != m { exit 1 }' "$work/out"
done
members=
for key in $measure; do members="$members rows.0.$key"; done
has_members "table: members" $where rows.0.width rows.0.height rows.0.solver $members
check "table: rows" test "$(for i in 0 1 2 3; do member rows.$i.solver; done | tr '\n' ' ')" = "line pcr pcr3+sweep cr4+pack "
passes "table --json --quiet" "$DDOF" bench --table $small --json --quiet --surface rgba32f --depth
check "table --json --quiet: surface" test "$(member surface)" = rgba32f
passes "table --quiet" "$DDOF" bench --table $small --quiet
check "table --quiet prints nothing" test ! -s "$work/out"
refuses "table: nothing can be done" 1 'no solver could do any of the sizes' "$DDOF" bench --table --backend vulkan --size 1000000x1 --runs 1 --quiet
done_testing
