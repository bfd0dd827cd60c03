# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# ddof render: what it writes and what it leaves alone.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
in=$work/in.exr
out=$work/o/out.exr
lens="--fstop 1.4 --focal-length 85 --focus 4"
make() { "$FIXTURE" make "$@"; }
value() { "$FIXTURE" value "$@"; }
make "$in" 160 90 float 32 R=noise G=0.25 B=ramp:0:4 A=1 Z=ramp:1:20 mask.Y=noise id.X=ramp:0:1000

# --- the result
passes "render" "$DDOF" render "$in" -o "$out" $lens
check "says what was done" grep -q "out.exr: 160x90, 85 mm f/1.4, focus 4, CoC" "$work/out"
check "says how long it took" grep -q '^solve .* ms' "$work/out"
check "says nothing on standard error" test ! -s "$work/err"
near "a constant channel stays constant" "$(value "$out" G 80 45)" 0.25 0.000001
near "alpha of 1 stays 1" "$(value "$out" A 3 3)" 1 0.000001
check "colour changes" sh -c "! '$FIXTURE' same '$in' '$out' R"
for channel in Z mask.Y id.X; do check "channel $channel is untouched" "$FIXTURE" same "$in" "$out" $channel; done
run "$FIXTURE" range "$out" R
above "the result lies within the picture's range (low)" "$(cut -d' ' -f1 "$work/out")" -0.000001
above "the result lies within the picture's range (high)" 1.000001 "$(cut -d' ' -f2 "$work/out")"
cp "$in" "$work/o/over.exr"
passes "output over the input" "$DDOF" render "$work/o/over.exr" -o "$work/o/over.exr" $lens -q
check "output over the input: the same result" "$FIXTURE" same "$out" "$work/o/over.exr" R
rm "$work/o/over.exr"

# --- how it is computed
for threads in 1 2 3 7; do
    passes "$threads threads" "$DDOF" render "$in" -o "$work/o/t.exr" $lens --threads $threads -q
    check "$threads threads: the same bits" cmp "$out" "$work/o/t.exr"
done
same_picture() { # DESCRIPTION: out.exr and t.exr differ by little
    run "$DDOF" compare "$out" "$work/o/t.exr" --json
    above "$1" 0.00004 "$(member max_error)"
}
passes "float64 reference" "$DDOF" render "$in" -o "$work/o/t.exr" $lens --backend reference -q
same_picture "the reference agrees"
for cpu in baseline all; do
    passes "--cpu $cpu" "$DDOF" render "$in" -o "$work/o/t.exr" $lens --cpu $cpu --backend cpu -q
    same_picture "--cpu $cpu agrees"
done
run "$DDOF" render "$in" -o "$work/o/t.exr" $lens --cpu baseline --json
check "--cpu baseline is what worked" test "$(member device)" != avx512
passes "matched by name" "$DDOF" render "$in" -o "$work/o/t.exr" $lens --conductance matched --substeps 1 --backend auto -q
check "matched and one substep are the defaults" cmp "$out" "$work/o/t.exr"
spread() { "$FIXTURE" range "$work/o/t.exr" R | awk '{ print $2 - $1 }'; }
matched=$(spread)
"$DDOF" render "$in" -o "$work/o/t.exr" $lens --conductance classic -q
above "classic blurs more" "$matched" "$(spread)"
passes "substeps" "$DDOF" render "$in" -o "$work/o/t.exr" $lens --substeps 3 -q
check "substeps change the result" sh -c "! '$FIXTURE' same '$out' '$work/o/t.exr' R"

# --- the disc kernel
for quality in draft good best; do
    passes "disc, $quality" "$DDOF" render "$in" -o "$work/o/$quality.exr" $lens --kernel disc --quality $quality --bokeh off --backend reference --json
    check "disc, $quality: reported" test "$(member kernel) $(member quality)" = "disc $quality"
    near "disc, $quality: a constant channel stays constant" "$(value "$work/o/$quality.exr" G 80 45)" 0.25 0.000001
    check "disc, $quality: not the heat kernel" sh -c "! '$FIXTURE' same '$out' '$work/o/$quality.exr' R"
