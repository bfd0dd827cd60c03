# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# Formats in and out of the command: what is kept, converted and said.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
make() { "$FIXTURE" make "$@"; }
value() { "$FIXTURE" value "$@"; }
info() { # KEY: of a file
    file=$1
    shift
    run "$DDOF" info "$file" --json
    member "$1"
}
lens="--fstop 1.4 --focal-length 85 --focus 4"
make "$work/z.exr" 96 64 float 32 Z=ramp:1:20
make "$work/in.exr" 96 64 half 16 R=noise G=0.25 B=2 A=1 Z=3
make "$work/in.float.exr" 96 64 float 32 R=noise G=0.25 B=2 A=1 Z=3
make "$work/in.8.png" 96 64 float 8 R=noise G=0.25 B=0.75 A=1
make "$work/in.16.png" 96 64 float 16 R=noise G=0.25 B=0.75
make "$work/in.8.tif" 96 64 float 8 R=noise G=0.25 B=0.75
make "$work/in.16.tif" 96 64 float 16 R=noise G=0.25 B=0.75
make "$work/in.half.tif" 96 64 half 16 R=noise G=0.25 B=2
make "$work/in.32.tif" 96 64 float 32 R=noise G=0.25 B=2 A=1
make "$work/in.pfm" 96 64 float 32 R=noise G=0.25 B=2
make "$work/grey.png" 96 64 float 8 Y=0.25
make "$work/grey.pfm" 96 64 float 32 Y=0.25

# --- every format in, every format out
for input in in.exr in.float.exr in.8.png in.16.png in.8.tif in.16.tif in.half.tif in.32.tif in.pfm grey.png grey.pfm; do
    for ending in exr png tif tiff pfm; do
        out=$work/o/out.$ending
        passes "$input to $ending" "$DDOF" render "$work/$input" -o "$out" --depth "$work/z.exr" $lens
        case $input in grey*) channel=Y ;; *) channel=G ;; esac
        near "$input to $ending: colour" "$(value "$out" $channel 40 30)" 0.25 0.003
        rm -f "$out"
    done
done
bits() { # INPUT OUTPUT BITS TYPE
    "$DDOF" render "$work/$1" -o "$work/o/$2" --depth "$work/z.exr" $lens -q
    check "$1 to $2 has $3 bits" test "$(info "$work/o/$2" parts.0.bits)" = "$3"
    # (TIFF of any kind is float in memory)
    check "$1 to $2 is $4" test "$(info "$work/o/$2" parts.0.channels.0.type)" = "$4"
    rm -f "$work/o/$2"
}
bits in.exr a.exr 16 half
bits in.float.exr a.exr 32 float
bits in.8.png a.png 8 float
bits in.16.png a.png 16 float
bits in.8.tif a.tif 8 float
bits in.half.tif a.tif 16 float
bits in.32.tif a.tif 32 float
bits in.exr a.png 16 float
bits in.8.png a.exr 16 half
bits in.16.png a.exr 32 float
bits in.8.png a.tif 8 float
bits in.exr a.tif 16 float
bits in.exr a.pfm 32 float

# --- what is lost is said, unless --quiet
passes "EXR to PNG" "$DDOF" render "$work/in.exr" -o "$work/o/a.png" $lens
check "says that it is clipped" grep -q 'note: .*a.png: .* outside 0..1' "$work/err"
check "says that depth is left out" grep -q 'note: .*a.png: sRGB-encoded, 1 other channel and the metadata of .*in.exr left out' "$work/err"
near "it is clipped" "$(value "$work/o/a.png" B 40 30)" 1 0.0001
passes "EXR to PFM" "$DDOF" render "$work/in.exr" -o "$work/o/a.pfm" $lens
check "says that alpha is left out" grep -q 'note: .*a.pfm: without alpha' "$work/err"
near "it is not clipped" "$(value "$work/o/a.pfm" B 40 30)" 2 0.0001
passes "EXR to PNG, quiet" "$DDOF" render "$work/in.exr" -o "$work/o/a.png" $lens --quiet
check "quiet says nothing" test ! -s "$work/err"
mv "$work/in.8.png" "$work/in.8.exr"
passes "the first bytes say what a file is" "$DDOF" render "$work/in.8.exr" -o "$work/o/a.png" --depth "$work/z.exr" $lens -q
near "and not its name" "$(value "$work/o/a.png" G 40 30)" 0.25 0.003
cp "$work/in.exr" "$work/UPPER.EXR"
passes "endings in capitals" "$DDOF" render "$work/UPPER.EXR" -o "$work/o/OUT.EXR" $lens -q

