# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# What is printed: JSON members, numbers of compare and info, bench.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
make() { "$FIXTURE" make "$@"; }
in=$work/in.exr
out=$work/o/out.exr
lens="--fstop 2 --focal-length 50 --focus 4"
make "$in" 64 48 float 32 R=0.5 G=0.5 B=0.5 "Z=ramp:1:20@0,0=nan"

# --- render
passes "render --json" "$DDOF" render "$in" -o "$out" $lens --json --preview "$work/o/p.png"
has_members "render: members" solve_ms total_ms nonfinite_pixels decode_ms encode_ms prepare_ms preview_ms focus_distance \
    threads device backend peak_rss_bytes scratch_bytes output input preview coc_min_px coc_max_px width height channels
near "render: counts holes" "$(member nonfinite_pixels)" 1 0
near "render: focus" "$(member focus_distance)" 4 0
above "render: total is more than its parts" "$(member total_ms)" "$(awk -v a="$(member solve_ms)" -v b="$(member decode_ms)" -v c="$(member encode_ms)" 'BEGIN { print a + b + c }')"
check "render: output" test "$(member output)" = "$out"
passes "render --json --quiet" "$DDOF" render "$in" -o "$out" $lens --json --quiet
has_members "render --quiet: still the object" solve_ms
check "render --quiet: nothing else" test ! -s "$work/err"
passes "infinite focus" "$DDOF" render "$in" -o "$out" --fstop 2 --focus inf --json
check "infinite focus is null" test "$(member focus_distance)" = null
odd=$(printf '%s/na\377me "x" \\.exr' "$work/o")
passes "a file name of any bytes" "$DDOF" render "$in" -o "$odd" $lens --json
has_members "a file name of any bytes: still JSON" output
check "a file name of any bytes: valid UTF-8" sh -c "iconv -f utf-8 -t utf-8 <'$work/out' >/dev/null"
rm -f "$work/o/"*
refuses "control characters do not reach the terminal" 1 'a\?b\?\[31m' "$DDOF" info "$(printf 'a\nb\033[31m')"

# --- coc
passes "coc --json" "$DDOF" coc "$in" -o "$out" $lens --json
has_members "coc: members" coc_min_px coc_max_px in_focus_fraction focus_distance nonfinite_pixels width height input output
near "coc: holes" "$(member nonfinite_pixels)" 1 0
passes "coc --quiet" "$DDOF" coc "$in" -o "$out" $lens --quiet
check "coc --quiet prints nothing" test ! -s "$work/out"

# --- info
make "$work/many.exr" 32 16 half 16 window=4,2,64,32 beauty.R=1 beauty.G=1 beauty.B=1 beauty.A=1 depth.Z=5
passes "info" "$DDOF" info "$work/many.exr"
check "info: windows" grep -q 'data window 32x16 at 4,2; display window 64x32 at 0,0' "$work/out"
check "info: colour" grep -q '^colour: beauty.R beauty.G beauty.B beauty.A' "$work/out"
check "info: depth" grep -q '^depth: depth.Z, 5 to 5' "$work/out"
passes "info --json" "$DDOF" info "$work/many.exr" --json
has_members "info: members" file format parts.0.name parts.0.view parts.0.storage parts.0.compression parts.0.bits parts.0.deep \
    parts.0.data_window parts.0.display_window parts.0.pixel_aspect parts.0.channels.0.name parts.0.channels.0.type color.part \
    color.channels color.alpha color.prefix depth.file depth.part depth.channels depth.min depth.max depth.distances \
    depth.infinitely_far depth.nan
