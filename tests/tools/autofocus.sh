# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# Autofocus: the median of a region in dioptres, whatever depth means, and its mean over frames, which does not depend on the
# frames that a process works on.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
in=$work/in.exr
out=$work/o/c.exr
lens="--fstop 2 --focal-length 85"
calc() { awk "BEGIN { printf \"%.9g\", $1 }"; }
make() { "$FIXTURE" make "$@"; }
focus() { # REGION [OPTIONS]: the distance focused on
    region=$1
    shift
    run "$DDOF" coc "$in" -o "$out" --json $lens --autofocus "$region" "$@"
    member focus_distance
}

# --- the region; columns are 0.2 apart in depth
make "$in" 101 60 float 32 R=1 G=1 B=1 Z=ramp:1:21
near "the middle of eleven columns" "$(focus 10,5,11x4)" 4 1e-5
near "the middle of ten, in dioptres" "$(focus 10,5,10x4)" "$(calc '1/(.5/3.8 + .5/4)')" 1e-5
near "the whole picture" "$(focus 0,0,100%x100%)" 11 1e-5
near "one pixel" "$(focus 20,30,1x1)" 5 1e-5
near "whatever it touches" "$(focus 20.5,30,1x1)" "$(calc '1/(.5/5 + .5/5.2)')" 1e-5
near "percent" "$(focus 9.901%,10%,10.891%x5%)" 4 1e-5
near "as far as the picture goes" "$(focus 90,50,500x500)" 20 1e-5
near "the CoC is that of such a focus" "$(member coc_max_px)" "$(calc '.085/2*(21-20)/21*.085/(20-.085)*101/.036')" 0.001
make "$in" 101 60 float 32 R=1 G=1 B=1 Z=down:1:60
near "rows" "$(focus 3,10,1x5)" 13 1e-5
for value in nan 0 -3 inf 1e-3; do
    make "$in" 101 60 float 32 R=1 G=1 B=1 "Z=5@20,20=$value"
    near "one pixel of $value among others" "$(focus 19,19,3x3)" 5 1e-5
done
make "$in" 101 60 float 32 R=1 G=1 B=1 "Z=5@20,20=nan"
near "a pixel without depth does not count" "$(focus 20,20,2x1)" 5 1e-5
make "$in" 101 60 float 32 R=1 G=1 B=1 Z=0
check "the sky" test "$(focus 20,20,5x5)" = null
make "$in" 101 60 half 16 R=1 G=1 B=1 Z=ramp:1:21
near "half floats" "$(focus 10,5,11x4)" 4 0.002

# --- what depth means
make "$in" 101 60 float 32 R=1 G=1 B=1 Z=ramp:0.1:1.1
near "inverse" "$(focus 10,5,11x4 --depth-kind inverse)" 4 1e-5
make "$in" 101 60 float 32 R=1 G=1 B=1 Z=ramp:0:1
near "normalized" "$(focus 10,5,11x4 --depth-kind normalized --near 1 --far 21)" 4 1e-5
near "device" "$(focus 10,5,11x4 --depth-kind device --near 1 --far 21)" "$(calc '1/(.85 + .15/21)')" 1e-5
near "device, reversed and infinite" "$(focus 10,5,11x4 --depth-kind device --near inf --far 1)" "$(calc 1/.15)" 1e-5
make "$in" 101 60 float 32 R=1 G=1 B=1 Z=10
ray=$(calc '10*85/sqrt(85^2 + ((0.5-50.5)*36/101)^2 + ((0.5-30)*36/101)^2)')
near "ray, in the corner" "$(focus 0,0,1x1 --depth-kind ray)" "$ray" 1e-5
near "another sensor" "$(focus 0,0,1x1 --depth-kind ray --sensor-width 18)" "$(calc '10*85/sqrt(85^2 + ((0.5-50.5)*18/101)^2 + ((0.5-30)*18/101)^2)')" 1e-5
printf '{"focal-length": [[1, 85]]}' >"$work/k.json"
run "$DDOF" coc "$in" -o "$out" --json --fstop 2 --autofocus 0,0,1x1 --depth-kind ray --animate "$work/k.json"
near "the animated focal length is known" "$(member focus_distance)" "$ray" 1e-5
make "$in" 101 60 float 32 R=1 G=1 B=1 Z=400
near "centimetres" "$(focus 3,3,5x5 --unit 10)" 400 0.001
near "kilometres" "$(focus 3,3,5x5 --unit 1e6)" 400 0.001
run "$DDOF" coc "$in" -o "$out" --json --autofocus 3,3,5x5 --max-coc 10
near "without a lens" "$(member focus_distance)" 400 0.001
make "$work/d.exr" 101 60 float 32 Depth=7
make "$in" 101 60 float 32 R=1 G=1 B=1
near "depth of another file" "$(focus 3,3,5x5 --depth "$work/d.exr")" 7 1e-5

