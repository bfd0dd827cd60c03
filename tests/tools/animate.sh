# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# Keyframes: what is between the keys, against formulas of the test's own; that it depends on nothing but the frame's number; and
# what is wrong with a file.
# shellcheck shell=sh disable=SC2154,SC2086,SC2016
. "${SOURCE:?}/tests/tools/tap.sh"
keys=$work/pull.json
mkdir "$work/s"
"$FIXTURE" make "$work/s/a.0000.exr" 101 20 float 32 R=noise G=0.5 B=0.5 Z=ramp:1:21
for frame in 0001 0005 0010 0012 0014 0015 0019 0020 0021 0024 0025 0030 0040; do cp "$work/s/a.0000.exr" "$work/s/a.$frame.exr"; done
at() { # FRAME TEXT [OPTIONS]: the report of that frame
    frame=$1
    printf '%s' "$2" >"$keys"
    shift 2
    run "$DDOF" coc "$work/s/a.00$frame.exr" -o "$work/o/c.exr" --json --animate "$keys" "$@"
}
lens="--fstop 2 --focal-length 50"
focus() { # FRAME TEXT: what is focused on
    at "$1" "$2" $lens
    member focus_distance
}
calc() { awk "BEGIN { printf \"%.9g\", $1 }"; }

# --- linear: in dioptres, in stops
text='{"focus": [[10, 2], [20, 10]]}'
near "dioptres, half way" "$(focus 15 "$text")" "$(calc '1/(.5*(1/2 + 1/10))')" 1e-6
near "dioptres, a fifth" "$(focus 12 "$text")" "$(calc '1/(.8/2 + .2/10)')" 1e-6
near "at a key" "$(focus 20 "$text")" 10 0
near "held before the first" "$(focus 05 "$text")" 2 0
near "held after the last" "$(focus 40 "$text")" 10 0
near "frame 0" "$(focus 00 '{"focus": [[-10, 1], [10, 3]]}')" "$(calc '1/(.5*(1/1 + 1/3))')" 1e-6
text='{"interpolation": "linear", "focus": [[10, 2], [20, "inf"], [30, 2]]}'
near "to infinity" "$(focus 15 "$text")" 4 1e-6
check "at infinity" test "$(focus 20 "$text")" = null
near "and back" "$(focus 25 "$text")" 4 1e-6
coc() { awk -v s="$1" -v f="$2" -v n="$3" -v range="${4:-0}" 'BEGIN { f /= 1000; print f/n*(21-s-range/2)/21*f/(s-f)*101/0.036 }'; }
at 15 '{"fstop": [[10, 2], [20, 8]]}' --focus 5 --focal-length 50
near "f-number, in stops" "$(member coc_max_px)" "$(coc 5 50 4)" 0.0005
at 15 '{"focal-length": [[10, 25], [20, 100]]}' --focus 5 --fstop 2
near "focal length, in ratios" "$(member coc_max_px)" "$(coc 5 50 2)" 0.0005
at 15 '{"focus-range": [[10, 0], [20, 4]]}' --focus 5 $lens
near "focus range, as it is" "$(member coc_max_px)" "$(coc 5 50 2 2)" 0.0005
at 12 '{"focus": [[10, 2], [20, 10]], "fstop": [[0, 4]]}' --focal-length 50
near "several at once" "$(member coc_max_px)" "$(coc "$(calc '1/(.8/2 + .2/10)')" 50 4)" 0.0005
near "a pixel, between two" "$(focus 15 '{"focus-at": [[10, "20,3"], [20, "80,3"]]}')" 11 1e-4
near "held" "$(focus 30 '{"focus-at": [[10, "20,3"], [20, "80,3"]]}')" 17 1e-4
near "percent" "$(focus 15 '{"focus-at": [[10, "10%,50%"], [20, "50%,50%"]]}')" 7 1e-4
near "percent and pixels, each its own" "$(focus 15 '{"focus-at": [[10, "10%,5"], [20, "50%,7"]]}')" 7 1e-4

