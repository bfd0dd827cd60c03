# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# Pictures with depth of phones, from the file to the finished picture. The files are made here; what cannot be made is skipped.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
lens='--focus 0.8 --max-coc 4'
value() { "$FIXTURE" value "$@"; }
# R at column 40, row 30 of the picture that phone_fixture makes, decoded
red=$(awk 'BEGIN { v = int(40.5 / 96 * 255 + 0.5) / 255; print ((v + 0.055) / 1.055) ^ 2.4 }')
# the CoC of a distance, with that lens
coc_at() { awk -v z="$1" 'BEGIN { print 4 * (z - 0.8) / z }'; }

for kind in heic avif; do
    "$PHONE" $kind "$work/in.$kind" said
    made=$?
    if [ $made -eq 77 ]; then
        skip "$kind" "no encoder for $kind here"
        continue
    fi
    check "$kind is made" test $made -eq 0
    run "$DDOF" info "$work/in.$kind" --json
    check "$kind: its depth is found" test "$(member depth.channels.0)" = depth
    check "$kind: what it means" test "$(member depth.kind)" = device
    near "$kind: near" "$(member depth.near)" 8 0.0001
    near "$kind: far" "$(member depth.far)" 0.5 0.0001
    run "$DDOF" info "$work/in.$kind"
    check "$kind: what it means, for people" grep -q 'depth-kind device --near 8 --far 0.5' "$work/out"
    for ending in exr png tif pfm; do
        passes "$kind to $ending, sharp" "$DDOF" render "$work/in.$kind" -o "$work/o/s.$ending" --focus 2 --max-coc 0 -q
        near "$kind to $ending: colour" "$(value "$work/o/s.$ending" R 40 30)" "$red" 0.003
    done
    check "8 bits stay 8" test "$("$DDOF" info "$work/o/s.png" --json | "$FIXTURE" json parts.0.bits)" = 8
    passes "$kind: rendered by what it says" "$DDOF" render "$work/in.$kind" -o "$work/o/a.exr" $lens
    check "it says what is left out" grep -q 'note: .*1 other channel and the metadata' "$work/err"
    passes "$kind: rendered by the same options" "$DDOF" render "$work/in.$kind" -o "$work/o/b.exr" $lens --depth-kind device --near 8 --far 0.5 -q
    check "$kind: the same picture" cmp "$work/o/a.exr" "$work/o/b.exr"
    passes "$kind: its CoC" "$DDOF" coc "$work/in.$kind" -o "$work/o/c.pfm" $lens -q
    far_z=$(awk 'BEGIN { d = int(0.75 * 255 + 0.5) / 255; print 1 / (1 / 8 + d * (2 - 1 / 8)) }')
    near "$kind: CoC of the wall" "$(value "$work/o/c.pfm" Y 80 30)" "$(coc_at "$far_z")" 0.001
    passes "$kind: other ends win" "$DDOF" coc "$work/in.$kind" -o "$work/o/c.pfm" $lens --near inf --far 1 -q
    far_z=$(awk 'BEGIN { d = int(0.75 * 255 + 0.5) / 255; print 1 / d }')
    near "$kind: CoC of the wall, other ends" "$(value "$work/o/c.pfm" Y 80 30)" "$(coc_at "$far_z")" 0.001
    passes "$kind as the file of --depth" "$DDOF" render "$work/o/s.exr" -o "$work/o/d.exr" --depth "$work/in.$kind" $lens -q
    rm -f "$work/o"/*
    refuses "$kind: another kind needs its ends" 2 'near: missing' "$DDOF" render "$work/in.$kind" -o "$work/o/a.exr" $lens --depth-kind normalized
    "$PHONE" $kind "$work/mute.$kind"
    refuses "$kind that says nothing" 2 'depth-kind: missing' "$DDOF" render "$work/mute.$kind" -o "$work/o/a.exr" $lens
    head -c 2000 "$work/in.$kind" >"$work/cut.$kind"
    refuses "$kind, cut off" 1 'damaged or cut off' "$DDOF" render "$work/cut.$kind" -o "$work/o/a.exr" $lens
    refuses "OUT is $kind" 2 "HEIF is read, but not written; use .exr" "$DDOF" render "$work/in.$kind" -o "$work/o/a.$kind" $lens
done

"$PHONE" jxl "$work/in.jxl"
made=$?
if [ $made -eq 77 ]; then
    skip "JPEG XL" "built without libjxl"
else
    check "JPEG XL is made" test $made -eq 0
    for ending in exr png; do
        passes "JPEG XL to $ending, sharp" "$DDOF" render "$work/in.jxl" -o "$work/o/s.$ending" --focus 2 --max-coc 0 --depth-kind device --near 8 --far 0.5 -q
        near "JPEG XL to $ending: colour" "$(value "$work/o/s.$ending" R 40 30)" "$red" 0.003
    done
    rm -f "$work/o"/*
    refuses "integer depth of JPEG XL" 2 'depth-kind: missing' "$DDOF" render "$work/in.jxl" -o "$work/o/a.exr" $lens
    refuses "OUT is JPEG XL" 2 'JPEG XL is read, but not written; use .exr' "$DDOF" render "$work/in.jxl" -o "$work/o/a.jxl" $lens
    "$PHONE" jxl "$work/float.jxl" float
    passes "float depth of JPEG XL is a distance" "$DDOF" coc "$work/float.jxl" -o "$work/o/c.pfm" $lens -q
    near "its CoC" "$(value "$work/o/c.pfm" Y 80 30)" "$(coc_at 0.75)" 0.0001
    passes "float JPEG XL to EXR" "$DDOF" render "$work/float.jxl" -o "$work/o/a.exr" --focus 2 --max-coc 0 -q
    near "float JPEG XL: colour" "$(value "$work/o/a.exr" G 40 30)" 0.4765625 0
    check "floats stay floats" test "$("$DDOF" info "$work/o/a.exr" --json | "$FIXTURE" json parts.0.channels.0.type)" = float
fi
done_testing