# --- windows: the region is one of the picture
make "$in" 40 30 float 32 window=30,20,101,60 R=1 G=1 B=1 Z=ramp:1:40
near "a data window" "$(focus 40,25,11x2)" 16 1e-5
near "cut to it" "$(focus 0,0,35x100%)" 3 1e-5
make "$in" 121 80 float 32 window=-10,-10,101,60 R=1 G=1 B=1 Z=ramp:1:121
near "overscan" "$(focus 0,0,1x1)" 11 1e-5
rm -f "$work/o/"*
make "$in" 40 30 float 32 window=30,20,101,60 R=1 G=1 B=1 Z=1
refuses "no pixel of it" 1 '--autofocus: .*in.exr: has no depth in the region 0,0,9x9; choose another' "$DDOF" coc "$in" -o "$out" $lens --autofocus 0,0,9x9

# --- over frames: 1 2 3 2 1, of those that are there
mkdir "$work/s"
depth() { case $1 in 1) echo 2 ;; 2) echo 4 ;; 3) echo 3 ;; 4) echo 10 ;; 5) echo 5 ;; 7) echo 2.5 ;; esac; }
for n in 1 2 3 4 5 7; do make "$work/s/a.000$n.exr" 32 16 float 32 R=noise G=1 B=1 "Z=$(depth $n)"; done
shot() { # REACH [OPTIONS]: FRAME DISTANCE of each
    reach=$1
    shift
    "$DDOF" coc "$work/s/a.####.exr" -o "$work/o/c.####.exr" --json $lens --autofocus 25%,25%,50%x50% --focus-smooth $reach "$@" \
        2>"$work/err" | sed -n 's/.*"focus_distance":\([^,]*\),.*"frame":\([0-9]*\),.*/\2 \1/p'
}
of() { awk -v n="$1" '$1 == n { print $2 }' "$work/$2"; }
shot 2 >"$work/all"
near "all five" "$(of 3 all)" "$(calc '9/(1/2 + 2/4 + 3/3 + 2/10 + 1/5)')" 1e-5
near "at the beginning" "$(of 1 all)" "$(calc '6/(3/2 + 2/4 + 1/3)')" 1e-5
near "at the end, one is missing" "$(of 7 all)" "$(calc '4/(3/2.5 + 1/5)')" 1e-5
near "one is missing in the middle" "$(of 5 all)" "$(calc '7/(1/3 + 2/10 + 3/5 + 1/2.5)')" 1e-5
shot 0 >"$work/sharp"
near "none beside it" "$(of 3 sharp)" 3 1e-5
shot 1000 >"$work/wide"
near "far beyond the shot" "$(of 4 wide)" "$(calc '(1001+1000*2+999+998*2)/(998/2 + 999/4 + 1000/3 + 1001/10 + 1000/5 + 998/2.5)')" 1e-5
: >"$work/single"
for n in 1 2 3 4 5 7; do shot 2 --frames $n >>"$work/single"; done
check "every frame by itself focuses the same" cmp "$work/all" "$work/single"
shot 2 --in-flight 5 --threads 4 >"$work/many"
check "so do many at a time" cmp "$work/all" "$work/many"
shot 2 --frames 1-5x2 >"$work/odd"
near "a list that leaves some out" "$(of 3 odd)" "$(of 3 all)" 0
for n in 1 2 3 4 5 7; do make "$work/s/z.000$n.exr" 32 16 float 32 Z="$(calc "2*$(depth $n)")"; done
shot 2 --depth "$work/s/z.####.exr" --frames 3 >"$work/other"
near "neighbours have depth files of their own" "$(of 3 other)" "$(calc "2*$(of 3 all)")" 1e-4
again() { # which frames are made again
    "$DDOF" coc "$work/s/a.####.exr" -o "$work/o/r.####.exr" --json $lens --autofocus 25%,25%,50%x50% --focus-smooth 1 --resume |
        sed -n 's/.*"frame":\([0-9]*\),"status":"rendered".*/\1/p' | tr '\n' ' '
}
check "all at first" test "$(again)" = "1 2 3 4 5 7 "
check "none again" test "$(again)" = ""
make "$work/s/a.0004.exr" 32 16 float 32 R=noise G=1 B=1 Z=11
check "a neighbour that changes changes the frames beside it" test "$(again)" = "3 4 5 "
make "$work/s/a.0004.exr" 32 16 float 32 R=1 G=1 B=1 Z=nan
shot 2 --keep-going >"$work/hole"
near "a neighbour without depth is left out" "$(of 3 hole)" "$(calc '7/(1/2 + 2/4 + 3/3 + 1/5)')" 1e-5
check "but cannot be focused itself" grep -q 'frame 4: --autofocus: .*a.0004.exr: has no depth in the region' "$work/err"
"$FIXTURE" header "$work/s/a.0004.exr" 32 16
shot 2 --keep-going >"$work/broken"
check "a damaged neighbour is an error" grep -q '^ddof: frame 3: .*a.0004.exr: ' "$work/err"
near "not for those out of reach" "$(of 7 broken)" "$(of 7 all)" 0
rm -rf "$work/o"
mkdir "$work/o"

