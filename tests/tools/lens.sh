# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# ddof coc: depth, lens and focus give the CoC they should (formulas: docs/cli.md, include/ddof/ddof.h).
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
out=$work/o/coc.exr
make() { "$FIXTURE" make "$@"; }
in=$work/in.exr
make "$in" 101 60 float 32 R=0.5 G=0.5 B=0.5 Z=ramp:1:21 # column x lies at 1 + x/5
pixel() { # OPTIONS... : the CoC of column $x in row $y
    "$DDOF" coc "$in" -o "$out" -q "$@" >"$work/out" 2>"$work/err" || { cat "$work/err" >&2; echo failed; return; }
    "$FIXTURE" value "$out" CoC "$x" "$y"
}
thin() { # z s f N sensor width: thin lens, millimetres and metres
    awk -v z="$1" -v s="$2" -v f="$3" -v n="$4" -v w="$5" -v p="$6" 'BEGIN { f /= 1000; print f/n * (z-s)/z * f/(s-f) * p / (w/1000) }'
}
y=30

# --- a lens
lens="--fstop 2 --focal-length 85 --focus 5"
for x in 0 5 19 21 50 100; do
    z=$(awk -v x=$x 'BEGIN { print 1 + x / 5 }')
    near "thin lens at $z m" "$(pixel $lens)" "$(thin "$z" 5 85 2 36 101)" 0.0005
done
x=20; near "sharp at the focus" "$(pixel $lens)" 0 0.0001
x=100
near "sensor width" "$(pixel $lens --sensor-width 24)" "$(thin 21 5 85 2 24 101)" 0.0005
near "50 mm is assumed" "$(pixel --fstop 2 --focus 5)" "$(thin 21 5 50 2 36 101)" 0.0005
near "f-number" "$(pixel $lens --fstop 8)" "$(thin 21 5 85 8 36 101)" 0.0005
near "centimetres" "$(pixel --fstop 2 --focal-length 85 --focus 15 --unit 10)" "$(awk 'BEGIN { f=8.5; print f/2*(21-15)/21*f/(15-f)*101/3.6 }')" 0.005
near "focus at infinity, far" "$(pixel --fstop 2 --focal-length 85 --focus inf)" "$(awk 'BEGIN { f=.085; print -f/2*f/21*101/.036 }')" 0.0005
near "range in focus: sharp inside" "$(x=24 pixel $lens --focus-range 2)" 0 0.0001
near "range in focus: from its end" "$(pixel $lens --focus-range 2)" "$(awk 'BEGIN { f=.085; print f/2*(21-6)/21*f/(5-f)*101/.036 }')" 0.005

# --- focus at a pixel
x=100
near "focus at a pixel" "$(pixel --fstop 2 --focal-length 85 --focus-at 20,30)" "$(thin 21 5 85 2 36 101)" 0.0005
near "focus at a place" "$(pixel --fstop 2 --focal-length 85 --focus-at 20%,50%)" "$(thin 21 5 85 2 36 101)" 0.0005
near "focus at the far corner" "$(x=0 pixel --fstop 2 --focal-length 85 --focus-at 100%,100%)" "$(thin 1 21 85 2 36 101)" 0.0005
run "$DDOF" coc "$in" -o "$out" --fstop 2 --focus-at 20,30 --json
near "the distance focused on is reported" "$(member focus_distance)" 5 0.00001

# --- limits of a lens
x=0
near "limit in pixels" "$(pixel $lens --max-coc 3)" -3 0.0001
near "limit in percent" "$(pixel $lens --max-coc 2%)" -2.02 0.0001
near "limit of the near side" "$(pixel $lens --max-coc-near 3)" -3 0.0001
near "limit of the far side only" "$(pixel $lens --max-coc-far 3)" "$(thin 1 5 85 2 36 101)" 0.001
near "near side kept sharp" "$(pixel $lens --max-coc-near 0)" 0 0.0001
near "one side over both" "$(pixel $lens --max-coc 9 --max-coc-near 3)" -3 0.0001
x=100
near "limit of the far side" "$(pixel $lens --max-coc-far 1)" 1 0.0001

# --- no lens, but the blur itself: tends to max far behind, reaches max at half the focus distance before
blur="--focus 8 --max-coc-near 6 --max-coc-far 10"
near "blur, far" "$(pixel $blur)" "$(awk 'BEGIN { print 10 * (21 - 8) / 21 }')" 0.0005
x=15; near "blur, at half the focus distance" "$(pixel $blur)" -6 0.0005
x=0; near "blur, nearer than that" "$(pixel $blur)" -6 0.0005
near "blur, one number for both sides" "$(pixel --focus 8 --max-coc 4)" -4 0.0005
near "blur, only far" "$(pixel --focus 8 --max-coc-far 4)" 0 0.0005
near "blur in percent" "$(pixel --focus 8 --max-coc 4%)" -4.04 0.0005