# --- smooth: Hermite's basis, with slopes worked out here
hermite() { # FROM TO SLOPE_FROM SLOPE_TO WIDTH T: in dioptres, as a distance
    calc "1/((1+2*$6)*(1-$6)^2*$1 + $6*(1-$6)^2*$5*$3 + $6^2*(3-2*$6)*$2 + $6^2*($6-1)*$5*$4)"
}
text='{"interpolation": "smooth", "focus": [[10, 1], [20, 5]]}'
near "two keys ease in and out" "$(focus 12 "$text")" "$(hermite 1 .2 0 0 10 .2)" 1e-6
text='{"interpolation": "smooth", "focus": [[10, 1], [20, '$(calc 1/.6)'], [30, 5]]}'
near "passes the middle key at the mean speed" "$(focus 15 "$text")" "$(hermite 1 .6 0 -.04 10 .5)" 1e-5
near "on its other side" "$(focus 24 "$text")" "$(hermite .6 .2 -.04 0 10 .4)" 1e-5
before=$(focus 19 "$text") after=$(focus 21 "$text")
near "the speed is the same on both sides of a key" "$(calc "1/$before - .6")" "$(calc ".6 - 1/$after")" 1e-6
above "and is not 0" "$(calc "1/$before - .6")" .039
text='{"interpolation": "smooth", "focus": [[10, 1], [14, 1.25], [24, 5]]}'
slope=$(calc '3*14/((2*10+4)/-.05 + (10+2*4)/-.06)')
near "keys at uneven distances" "$(focus 12 "$text")" "$(hermite 1 .8 0 "$slope" 4 .5)" 1e-6
near "the long side" "$(focus 19 "$text")" "$(hermite .8 .2 "$slope" 0 10 .5)" 1e-5
text='{"interpolation": "smooth", "focus": [[10, 1], [20, 1], [30, 5]]}'
near "what does not move does not overshoot" "$(focus 15 "$text")" 1 0
near "from there on it eases" "$(focus 25 "$text")" "$(hermite 1 .2 0 0 10 .5)" 1e-6
text='{"interpolation": "smooth", "focus": [[10, 1], [20, 5], [30, 2]]}'
near "a turning point is one" "$(focus 19 "$text")" "$(hermite 1 .2 0 0 10 .9)" 1e-5
near "a single key" "$(focus 15 '{"interpolation": "smooth", "focus": [[12, 3]]}')" 3 0

# --- it depends on the frame's number alone
cp "$work/s/a.0000.exr" "$work/plain.exr"
printf '{"focus": [[1, 2], [3, 4]]}' >"$keys"
run "$DDOF" coc "$work/plain.exr" -o "$work/o/c.exr" --json --animate "$keys" $lens
near "a name without a number is frame 1" "$(member focus_distance)" 2 0
printf '{"interpolation": "smooth", "focus": [[5, 2], [14, 4], [30, 15]], "fstop": [[5, 1.4], [30, 4]]}' >"$keys"
render() { "$DDOF" render "$work/s/a.####.exr" -o "$work/o/$1.####.exr" --animate "$keys" --focal-length 50 -q --frames "$2"; }
render all 1,5,10,12,14,15,19,20,21,24
render half 1,12,20
"$DDOF" render "$work/s/a.0012.exr" -o "$work/o/one.0012.exr" --animate "$keys" --focal-length 50 -q
for frame in 0001 0012 0020; do check "frame $frame of any list of frames" cmp "$work/o/all.$frame.exr" "$work/o/half.$frame.exr"; done
check "and by itself" cmp "$work/o/all.0012.exr" "$work/o/one.0012.exr"
check "frames differ" sh -c "! cmp -s '$work/o/all.0012.exr' '$work/o/all.0020.exr'"
resume() { # TEXT: which frames are made again
    printf '%s' "$1" >"$keys"
    "$DDOF" render "$work/s/a.####.exr" -o "$work/o/all.####.exr" --animate "$keys" $lens --frames 10,20,30 --json --resume |
        sed -n 's/.*"frame":\([0-9]*\),"status":"rendered".*/\1/p' | tr '\n' ' '
}
check "all at first" test "$(resume '{"focus": [[10, 2], [30, 4], [40, 5]]}')" = "10 20 30 "
check "none again" test "$(resume '{"focus": [[10, 2], [30, 4], [40, 5]]}')" = ""
check "a key that moves nothing here" test "$(resume '{"focus": [[10, 2], [30, 4], [40, 6]]}')" = ""
check "a key that moves two frames" test "$(resume '{"focus": [[10, 2], [30, 6], [40, 6]]}')" = "20 30 "
rm -rf "$work/o"
mkdir "$work/o"