check "info: colour in order" test "$(member color.channels)" = '["beauty.R","beauty.G","beauty.B","beauty.A"]'
make "$work/holes.exr" 8 4 float 32 R=1 G=1 B=1 "Z=7@1,1=nan"
run "$DDOF" info "$work/holes.exr" --json
near "info: NaN depth is counted" "$(member depth.nan)" 1 0
make "$work/holes.exr" 8 4 float 32 R=1 G=1 B=1 "Z=7@1,1=inf"
run "$DDOF" info "$work/holes.exr" --json
near "info: infinite depth is counted" "$(member depth.infinitely_far)" 1 0
make "$work/only.exr" 8 4 float 32 R=1 G=1 B=1
run "$DDOF" info "$work/only.exr" --json
check "info: no depth is null" test "$(member depth)" = null
run "$DDOF" info "$work/only.exr"
check "info: no depth, and the remedy" grep -q '^depth: none; give one with --depth FILE' "$work/out"
passes "info of another depth file" "$DDOF" info "$work/only.exr" --depth "$work/holes.exr:Z"
check "info names the other file" grep -q 'depth: Z of .*holes.exr, 7 to 7' "$work/out"
passes "info --layer" "$DDOF" info "$work/many.exr" --layer beauty
passes "info --quiet" "$DDOF" info "$work/many.exr" --quiet --threads 1
check "info --quiet prints nothing" test ! -s "$work/out"

# --- compare
passes "compare with itself" "$DDOF" compare "$in" "$in" --json
has_members "compare: members" psnr ssim psnr_tonemapped ssim_tonemapped max_error
near "equal: PSNR" "$(member psnr)" 999 0
near "equal: SSIM" "$(member ssim)" 1 0.000001
near "equal: error" "$(member max_error)" 0 0
make "$work/a.exr" 64 48 float 32 R=0.5 G=0.5 B=0.5
make "$work/b.exr" 64 48 float 32 R=0.6 G=0.6 B=0.6
passes "compare" "$DDOF" compare "$work/a.exr" "$work/b.exr" --json
near "0.1 apart: error" "$(member max_error)" 0.1 0.00001
near "0.1 apart: PSNR" "$(member psnr)" 20 0.001
near "0.1 apart: pixels" "$(member pixels)" 3072 0
check "compare: one number in both directions" test "$(member max_error)" = "$("$DDOF" compare "$work/b.exr" "$work/a.exr" --json | "$FIXTURE" json max_error)"
passes "compare, for people" "$DDOF" compare "$work/a.exr" "$work/b.exr"
check "compare, for people: table" grep -q '^all  *3072 ' "$work/out"
make "$work/c.exr" 64 48 float 32 R=ramp:0:1 G=0.5 B=0.5
make "$work/mask.png" 64 48 float 8 Y=ramp:0:1
passes "compare with a mask" "$DDOF" compare "$work/a.exr" "$work/c.exr" --mask "$work/mask.png" --json
has_members "compare: regions" regions.0.psnr regions.1.ssim regions.0.pixels
check "compare: names of regions" test "$(member regions.0.name) $(member regions.1.name)" = "inside outside"
near "compare: regions are all pixels" "$(($(member regions.0.pixels) + $(member regions.1.pixels)))" 3072 0
above "compare: both regions have pixels" "$(member regions.1.pixels)" 100
make "$work/full.png" 64 48 float 8 Y=1
passes "compare with a full mask" "$DDOF" compare "$work/a.exr" "$work/b.exr" --mask "$work/full.png" --json
check "compare: a full mask is everything" test "$(member psnr)" = "$(member regions.0.psnr)"
check "compare: nothing outside is null" test "$(member regions.1.psnr)" = null
passes "compare with a full mask, for people" "$DDOF" compare "$work/a.exr" "$work/b.exr" --mask "$work/full.png"
make "$work/hole.exr" 64 48 float 32 "R=0.5@9,9=nan" G=0.5 "B=0.5@3,3=inf"
passes "compare with holes" "$DDOF" compare "$work/a.exr" "$work/hole.exr" --json
near "compare: holes do not count" "$(member max_error)" 0 0
near "compare: holes are counted" "$(member nonfinite_pixels)" 2 0
check "compare: holes are said" grep -q 'note: 2 pixels are NaN or infinite in .*a.exr or .*hole.exr' "$work/err"
rm -f "$work/o/"*
make "$work/none.exr" 64 48 float 32 R=nan G=nan B=nan
refuses "compare with nothing but holes" 1 'none.exr: no pixel is finite in both' "$DDOF" compare "$work/a.exr" "$work/none.exr"
make "$work/grey.exr" 64 48 float 32 Y=0.5
run "$DDOF" compare "$work/a.exr" "$work/grey.exr" --json
near "grey is the same in R, G and B" "$(member max_error)" 0 0
make "$work/layer.exr" 64 48 float 32 x.R=0.5 x.G=0.5 x.B=0.5 R=0 G=0 B=0
passes "compare --layer" "$DDOF" compare "$work/layer.exr" "$work/layer.exr" --layer x --json
make "$work/a.png" 64 48 float 16 R=0.5 G=0.5 B=0.5
run "$DDOF" compare "$work/a.exr" "$work/a.png" --json
near "formats can be compared" "$(member max_error)" 0 0.0001
passes "compare --quiet" "$DDOF" compare "$in" "$in" --quiet --threads 1
check "compare --quiet prints nothing" test ! -s "$work/out"