# --- kinds of depth: each describes 21 m at the right and 1 m at the left
lens="--fstop 2 --focal-length 85 --focus 5"
x=100
make "$in" 101 60 float 32 R=1 G=1 B=1 Z=ramp:1:0.047619047619
near "inverse depth" "$(pixel $lens --depth-kind inverse)" "$(thin 21 5 85 2 36 101)" 0.001
make "$in" 101 60 float 32 R=1 G=1 B=1 Z=ramp:0:1
near "normalized depth" "$(pixel $lens --depth-kind normalized --near 1 --far 21)" "$(thin 21 5 85 2 36 101)" 0.001
near "device depth" "$(pixel $lens --depth-kind device --near 1 --far 21)" "$(thin 21 5 85 2 36 101)" 0.001
near "device depth, infinite far end" "$(pixel $lens --depth-kind device --near 1 --far inf)" "$(thin 1e12 5 85 2 36 101)" 0.001
near "normalized depth, white is near" "$(pixel $lens --depth-kind normalized --near 21 --far 1)" "$(thin 1 5 85 2 36 101)" 0.005
near "device depth, reversed" "$(pixel $lens --depth-kind device --near inf --far 1)" "$(thin 1 5 85 2 36 101)" 0.005
x=50
near "normalized depth is linear" "$(pixel $lens --depth-kind normalized --near 1 --far 21)" "$(thin 11 5 85 2 36 101)" 0.001
near "device depth is 1/z" "$(pixel $lens --depth-kind device --near 1 --far 21)" "$(thin 1.9090909 5 85 2 36 101)" 0.001
make "$in" 101 60 float 32 R=1 G=1 B=1 Z=10
x=50 y=29
ray=$(awk 'BEGIN { p=36/101; t=(29.5-30)*p; print 10*85/sqrt(85*85+t*t) }')
near "ray depth, middle" "$(pixel $lens --depth-kind ray)" "$(thin "$ray" 5 85 2 36 101)" 0.0005
x=0 y=0
ray=$(awk 'BEGIN { p=36/101; s=(0.5-50.5)*p; t=(0.5-30)*p; print 10*85/sqrt(85*85+s*s+t*t) }')
near "ray depth, corner" "$(pixel $lens --depth-kind ray)" "$(thin "$ray" 5 85 2 36 101)" 0.0005
near "ray depth without a lens" "$(pixel --focus 5 --max-coc 10 --depth-kind ray --focal-length 85)" "$(awk -v z="$ray" 'BEGIN { print 10*(z-5)/z }')" 0.0005

# --- depth that is no distance
y=0
for value in 0 -5 inf; do
    make "$in" 101 60 float 32 R=1 G=1 B=1 "Z=3@7,0=$value"
    x=7; near "depth $value is infinitely far" "$(pixel $lens)" "$(thin 1e12 5 85 2 36 101)" 0.0005
done

# --- windows: a part of the picture has the blur of the whole
make "$work/whole.exr" 100 60 float 32 R=1 G=1 B=1 Z=down:1:20
make "$work/part.exr" 40 30 float 32 window=30,20,100,60 R=1 G=1 B=1
in=$work/part.exr
x=0 y=0
near "depth that covers more is cut to the window" "$(pixel $lens --depth "$work/whole.exr")" "$(thin "$(awk 'BEGIN { print 1 + 19 * 20 / 59 }')" 5 85 2 36 100)" 0.001
run "$DDOF" info "$out" --json
check "the CoC keeps the window" test "$(member parts.0.data_window)$(member parts.0.display_window)" = "[30,20,40,30][0,0,100,60]"
make "$work/part.exr" 40 30 float 32 window=30,20,100,60 R=1 G=1 B=1 Z=ramp:1:21
x=39
near "the width is the picture's" "$(pixel $lens)" "$(thin 21 5 85 2 36 100)" 0.001
near "focus at a pixel counts in the picture" "$(x=0 pixel --fstop 2 --focal-length 85 --focus-at 69,49)" "$(thin 1 21 85 2 36 100)" 0.001
in=$work/whole.exr
make "$work/over.exr" 120 80 float 32 window=-10,-10,100,60 R=noise G=1 B=1 Z=3
in=$work/over.exr
x=0
near "overscan" "$(pixel $lens)" "$(thin 3 5 85 2 36 100)" 0.001
passes "render with overscan" "$DDOF" render "$in" -o "$work/o/over.exr" $lens -q
run "$DDOF" info "$work/o/over.exr" --json
check "overscan is kept" test "$(member parts.0.data_window)" = "[-10,-10,120,80]"
done_testing