# --- a pull that was rendered with a lens: keys of what the camera file says are the same pictures
seq=$DATA/scenes/seq
if [ -f "$seq/scene.json" ]; then
    list=$(awk '/"file": "dof/ { dof = 1 } /"frame":/ { gsub(/[^0-9]/, "", $2); frame = $2 }
        dof && /"focus_distance_m":/ { gsub(/[^0-9.]/, "", $2); focus = $2 }
        /^  \}/ { if (dof && focus) printf "%s[%d, %s]", n++ ? ", " : "", frame, focus; dof = focus = 0 }' "$seq/scene.json")
    printf '{"focus": [%s], "fstop": [[1, 1.4]], "focal-length": [[1, 50]]}' "$list" >"$keys"
    "$DDOF" render "$seq/pinhole.####.exr" -o "$work/o/keys.####.exr" --animate "$keys" -q
    "$DDOF" render "$seq/pinhole.####.exr" -o "$work/o/camera.####.exr" --camera "$seq/scene.json" -q
    for frame in 0001 0006 0012; do check "frame $frame of $(echo "$list" | wc -w) words of keys" cmp "$work/o/keys.$frame.exr" "$work/o/camera.$frame.exr"; done
else
    skip "keys of a camera file" "no scenes"
fi
rm -rf "$work/o"
mkdir "$work/o"

# --- what is wrong with the command
clash() { # TEXT OPTION PATTERN
    printf '%s' "$1" >"$keys"
    refuses "$2 with keys for ${1%%:*}" 2 "$3" "$DDOF" coc "$work/s/a.0010.exr" -o "$work/o/c.exr" --animate "$keys" $2
}
clash '{"focus": [[1, 2]]}' "--focus 3" '--focus: cannot be used together with --animate, whose file .*pull.json has keys for focus'
clash '{"focus": [[1, 2]]}' "--focus-at 3,3" '--focus-at: cannot .* has keys for focus;'
clash '{"focus-at": [[1, "2,2"]]}' "--focus 3" '--focus: cannot .* has keys for focus-at'
clash '{"focus": [[1, 2]]}' "--autofocus 3,3,4x4" '--autofocus: cannot .* has keys for focus;'
clash '{"fstop": [[1, 2]]}' "--fstop 3" '--fstop: cannot .* has keys for fstop'
clash '{"focal-length": [[1, 2]]}' "--focal-length 3" '--focal-length: cannot'
clash '{"focus-range": [[1, 2]]}' "--focus-range 3" '--focus-range: cannot'
clash '{"fstop": [[1, 2]]}' "--coc :Z" '--animate: cannot be used together with --coc'
clash '{"focus": [[1, 0.01]]}' "$lens" '--focus: 0.01 \(10 mm\) lies inside the focal length'
clash '{"focus-at": [[1, "500,2"]]}' "$lens" '--focus-at: 500,2 lies outside of'