done
check "qualities differ" sh -c "! '$FIXTURE' same '$work/o/good.exr' '$work/o/best.exr' R"
passes "disc" "$DDOF" render "$in" -o "$work/o/t.exr" $lens --kernel disc --bokeh off --backend reference -q
check "good is its default" cmp "$work/o/good.exr" "$work/o/t.exr"
passes "heat by name" "$DDOF" render "$in" -o "$work/o/t.exr" $lens --kernel heat --layers off -q
check "heat and one layer are the defaults" cmp "$out" "$work/o/t.exr"
rm "$work/o/draft.exr" "$work/o/good.exr" "$work/o/best.exr"

# --- a CoC instead of depth and lens
passes "coc to a file" "$DDOF" coc "$in" -o "$work/coc.exr" $lens -q
passes "render with it" "$DDOF" render "$in" -o "$work/o/t.exr" --coc "$work/coc.exr" -q
check "the same bits as with depth and lens" "$FIXTURE" same "$out" "$work/o/t.exr" R
passes "render with its channel" "$DDOF" render "$in" -o "$work/o/t.exr" --coc "$work/coc.exr:CoC" -q
check "the same bits again" "$FIXTURE" same "$out" "$work/o/t.exr" R
make "$work/zero.exr" 160 90 float 32 CoC=0
passes "CoC of zero" "$DDOF" render "$in" -o "$work/o/t.exr" --coc "$work/zero.exr" -q
run "$DDOF" compare "$in" "$work/o/t.exr" --json
above "CoC of zero leaves the picture alone" 0.000000000001 "$(member max_error)"
make "$work/radius.exr" 160 90 float 32 CoC=4
make "$work/diameter.exr" 160 90 float 32 CoC=8
"$DDOF" render "$in" -o "$work/o/a.exr" --coc "$work/radius.exr" --coc-scale 2 -q
"$DDOF" render "$in" -o "$work/o/b.exr" --coc "$work/diameter.exr" -q
check "--coc-scale 2 turns radii into diameters" "$FIXTURE" same "$work/o/a.exr" "$work/o/b.exr" R
make "$work/with.exr" 160 90 float 32 R=noise G=0.25 B=1 blur.size=8
passes "CoC in the picture itself" "$DDOF" render "$work/with.exr" -o "$work/o/t.exr" --coc :blur.size -q
check "CoC in the picture itself: the same" "$FIXTURE" same "$work/o/b.exr" "$work/o/t.exr" R

# --- layers and depth of other files
make "$work/layers.exr" 32 16 float 32 R=noise G=1 B=1 beauty.R=noise beauty.G=1 beauty.B=1 Z=ramp:1:20 other.Z=ramp:4:4.001
passes "layer" "$DDOF" render "$work/layers.exr" -o "$work/o/t.exr" --layer beauty $lens -q
check "the layer changes" sh -c "! '$FIXTURE' same '$work/layers.exr' '$work/o/t.exr' beauty.R"
check "the other colours do not" "$FIXTURE" same "$work/layers.exr" "$work/o/t.exr" R
passes "depth channel by name" "$DDOF" render "$work/layers.exr" -o "$work/o/t.exr" --depth :other.Z $lens --json
above "it is the one used" 0.1 "$(member coc_max_px)"
mkdir "$work/a:b"
cp "$work/layers.exr" "$work/a:b/z:1.exr"
passes "file names with colons" "$DDOF" render "$work/layers.exr" -o "$work/o/t.exr" --depth "$work/a:b/z:1.exr" $lens -q
passes "file names with colons, and a channel" "$DDOF" render "$work/layers.exr" -o "$work/o/t.exr" --depth "$work/a:b/z:1.exr:other.Z" $lens --json
above "the channel is the one used" 0.1 "$(member coc_max_px)"

# --- odd pictures
for size in "1 1" "1 33" "33 1" "2 2" "17 3"; do
    make "$work/odd.exr" $size float 32 R=noise G=0.5 B=0.5 Z=ramp:1:20
    passes "size $size" "$DDOF" render "$work/odd.exr" -o "$work/o/t.exr" $lens --max-coc 30 -q
    near "size $size: constant" "$(value "$work/o/t.exr" G 0 0)" 0.5 0.000001
