# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# Camera files: which entry is taken, what options override, and what is wrong with a file.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
in=$work/pinhole.0002.exr
out=$work/o/coc.exr
"$FIXTURE" make "$in" 100 60 float 32 R=0.5 G=0.5 B=0.5 Z=20
camera() { # TEXT [OPTIONS]: what is focused on, the CoC at 20 m, the entry
    echo "$1" >"$work/c.json"
    shift
    run "$DDOF" coc "$in" -o "$out" --camera "$work/c.json" --json "$@"
}
coc() { awk -v s="$1" -v f="$2" -v n="$3" -v w="${4:-36}" 'BEGIN { f /= 1000; print f/n*(20-s)/20*f/(s-f)*100/(w/1000) }'; }
frames='"renders": [
  {"file": "pinhole.0001.exr", "dof": false, "frame": 1},
  {"file": "dof.0001.exr", "dof": true, "frame": 1, "f_number": 2, "focus_distance_m": 3},
  {"file": "pinhole.0002.exr", "dof": false, "frame": 2, "suggested_f_number": 16, "suggested_focus_distance_m": 9},
  {"file": "dof.0002.exr", "dof": true, "frame": 2, "f_number": 2, "focus_distance_m": 4},
  {"file": "wide.0002.exr", "dof": true, "frame": 2, "f_number": 1, "focus_distance_m": 5}]'
body='"camera": {"focal_length_mm": 85, "sensor_width_mm": 24}'

camera "{$body, $frames}"
near "entry of the same frame: focus" "$(member focus_distance)" 4 0.00001
near "entry of the same frame: CoC" "$(member coc_max_px)" "$(coc 4 85 2 24)" 0.001
check "entry of the same frame: its name" test "$(member camera_render)" = dof.0002.exr
camera "{$body, $frames}" --render wide.0002.exr
near "entry by name" "$(member coc_max_px)" "$(coc 5 85 1 24)" 0.001
camera "{$body, $frames}" --fstop 8 --focus 10 --focal-length 50 --sensor-width 36
near "options win" "$(member coc_max_px)" "$(coc 10 50 8)" 0.001
camera "{$body, $frames}" --focus-at 5,5
near "a pixel wins too" "$(member focus_distance)" 20 0.0001
cp "$in" "$work/other_shot.0001.exr"
in=$work/other_shot.0001.exr
camera "{$body, $frames}"
near "frame by the number of the file's name" "$(member focus_distance)" 3 0.00001
cp "$in" "$work/still.exr"
in=$work/still.exr
camera "{$body, $frames}"
near "no number: the first" "$(member focus_distance)" 3 0.00001
cp "$in" "$work/shot.0077.exr"
in=$work/shot.0077.exr
camera "{$body, $frames}"
check "no entry of that frame" grep -q 'c.json: has no entry with "dof": true for frame 77 of shot.0077.exr; name one with --render' "$work/err"
camera "{$body, \"renders\": [{\"file\": \"a.exr\", \"dof\": true, \"f_number\": 2, \"focus_distance_m\": 6}]}"
near "entries without a frame fit all" "$(member focus_distance)" 6 0.00001
camera "{$body, \"renders\": [{\"file\": \"shot.0077.exr\", \"dof\": false, \"suggested_f_number\": 2, \"suggested_focus_distance_m\": 7}]}"
near "a suggestion of its own entry" "$(member focus_distance)" 7 0.00001
camera "{$body}" --fstop 2 --focus 4
near "no entries, but options" "$(member coc_max_px)" "$(coc 4 85 2 24)" 0.001
one='"renders": [{"file": "a.exr", "dof": true, "f_number": 2, "focus_distance_m": 4}]'
camera "{$body, $one, \"depth\": {\"unit\": \"cm\"}}"
near "unit of the depth" "$(member focus_distance)" 400 0.001
camera "{$body, $one, \"depth\": {\"unit\": \"cm\"}}" --unit 1000
near "unit by option" "$(member focus_distance)" 4 0.00001
camera "{$body, $one, \"depth\": {\"convention\": \"inverse of the distance\"}}"
near "convention of the depth" "$(member coc_max_px)" "$(awk 'BEGIN { f=.085; print f/2*(.05-4)/.05*f/(4-f)*100/.024 }' | tr -d -)" 1000
check "convention: 20 per metre is near" sh -c "case $(member coc_max_px) in -*) ;; *) exit 1 ;; esac"
camera "{$body, $one, \"depth\": {\"convention\": \"inverse\"}}" --depth-kind planar
near "convention by option" "$(member coc_max_px)" "$(coc 4 85 2 24)" 0.001
camera "{$body, $one, \"depth\": {\"channel\": \"NotThere\"}, \"more\": {\"unknown\": [1, null, true]}}"
near "unknown members and channels do not matter" "$(member coc_max_px)" "$(coc 4 85 2 24)" 0.001

