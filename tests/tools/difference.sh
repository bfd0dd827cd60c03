# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# compare -o: the picture of a difference, value by value.
# shellcheck shell=sh disable=SC2154
. "${SOURCE:?}/tests/tools/tap.sh"
make() { "$FIXTURE" make "$@"; }
a=$work/a.exr
b=$work/b.exr
png=$work/o/d.png
exr=$work/o/d.exr
# all differences are exact in float: 1/1024, 1/512, 0; at 2,1 more than white, at 3,1 no number
make "$a" 8 4 float 32 R=0.5 G=0.25 "B=4@3,1=nan"
make "$b" 8 4 float 32 R=0.5009765625 G=0.248046875 "B=4@2,1=5"

value() { "$FIXTURE" value "$@"; } # of an EXR
shown() { "$FIXTURE" data "$@" | awk '{ printf "%.4f", $1 * 255 }'; } # of a PNG, 0 to 255

passes "compare -o PNG" "$DDOF" compare "$a" "$b" --amplify 64 -o "$png" --json
check "it is named" test "$(member output)" = "$png"
near "the figures stay" "$(member max_error)" 1 0
near "1/1024 times 64 is 15.94 of 255: 16" "$(shown "$png" R 0 0)" 16 0
near "1/512 times 64 is 31.88: 32, whichever is the larger" "$(shown "$png" G 0 0)" 32 0
near "equal is black" "$(shown "$png" B 0 0)" 0 0
near "more than 1 is white" "$(shown "$png" B 2 1)" 255 0
near "what is no number is equal" "$(shown "$png" B 3 1)" 0 0
near "and so is the whole pixel" "$(shown "$png" R 3 1)" 0 0
passes "compare --invert" "$DDOF" compare "$a" "$b" --amplify 64 --invert -o "$png"
near "inverted: 255 - 15.94" "$(shown "$png" R 0 0)" 239 0
near "inverted: 255 - 31.88" "$(shown "$png" G 0 0)" 223 0
near "inverted: equal is white" "$(shown "$png" B 0 0)" 255 0
near "inverted: more than 1 is black" "$(shown "$png" B 2 1)" 0 0
near "inverted: what is no number is equal" "$(shown "$png" R 3 1)" 255 0
passes "both ways round" "$DDOF" compare "$b" "$a" --amplify 64 --invert -o "$work/o/e.png" -q
check "are the same picture" cmp "$png" "$work/o/e.png"

passes "compare -o EXR" "$DDOF" compare "$a" "$b" --amplify 64 -o "$exr" -q
near "EXR: the number" "$(value "$exr" R 0 0)" 0.0625 0
near "EXR: not clipped" "$(value "$exr" B 2 1)" 64 0
passes "compare --invert -o EXR" "$DDOF" compare "$a" "$b" --amplify 64 --invert -o "$exr" -q
near "EXR, inverted: the number" "$(value "$exr" G 0 0)" 0.875 0
near "EXR, inverted: below 0" "$(value "$exr" B 2 1)" -63 0
passes "255 by default" "$DDOF" compare "$a" "$b" -o "$exr" -q
near "255 by default: value" "$(value "$exr" R 0 0)" 0.2490234375 0.000000001

# --- windows: data at 2,1 of a display of 12 x 8
make "$work/wa.exr" 8 4 float 32 window=2,1,12,8 R=0 G=0 B=0
make "$work/wb.exr" 8 4 float 32 window=2,1,12,8 R=1 G=0.5 B=0
passes "windows, EXR" "$DDOF" compare "$work/wa.exr" "$work/wb.exr" --amplify 1 -o "$exr" -q
run "$DDOF" info "$exr"
check "EXR keeps them" grep -q 'data window 8x4 at 2,1; display window 12x8 at 0,0' "$work/out"
near "EXR, windows: value" "$(value "$exr" G 7 3)" 0.5 0
passes "windows, PNG" "$DDOF" compare "$work/wa.exr" "$work/wb.exr" --amplify 1 --invert -o "$png" -q
run "$DDOF" info "$png"
check "PNG has the display window" grep -q '12x8' "$work/out"
near "PNG, windows: inside" "$(shown "$png" R 2 1)" 0 0
near "PNG, windows: outside" "$(shown "$png" R 1 1)" 255 0
near "PNG, windows: below" "$(shown "$png" R 9 5)" 255 0
make "$work/ga.png" 8 4 float 8 Y=0.25
make "$work/gb.png" 8 4 float 8 Y=0.5
passes "grey pictures" "$DDOF" compare "$work/ga.png" "$work/gb.png" --amplify 1 -o "$exr" -q
near "grey: the same in all three" "$(value "$exr" R 0 0)" "$(value "$exr" B 7 3)" 0
above "grey: something" "$(value "$exr" G 0 0)" 0.2

# --- refused
rm -f "$work/o/"*
refuses "--amplify without -o" 2 '--amplify: describes a picture of the difference; say where' "$DDOF" compare "$a" "$b" --amplify 3
refuses "--invert without -o" 2 '--invert: describes a picture' "$DDOF" compare "$a" "$b" --invert
refuses "another format" 2 '--output: .*d.pfm: differences are written as PNG or EXR' "$DDOF" compare "$a" "$b" -o "$work/o/d.pfm"
refuses "unknown ending" 2 '--output: .*unknown ending' "$DDOF" compare "$a" "$b" -o "$work/o/d.jpg"
refuses "no such folder" 1 'nowhere' "$DDOF" compare "$a" "$b" -o "$work/nowhere/d.png"
refuses "over A" 2 '--output: .*a.exr is one of the two pictures' "$DDOF" compare "$a" "$b" -o "$a"
ln -s "$b" "$work/link.exr"
refuses "over B, by a link" 2 'is one of the two pictures' "$DDOF" compare "$a" "$b" -o "$work/link.exr"
make "$work/c.exr" 9 4 float 32 R=0 G=0 B=0
refuses "two sizes" 1 'compare pictures of one size' "$DDOF" compare "$a" "$work/c.exr" -o "$png"
done_testing