# --- windows: other formats hold the display window
make "$work/window.exr" 32 24 float 32 window=16,12,64,48 R=0.5 G=0.5 B=0.5 Z=3
passes "window to PNG" "$DDOF" render "$work/window.exr" -o "$work/o/w.png" $lens -q
check "PNG has the size of the display window" test "$(info "$work/o/w.png" parts.0.data_window)" = "[0,0,64,48]"
near "black outside" "$(value "$work/o/w.png" R 15 12)" 0 0
near "colour inside" "$(value "$work/o/w.png" R 16 12)" 0.5 0.003
near "colour inside, last" "$(value "$work/o/w.png" R 47 35)" 0.5 0.003
near "black below" "$(value "$work/o/w.png" R 47 36)" 0 0
make "$work/over.exr" 84 68 float 32 window=-10,-10,64,48 R=ramp:0:0.83 G=0.5 B=0.5 Z=3
passes "overscan to PFM" "$DDOF" render "$work/over.exr" -o "$work/o/w.pfm" $lens --max-coc 0 -q
near "overscan is cut" "$(value "$work/o/w.pfm" R 0 0)" 0.1 0.0001
near "overscan is cut, right" "$(value "$work/o/w.pfm" R 63 47)" 0.73 0.0001
passes "preview of a window" "$DDOF" render "$work/window.exr" -o "$work/o/w.exr" $lens --preview "$work/o/p.png" -q
near "preview shows the display window" "$(value "$work/o/p.png" R 47 35)" 0.5 0.003

# --- depth and CoC from other formats
make "$work/d.16.png" 96 64 float 16 Y=0.5
# written through the sRGB curve, read as data: about 0.735
run "$DDOF" coc "$work/in.exr" -o "$work/o/c.exr" --depth "$work/d.16.png" --depth-kind normalized --near 1 --far 11 --focus 4 --max-coc 10 --json
near "integer depth is read as data" "$(member coc_max_px)" "$(awk 'BEGIN { z = 1 + 10 * 0.735357; print 10 * (z - 4) / z }')" 0.01
make "$work/d.pfm" 96 64 float 32 Y=8
run "$DDOF" coc "$work/in.exr" -o "$work/o/c.exr" --depth "$work/d.pfm" --focus 4 --max-coc 10 --json
near "depth of a PFM" "$(member coc_max_px)" 5 0.0001
make "$work/d.tif" 96 64 float 32 Y=8
run "$DDOF" coc "$work/in.exr" -o "$work/o/c.exr" --depth "$work/d.tif" --focus 4 --max-coc 10 --json
near "depth of a float TIFF" "$(member coc_max_px)" 5 0.0001
make "$work/d.half.exr" 96 64 half 16 Z=8
run "$DDOF" coc "$work/in.exr" -o "$work/o/c.exr" --depth "$work/d.half.exr" --focus 4 --max-coc 10 --json
near "half depth" "$(member coc_max_px)" 5 0.0001
passes "CoC of a PFM" "$DDOF" render "$work/in.exr" -o "$work/o/c.exr" --coc "$work/d.pfm" -q
passes "CoC of half" "$DDOF" render "$work/in.exr" -o "$work/o/c.exr" --coc "$work/d.half.exr" -q
passes "CoC of half, scaled" "$DDOF" render "$work/in.exr" -o "$work/o/c.exr" --coc "$work/d.half.exr" --coc-scale 0.5 --json
near "scaled" "$(member coc_max_px)" 4 0.0001
passes "CoC of a mask" "$DDOF" render "$work/in.exr" -o "$work/o/c.exr" --coc "$work/d.16.png" --coc-scale 20 -q

# --- ddof coc
for ending in exr pfm tif; do
    passes "coc to $ending" "$DDOF" coc "$work/in.exr" -o "$work/o/c.$ending" --focus 4 --max-coc 10
    near "coc to $ending: value" "$(value "$work/o/c.$ending" "$([ $ending = exr ] && echo CoC || echo Y)" 5 5)" -3.3333333 0.0001
done
check "coc says its range" grep -q 'CoC -3.33 to -3.33 px, 0.0 % in focus' "$work/out"
make "$work/both.exr" 96 64 float 32 R=1 G=1 B=1 "Z=ramp:1:20@95,63=nan"
passes "coc in false colour" "$DDOF" coc "$work/both.exr" -o "$work/o/c.png" --focus 10.5 --max-coc 20
rgb() { echo "$(value "$work/o/c.png" R "$1" "$2") $(value "$work/o/c.png" G "$1" "$2") $(value "$work/o/c.png" B "$1" "$2")"; }
check "near is orange" sh -c "echo '$(rgb 0 0)' | awk '{ exit !(\$1 > \$2 && \$2 > \$3) }'"
check "in focus is greenish" sh -c "echo '$(rgb 48 0)' | awk '{ exit !(\$2 > \$1 && \$2 > \$3) }'"
check "far is blue" sh -c "echo '$(rgb 95 0)' | awk '{ exit !(\$3 > \$2 && \$2 > \$1) }'"
check "no depth is magenta" sh -c "echo '$(rgb 95 63)' | awk '{ exit !(\$1 > 0.5 && \$3 > 0.5 && \$2 < 0.1) }'"
passes "false colour of a window" "$DDOF" coc "$work/window.exr" -o "$work/o/c.png" --focus 3 --max-coc 20 --exposure 1
check "false colour of a window: its size" test "$(info "$work/o/c.png" parts.0.data_window)" = "[0,0,64,48]"
done_testing