# --- what is wrong with a file
rm -f "$work/o/"*
bad() { # DESCRIPTION PATTERN TEXT [OPTIONS]
    about=$1 pattern=$2
    printf '%s' "$3" >"$work/bad.json"
    shift 3
    refuses "$about" 1 "bad.json: $pattern" "$DDOF" coc "$in" -o "$out" --camera "$work/bad.json" "$@"
}
bad "empty file" 'line 1, column 1: not valid JSON' ''
bad "truncated file" 'line 2, column [0-9]+: not valid JSON' "{$body,
 \"renders\": [{\"file\""
bad "no JSON" 'line 1, column 1: not valid' 'focal length 85'
bad "something after it" 'line 1, column [0-9]+: not valid' "{$body} x"
bad "a colon forgotten" 'line 1, column 1[0-9]: not valid' '{"camera" 5}'
bad "a list" 'not a JSON object' '[1, 2]'
bad "no camera" 'has no "camera" object' '{"renders": []}'
bad "camera is text" 'has no "camera" object' '{"camera": "here"}'
for value in 0 -85 '"long"' true '[85]' 1e999; do
    bad "focal length $value" 'focal_length_mm is .*; it must be a number above 0' "{\"camera\": {\"focal_length_mm\": $value}}"
done
bad "f-number 0" 'f_number is 0' "{$body, \"renders\": [{\"file\": \"a\", \"dof\": true, \"f_number\": 0}]}"
bad "focus -1" 'focus_distance_m is -1' "{$body, \"renders\": [{\"file\": \"a\", \"dof\": true, \"f_number\": 2, \"focus_distance_m\": -1}]}"
bad "unknown unit" "depth.unit 'parsec' is not known" "{$body, \"depth\": {\"unit\": \"parsec\"}}"
bad "unknown convention" "depth.convention 'who knows' begins with none" "{$body, \"depth\": {\"convention\": \"who knows\"}}"
awk 'BEGIN { for (i = 0; i < 100000; i++) printf "[" }' >"$work/bad.json"
refuses "100000 brackets" 1 'bad.json: line 1, column [0-9]+' "$DDOF" coc "$in" -o "$out" --camera "$work/bad.json"
awk 'BEGIN { for (i = 0; i < 300000; i++) printf "%64s", "" }' >"$work/bad.json"
refuses "19 MB" 1 'bad.json: larger than 16 MiB' "$DDOF" coc "$in" -o "$out" --camera "$work/bad.json"
refuses "endless file" 1 '/dev/zero: ' "$DDOF" coc "$in" -o "$out" --camera /dev/zero
refuses "a folder" 1 "$work: " "$DDOF" coc "$in" -o "$out" --camera "$work"
echo "{$body, $frames}" >"$work/c.json"
refuses "entry that is not there: says which are" 2 "--render: .*c.json has no entry 'x.exr'; .*: dof.0001.exr, dof.0002.exr, wide.0002.exr" "$DDOF" coc "$in" -o "$out" --camera "$work/c.json" --render x.exr
echo "{$body}" >"$work/c.json"
refuses "no entries, no options" 2 '--fstop: missing' "$DDOF" coc "$in" -o "$out" --camera "$work/c.json"
done_testing