# --- what is wrong with the command
make "$in" 32 16 float 32 R=1 G=1 B=1 Z=3
for region in 3 3,4 3,4,5 3,4,5x 3,4x5,6 3,4,5x6x7 3,4,5x6,7 a,4,5x6 ,4,5x6 3,4,nanx6 '3, 4,5x6' 3%%,4,5x6 inf,4,5x6; do
    refuses "region $region" 2 "--autofocus: '.*' is not X,Y,WxH; write it like --autofocus 40%,40%,20%x20%" "$DDOF" coc "$in" -o "$out" $lens --autofocus "$region"
done
for region in -1,4,5x6 3,4,0x6 3,4,5x0% 3,101%,5x6 3,4,101%x6 3,4,2e6x6; do
    refuses "region $region" 2 "--autofocus: '.*' in $region is out of range" "$DDOF" coc "$in" -o "$out" $lens --autofocus "$region"
done
refuses "outside of the picture" 2 '--autofocus: 32,0,5x5 lies outside of .*in.exr, which is 32x16' "$DDOF" coc "$in" -o "$out" $lens --autofocus 32,0,5x5
refuses "with --focus" 2 '--autofocus: cannot be used together with --focus;' "$DDOF" coc "$in" -o "$out" $lens --autofocus 3,3,5x5 --focus 3
refuses "with --focus-at" 2 '--autofocus: cannot be used together with --focus-at;' "$DDOF" coc "$in" -o "$out" $lens --autofocus 3,3,5x5 --focus-at 3,3
refuses "with --coc" 2 '--autofocus: cannot be used together with --coc' "$DDOF" coc "$in" -o "$out" --coc :Z --autofocus 3,3,5x5
refuses "--focus-smooth without it" 2 '--focus-smooth: needs --autofocus too' "$DDOF" coc "$in" -o "$out" $lens --focus-smooth 3
refuses "--focus-smooth of one picture" 2 '--focus-smooth: is for several frames; give IN a pattern' "$DDOF" coc "$in" -o "$out" $lens --focus-smooth 3 --autofocus 3,3,5x5
for value in -1 1.5 1001 x; do
    refuses "--focus-smooth $value" 2 '--focus-smooth: .*(out of range|whole number)' "$DDOF" coc "$work/s/a.####.exr" -o "$work/o/c.####.exr" $lens --autofocus 3,3,5x5 --focus-smooth=$value
done
make "$in" 32 16 float 32 R=1 G=1 B=1 Z=0
refuses "the sky without a lens" 2 '--autofocus: inf needs a lens' "$DDOF" coc "$in" -o "$out" --autofocus 3,3,5x5 --max-coc 10
make "$in" 32 16 float 32 R=1 G=1 B=1 Z=0.05
refuses "inside the focal length" 2 '--autofocus: 0.05 \(50 mm\) lies inside the focal length' "$DDOF" coc "$in" -o "$out" $lens --autofocus 3,3,5x5
make "$in" 32 16 float 32 R=1 G=1 B=1
refuses "no depth" 1 'in.exr: .*--depth' "$DDOF" coc "$in" -o "$out" $lens --autofocus 3,3,5x5
done_testing