done
make "$work/flat.exr" 32 16 float 32 R=noise G=0.5 B=0.5 Z=7
passes "all pixels of one depth" "$DDOF" render "$work/flat.exr" -o "$work/o/t.exr" $lens -q
for depth in nan inf -inf 0 -3; do
    make "$work/odd.exr" 32 16 float 32 R=noise G=0.5 B=0.5 "Z=7@5,5=$depth"
    passes "depth $depth" "$DDOF" render "$work/odd.exr" -o "$work/o/t.exr" $lens --json
    near "depth $depth: counted" "$(member nonfinite_pixels)" "$([ $depth = nan ] && echo 1 || echo 0)" 0
    near "depth $depth: contained" "$(value "$work/o/t.exr" G 5 5)" 0.5 0.00001
done
for color in nan inf -inf; do
    make "$work/odd.exr" 32 16 float 32 R=noise "G=0.5@5,5=$color" B=0.5 Z=7
    passes "colour $color" "$DDOF" render "$work/odd.exr" -o "$work/o/t.exr" $lens
    check "colour $color: a note names the file" grep -q 'ddof: note: .*odd.exr' "$work/err"
    near "colour $color: contained" "$(value "$work/o/t.exr" G 6 5)" 0.5 0.00001
    near "colour $color: filled" "$(value "$work/o/t.exr" G 5 5)" 0.5 0.00001
done
passes "colour: --quiet has no note" "$DDOF" render "$work/odd.exr" -o "$work/o/t.exr" $lens --quiet
check "--quiet prints nothing" sh -c "! cat '$work/out' '$work/err' | grep ."

# --- preview
passes "preview" "$DDOF" render "$in" -o "$work/o/t.exr" $lens --preview "$work/o/p.png"
check "preview is named" grep -q 'p.png: before and after' "$work/out"
run "$DDOF" info "$work/o/p.png" --json
near "preview is two pictures wide" "$(member parts.0.data_window.2)" 321 0
near "preview begins with the picture" "$(value "$work/o/p.png" B 20 45)" "$(value "$in" B 20 45)" 0.01
near "preview ends with the result" "$(value "$work/o/p.png" G 300 45)" 0.25 0.01
"$DDOF" render "$in" -o "$work/o/t.exr" $lens --preview "$work/o/p.png" --exposure 1 -q
near "preview with exposure" "$(value "$work/o/p.png" G 300 45)" 0.5 0.01

make "$work/wide.exr" 4000 3 float 32 R=0.5 G=ramp:0:1 B=0.5 Z=4
passes "preview of a wide picture" "$DDOF" render "$work/wide.exr" -o "$work/o/t.exr" $lens --preview "$work/o/p.png" -q
run "$DDOF" info "$work/o/p.png" --json
check "it is shown smaller" test "$(member parts.0.data_window)" = "[0,0,$((2 * 1334 + 13)),1]"
near "with the mean of its pixels" "$(value "$work/o/p.png" G 667 0)" 0.5 0.01

# --- interruption: a slow render is stopped, nothing is written, the code says so
rm -f "$work/o/"*
make "$work/large.exr" 2000 2000 half 16 R=noise G=noise B=noise Z=noise
for signal in INT TERM; do
    "$DDOF" render "$work/large.exr" -o "$out" $lens --substeps 64 --backend reference --quiet 2>"$work/err" &
    process=$!
    sleep 1.5
    kill -$signal $process
    wait $process
    status=$?
    near "SIG$signal: exit code 130" $status 130 0
    check "SIG$signal: says so in one line" sh -c "[ \"\$(cat '$work/err')\" = 'ddof: interrupted; nothing was written' ]"
    check "SIG$signal: nothing is left" sh -c "[ -z \"\$(ls -A '$work/o')\" ]"
done
if command -v script >/dev/null 2>&1; then
    script -qec "'$DDOF' render '$work/large.exr' -o '$out' $lens --substeps 20" /dev/null >"$work/out" 2>&1 </dev/null
    check "progress on a terminal" grep -q 'ddof: *[0-9]* %' "$work/out"
    script -qec "'$DDOF' render '$work/large.exr' -o '$out' $lens --quiet" /dev/null >"$work/out" 2>&1 </dev/null
    check "no progress with --quiet" test ! -s "$work/out"
else
    skip "progress on a terminal" "no script(1)"
fi
done_testing