# --- what is wrong with a file
bad() { # DESCRIPTION PATTERN TEXT
    printf "$3" >"$work/bad.json"
    refuses "$1" 1 "bad.json: $2" "$DDOF" coc "$work/s/a.0010.exr" -o "$work/o/c.exr" --animate "$work/bad.json" $lens --focus-range 0
}
bad "empty" 'line 1, column 1: not valid JSON' ''
bad "cut off" 'line 2, column [0-9]+: not valid JSON' '{"focus":\n[[1, 2]'
bad "a list" 'not a JSON object; the file of --animate begins with' '[[1, 2]]'
bad "nothing in it" 'has no keys; write some' '{}'
bad "no keys" 'has no keys; write some' '{"interpolation": "smooth"}'
bad "unknown member" 'zoom: cannot be animated; there are focus' '{"zoom": [[1, 2]]}'
bad "an option that is not one of them" 'unit: cannot be animated' '{"unit": [[1, 2]]}'
bad "not UTF-8" 'fok.s: cannot be animated' '{"fok\377s": [[1, 2]]}'
bad "not UTF-8 in a value" 'focus: key 1: ".*in.*f" is not a number' '{"focus": [[1, "in\377f"]]}'
bad "a line break in a name" 'fo.cus: cannot be animated' '{"fo\\ncus": [[1, 2]]}'
bad "interpolation" 'interpolation: is neither' '{"interpolation": "cubic", "focus": [[1, 2]]}'
bad "interpolation twice" 'interpolation: is there twice' '{"interpolation": "linear", "interpolation": "smooth", "focus": [[1, 2]]}'
bad "focus twice" 'focus: is there twice' '{"focus": [[1, 2]], "focus": [[1, 3]]}'
bad "focus and focus-at" 'has keys for both focus and focus-at' '{"focus": [[1, 2]], "focus-at": [[1, "2,2"]]}'
for list in '3' '[]' '{"1": 2}' 'null' '"1"'; do bad "keys are $list" 'focus: has no list of keys' "{\"focus\": $list}"; done
for key in '1' '[1]' '[1, 2, 3]' '[]' '{"a": 1, "b": 2, "c": 3}'; do bad "a key is $key" "focus: key 2: .* is not a key; write \[FRAME, VALUE\]" "{\"focus\": [[0, 1], $key]}"; done
for frame in '1.5' '"1"' 'null' 1e10 1e999 '[1]'; do bad "frame $frame" 'focus: key 1: .* is no frame' "{\"focus\": [[$frame, 2]]}"; done
bad "the same frame twice" 'focus: key 3: 5 does not come after' '{"focus": [[1, 2], [5, 3], [5, 4]]}'
bad "frames downwards" 'focus: key 2: 1 does not come after' '{"focus": [[5, 2], [1, 3]]}'
for value in 0 -1; do bad "focus $value" "focus: key 1: $value is out of range; it must be above 0" "{\"focus\": [[1, $value]]}"; done
for value in 1e999 -1e999 '"3"' '"Inf"' '"nan"' null true '[2]'; do bad "focus $value" 'focus: key 1: .* is not a number; write one' "{\"focus\": [[1, $value]]}"; done
bad "focus too near for a reciprocal" 'focus: key 1: .* is out of range' '{"focus": [[1, 1e-310]]}'
for value in 0 -1 1e7; do bad "fstop $value" 'fstop: key 1: .* is out of range; it must be above 0' "{\"fstop\": [[1, $value]]}"; done
bad "fstop inf" 'fstop: key 1: "inf" is not a number; write one, like 2.8' '{"fstop": [[1, "inf"]]}'
bad "focus-range" 'focus-range: key 1: -1 is out of range; it must be at least 0' '{"focus-range": [[1, -1]]}'
for value in 3 '"3"' '"3,"' '",3"' '"3,4,5"' '"a,b"' '"3x4"' '[3, 4]' '"nan,3"' null; do bad "focus-at $value" 'focus-at: key 1: .* is not "X,Y"' "{\"focus-at\": [[1, $value]]}"; done
bad "focus-at -1" 'focus-at: key 1: .* is out of range' '{"focus-at": [[1, "3,-1"]]}'
bad "focus-at beyond 100 %%" 'focus-at: key 1: .* lies outside of the picture' '{"focus-at": [[1, "3%%,101%%"]]}'
bad "pixels and percent" 'focus-at: key 2: .* mixes pixels and percent' '{"focus-at": [[1, "3%%,3%%"], [2, "3,3%%"]]}'
refuses "a file that is not there" 1 'nowhere.json: No such file or directory; give --animate a file' "$DDOF" coc "$work/s/a.0010.exr" -o "$work/o/c.exr" --animate "$work/nowhere.json"
awk 'BEGIN { for (i = 0; i < 100000; i++) printf "[" }' >"$work/bad.json"
refuses "100000 brackets" 1 'bad.json: line 1, column [0-9]+' "$DDOF" coc "$work/s/a.0010.exr" -o "$work/o/c.exr" --animate "$work/bad.json"
awk 'BEGIN { for (i = 0; i < 300000; i++) printf "%64s", "" }' >"$work/bad.json"
refuses "19 MB" 1 'bad.json: larger than 16 MiB' "$DDOF" coc "$work/s/a.0010.exr" -o "$work/o/c.exr" --animate "$work/bad.json"
awk 'BEGIN { printf "{\"focus\": [[0, 1]"; for (i = 1; i < 100000; i++) printf ", [%d, %g]", i * 10, 1 + i % 7; print "]}" }' >"$keys"
run "$DDOF" coc "$work/s/a.0015.exr" -o "$work/o/c.exr" --json --animate "$keys" $lens
rm -f "$work/o/"*
near "100000 keys" "$(member focus_distance)" "$(calc '1/(.5*(1/2 + 1/3))')" 1e-6
refuses "keys of a shot are wrong once" 1 'bad.json: larger' "$DDOF" coc "$work/s/a.####.exr" -o "$work/o/c.####.exr" --animate "$work/bad.json"
done_testing
