# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# The plain gather and scatter that `make quality` compares with, and what makes its tables.
# shellcheck shell=sh disable=SC2154
. "${SOURCE:?}/tests/tools/tap.sh"
make() { "$FIXTURE" make "$@"; }
value() { "$FIXTURE" value "$@"; }
out=$work/o/out.exr
make "$work/noise.exr" 50 40 float 32 R=noise G=ramp:0:5 B=down:1:0
make "$work/flat.exr" 50 40 float 32 R=0.5 G=0.25 B=2
make "$work/point.exr" 61 61 float 32 R=0 G=1 "B=0@30,30=1000"
make "$work/sharp.exr" 50 40 float 32 "CoC=0.9"
make "$work/mixed.exr" 50 40 float 32 "CoC=ramp:-17:9@20,20=0"
make "$work/far.exr" 61 61 float 32 CoC=20
make "$work/near.exr" 61 61 float 32 CoC=-20
for how in gather scatter; do
    passes "$how: in focus" "$BASELINE" $how "$work/noise.exr" "$work/sharp.exr" "$out"
    for channel in R G B; do
        near "$how: in focus $channel is untouched" "$(value "$out" $channel 17 23)" "$(value "$work/noise.exr" $channel 17 23)" 0.0000001
    done
    passes "$how: one colour" "$BASELINE" $how "$work/flat.exr" "$work/mixed.exr" "$out"
    near "$how: one colour stays, darkest" "$("$FIXTURE" range "$out" B | awk '{ print $1 }')" 2 0.00001
    near "$how: one colour stays, brightest" "$("$FIXTURE" range "$out" B | awk '{ print $2 }')" 2 0.00001
    for side in far near; do
        passes "$how: a point, $side" "$BASELINE" $how "$work/point.exr" "$work/$side.exr" "$out"
        # its light over a disc of 20 pixels: 1000 / (pi 10^2) = 3.18
        near "$how: a point becomes a disc" "$(value "$out" B 30 30)" 3.183 0.02
        near "$how: as bright at its border" "$(value "$out" B 38 25)" "$(value "$out" B 30 30)" 0.001
        near "$how: that ends" "$(value "$out" B 30 41)" 0 0
    done
done

# --- for other programs
passes "|CoC| as a picture" "$BASELINE" map "$work/mixed.exr" "$work/o/map.png"
near "|CoC|: the largest is said" "$(cat "$work/out")" 17 0.0001
near "|CoC|: as a part of it" "$("$FIXTURE" data "$work/o/map.png" G 49 3)" 0.529412 0.00002
passes "packed" "$BASELINE" pack "$work/noise.exr" "$work/o/packed.png"
near "packed: the brightest is said" "$(cat "$work/out")" 5 0.0001
passes "unpacked" "$BASELINE" unpack "$work/o/packed.png" "$out" 5
near "unpacked: as it was" "$(value "$out" G 33 7)" "$(value "$work/noise.exr" G 33 7)" 0.0001

# --- tables
printf 'one\tScene one\tabout it\n' >"$work/cases.tsv"
printf 'a\tMethod A\tran A\nb\tMethod B\tran B\nc\tMethod C\tnever ran\n' >"$work/methods.tsv"
echo "How it was made." >"$work/about"
"$DDOF" compare "$work/noise.exr" "$work/flat.exr" --coc "$work/sharp.exr" --json >"$work/one.a.json"
"$DDOF" compare "$work/flat.exr" "$work/flat.exr" --coc "$work/sharp.exr" --json >"$work/one.b.json"
passes "report" "$REPORT" markdown "$work"
check "report: the best is bold" grep -q '^| Method B | \*\*999.00\*\* | \*\*999.00\*\* | \*\*1.0000\*\* | \*\*0.0000\*\* | \*\*0.0000\*\* |$' "$work/out"
check "report: the other is not" grep -Eq '^\| Method A \| [0-9.]+ \| [0-9.]+ \|' "$work/out"
check "report: an empty region" grep -Eq '^\| Method A .* - \| - \| - \|$' "$work/out"
check "report: what did not run has no figures" sh -c "! grep -q '^| Method C | [0-9*]' '$work/out'"
passes "report, HTML" "$REPORT" html "$work"
for picture in one.a.jpg one.truth.jpg one.a.d.jpg one.b.jpg; do
    check "report, HTML: $picture" grep -q "src=\"$picture\"" "$work/out"
done
done_testing