# --- solvers: the published megabytes of 1600x1200 are 132, 102, 73, 58
passes "solvers" "$DDOF" solvers
for row in 'cr .* 131.[0-9]$' 'cr.pack .* 102.[0-9]$' 'cr4 .* 72.9$' 'cr4.pack .* 58.[0-9]$'; do
    check "solvers: $row" grep -Eq "^$row" "$work/out"
done
passes "solvers --json" "$DDOF" solvers --size 7x1 --json
has_members "solvers: members" channels solvers.0.name solvers.0.title solvers.0.source solvers.0.passes \
    solvers.0.operations_per_pixel solvers.0.bytes_per_pixel solvers.0.surface_bytes solvers.0.column.bytes
check "solvers: unknowns of a row of 7" test "$(member solvers.2.row.unknowns)" = '[[3,2],[7,1]]'
near "solvers: size" "$(member width)" 7 0
passes "solvers --quiet" "$DDOF" solvers --quiet
check "solvers --quiet prints nothing" test ! -s "$work/out"
refuses "solvers --threads" 2 "--threads: not an option of .ddof solvers." "$DDOF" solvers --threads 2

# --- bench (numbers are never judged here)
small="--size 320x180 --runs 3"
passes "bench" "$DDOF" bench $small
check "bench: machine, compiler, version first" sh -c "head -1 '$work/out' | grep -Eq '; (gcc|clang) .*; ddof [0-9]'"
check "bench: ratio" grep -Eq '^ratio +[0-9.]+ times the memcpy' "$work/out"
passes "bench --json" "$DDOF" bench $small --json
has_members "bench: members" median_ms min_ms memcpy_ms memcpy_ratio megapixels_per_s scratch_bytes backend device threads q1_ms q3_ms \
    max_ms memcpy_min_ms runs width height channels type layout in_place machine compiler version commit peak_rss_bytes
near "bench: ratio is the quotient" "$(member memcpy_ratio)" "$(awk -v a="$(member median_ms)" -v b="$(member memcpy_ms)" 'BEGIN { print a / b }')" 0.5
near "bench: size" "$(member width)" 320 0
passes "bench --threads" "$DDOF" bench $small --threads 2 --json
near "bench: threads" "$(member threads)" 2 0
for options in "--type half" "--layout planar" "--channels 1" "--channels 2" "--channels 3 --layout planar --type half" --in-place --depth \
    "--conductance classic" "--substeps 2" "--backend cpu" "--backend reference" "--cpu baseline" "--coc 0" "--coc 1000" "--size 1x1" "--size 3x700"; do
    passes "bench $options" "$DDOF" bench $small $options --json
    has_members "bench $options: members" median_ms memcpy_ratio
done
passes "bench --quiet" "$DDOF" bench $small --quiet
check "bench --quiet prints nothing" test ! -s "$work/out"
done_testing
