# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# Stereo pictures: each view is blurred with its own depth, or stays sharp and a note says so.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
o=$work/o/out.exr
lens="--fstop 2 --focal-length 50 --focus 4"
make() { "$FIXTURE" make "$@"; }
same() { "$FIXTURE" same "$1" "$2" "$3"; }
differ() { ! same "$@"; }
multiview=040000006c656674050000007269676874 # "left", "right", with their lengths before them

# --- views in one part; the left one is that without prefix
make "$work/plain.exr" 96 64 half 16 R=noise G=noise B=noise A=1 Z=ramp:1:20 right.R=noise right.G=noise right.B=noise right.A=1 \
    right.Z=ramp:20:1 diffuse.R=noise diffuse.G=noise diffuse.B=noise diffuse.right.R=noise diffuse.right.G=noise diffuse.right.B=noise
cp "$work/plain.exr" "$work/stereo.exr"
"$FIXTURE" attribute "$work/stereo.exr" multiView stringvector $multiview
in=$work/stereo.exr

passes "without --views" "$DDOF" render "$in" -o "$o" $lens --json
check "the first view is blurred" differ "$in" "$o" R
check "the other is not" same "$in" "$o" right.R
check "a note says so and names --views all" grep -q "the view 'left' is blurred, right stays sharp; --views all" "$work/err"
check "JSON names it" test "$(member views)" = '["left"]'
cp "$o" "$work/left.exr"

passes "--views right" "$DDOF" render "$in" -o "$o" $lens --views right --json
check "the right view is blurred" differ "$in" "$o" right.R
check "the left one is not" same "$in" "$o" R
check "no note" test ! -s "$work/err"
check "JSON names right" test "$(member views)$(member layers)" = '["right"]["right"]'
cp "$o" "$work/right.exr"

passes "--views all" "$DDOF" render "$in" -o "$o" $lens --views all --json
check "left is as it is alone" same "$o" "$work/left.exr" R
check "right is as it is alone" same "$o" "$work/right.exr" right.R
check "the depths are left alone" same "$in" "$o" right.Z
check "JSON names both" test "$(member views)$(member layers)" = '["left","right"]["RGBA","right"]'
check "multiView is kept" test "$("$FIXTURE" hex "$o" multiView)" = $multiview

# The same colour, with the depth of the other eye: noise is the same in all channels, so what differs is the depth.
check "the views' depths make different blurs" sh -c "'$FIXTURE' value '$o' R 3 30 >'$work/a'; '$FIXTURE' value '$o' right.R 3 30 >'$work/b'; ! cmp -s '$work/a' '$work/b'"
passes "the right depth by hand" "$DDOF" render "$work/plain.exr" -o "$work/hand.exr" $lens --layer right --depth "$work/plain.exr:right.Z"
check "is what the right view gets" same "$o" "$work/hand.exr" right.R

passes "layers of both views" "$DDOF" render "$in" -o "$o" $lens --views left,right --channels 'diffuse.*,RGBA' --json
check "diffuse of the right view has its depth" same "$o" "$work/right.exr" right.R
check "and is blurred" differ "$in" "$o" diffuse.right.R
check "as right.R is" sh -c "'$FIXTURE' value '$o' right.R 40 30 >'$work/a'; '$FIXTURE' value '$o' diffuse.right.R 40 30 | cmp - '$work/a'"
check "two groups" test "$(member layers)" = '["RGBA","diffuse","right","diffuse.right"]'
passes "a pattern, one view" "$DDOF" render "$in" -o "$o" $lens --channels 'diffuse.*'
check "the other view's layer stays sharp" same "$in" "$o" diffuse.right.R
check "this one's does not" differ "$in" "$o" diffuse.R

# --- the views focus at one distance
passes "--focus-at in both views" "$DDOF" render "$in" -o "$o" --fstop 2 --focal-length 50 --focus-at 0,0 --views all --json
near "is looked up in the first" "$(member focus_distance)" 1 1e-3
passes "the same by number" "$DDOF" render "$in" -o "$work/hand.exr" --fstop 2 --focal-length 50 --focus "$(member focus_distance)" --views all
check "both views focus there" same "$o" "$work/hand.exr" right.R

# --- what is refused
rm -f "$work"/o/*
refuses "no such view" 2 "--views: .*stereo.exr has no view 'middle'; its views are: left, right" "$DDOF" render "$in" -o "$o" $lens --views middle
refuses "no views at all" 2 '--views: .*plain.exr has no views' "$DDOF" render "$work/plain.exr" -o "$o" $lens --views all
refuses "one depth for two views" 2 '--depth: .*does not fit several views' "$DDOF" render "$in" -o "$o" $lens --views all --depth "$work/plain.exr:Z"
refuses "one mask for two views" 2 '--holdout: one mask does not fit several views' "$DDOF" render "$in" -o "$o" $lens --views all --holdout "$work/plain.exr:A"
refuses "a layer of the other view" 2 "--channels: 'right.R' names channels of the view 'right' only; add --views all" "$DDOF" render "$in" -o "$o" $lens --channels right.R
make "$work/p.exr" 96 64 half 16 R=noise G=noise B=noise Z=ramp:1:20 right.R=noise right.G=noise right.B=noise
cp "$work/p.exr" "$work/flat.exr"
"$FIXTURE" attribute "$work/flat.exr" multiView stringvector $multiview
refuses "a view without depth" 1 "flat.exr: the view 'right' has no depth of its own \(there is Z of the view left\)" "$DDOF" render "$work/flat.exr" -o "$o" $lens --views all
refuses "nor by name" 1 "the view 'right' has no depth of its own" "$DDOF" render "$work/flat.exr" -o "$o" $lens --views right --depth :Z
passes "the view that has one" "$DDOF" render "$work/flat.exr" -o "$o" $lens --views left
passes "the other with a file" "$DDOF" render "$work/flat.exr" -o "$o" $lens --views right --depth "$work/plain.exr:Z"
cp "$work/p.exr" "$work/odd.exr"
"$FIXTURE" attribute "$work/odd.exr" multiView stringvector ffffff7f6c656674
passes "a damaged list of views is none" "$DDOF" render "$work/odd.exr" -o "$o" $lens --quiet

# --- views in parts: the Beachball frames
ball=$DATA/openexr-images/Beachball
if [ -f "$ball/multipart.0001.exr" ]; then
    lens="--focus 9.2 --max-coc 30"
    passes "parts: all views" "$DDOF" render "$ball/multipart.0001.exr" -o "$o" $lens --views all --json
    check "parts: both" test "$(member views)$(member layers)" = '["right","left"]["rgba_right:RGBA","rgba_left:RGBA"]'
    passes "parts: left alone" "$DDOF" render "$ball/multipart.0001.exr" -o "$work/left.exr" $lens --layer rgba_left --quiet
    passes "parts: left is the same" "$DDOF" compare "$o" "$work/left.exr" --layer rgba_left --json
    near "parts: left, largest error" "$(member max_error)" 0 0
    passes "parts: everything" "$DDOF" render "$ball/multipart.0001.exr" -o "$o" $lens --views all --channels '*' --json
    check "parts: no data is blurred" test "$(member layers)" = '["rgba_right:RGBA","rgba_left:RGBA"]'
    check "parts: data is named with its part" grep -q '"whitebarmask_left:whitebarmask.mask"' "$work/out"
    passes "one part: all views" "$DDOF" render "$ball/singlepart.0001.exr" -o "$o" $lens --views all --json
    check "one part: both" test "$(member views)$(member layers)" = '["right","left"]["RGBA","left"]'
else
    skip "views in parts" "no $ball"
fi
done_testing
