# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# The lens from attributes of an EXR header: which, of which type, what wins over what, and what is wrong with them.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
in=$work/in.exr
out=$work/o/coc.exr
fresh() { "$FIXTURE" make "$in" 100 60 float 32 R=0.5 G=0.5 B=0.5 Z=20; }
set_attribute() { "$FIXTURE" attribute "$in" "$@"; } # NAME TYPE VALUE
coc() { awk -v s="$1" -v f="$2" -v n="$3" -v w="${4:-36}" 'BEGIN { f /= 1000; print f/n*(20-s)/20*f/(s-f)*100/(w/1000) }'; }
measure() { run "$DDOF" coc "$in" -o "$out" --json "$@"; }

# --- what OpenEXR names
fresh
set_attribute focus float 4
set_attribute aperture float 2
measure --metadata auto
near "focus" "$(member focus_distance)" 4 0.00001
near "f-number, the focal length is the default" "$(member coc_max_px)" "$(coc 4 50 2)" 0.001
set_attribute nominalFocalLength float 84
measure --metadata auto
near "nominal focal length" "$(member coc_max_px)" "$(coc 4 84 2)" 0.001
set_attribute effectiveFocalLength float 85
measure --metadata auto
near "the effective one goes before it" "$(member coc_max_px)" "$(coc 4 85 2)" 0.001
set_attribute pinholeFocalLength float 86
measure --metadata auto
near "the pinhole's before both" "$(member coc_max_px)" "$(coc 4 86 2)" 0.001
measure --metadata auto --focal-length 30 --fstop 8
near "options win" "$(member coc_max_px)" "$(coc 4 30 8)" 0.001
measure --metadata auto --focus 10
near "the focus too" "$(member focus_distance)" 10 0.00001
measure --metadata auto --focus-at 3,3
near "and a pixel" "$(member focus_distance)" 20 0.00001
measure --metadata auto --unit 10
near "focus is metres, whatever the depth's unit" "$(member focus_distance)" 400 0.001
printf '{"camera": {"focal_length_mm": 20, "sensor_width_mm": 24}, "renders": [{"file": "x", "dof": true, "f_number": 5.6, "focus_distance_m": 7}]}' >"$work/c.json"
measure --metadata auto --camera "$work/c.json"
near "wins over the camera file, which has the rest" "$(member coc_max_px)" "$(coc 4 86 2 24)" 0.001

# --- of other programs, by name, of any type
fresh
set_attribute cameraFNumber float 4
set_attribute cameraFocalLength float 70
set_attribute cameraAperture float 24
set_attribute cameraTargetDistance double 500
measure --metadata auto --focus 5
near "V-Ray's" "$(member coc_max_px)" "$(coc 5 70 4 24)" 0.001
measure --metadata focus=cameraTargetDistance,fstop=cameraFNumber --unit 10
near "a named focus is in the depth's unit" "$(member focus_distance)" 500 0.001
fresh
set_attribute Lens string 35.00
measure --metadata auto --focus 5 --fstop 2
near "Blender's, a text" "$(member coc_max_px)" "$(coc 5 35 2)" 0.001
fresh
set_attribute a int 6
set_attribute b rational 28/10
set_attribute c double 65.5
set_attribute 'show/sensor width' string 2.4e1
measure --metadata 'focus=a,fstop=b,focal-length=c,sensor-width=show/sensor width'
near "int, rational, double, text" "$(member coc_max_px)" "$(coc 6 65.5 2.8 24)" 0.001
measure --metadata fstop=nothing,focus=a --fstop 2
near "what an option gives is not looked for" "$(member coc_max_px)" "$(coc 6 50 2)" 0.001
fresh
set_attribute focus float inf
measure --metadata auto --fstop 2
check "a focus at infinity" test "$(member focus_distance)" = null
passes "render takes it too" "$DDOF" render "$in" -o "$work/o/r.exr" --metadata auto --fstop 2 -q
rm -f "$work/o/"*

# --- info
fresh
set_attribute aperture float 2.5
set_attribute focus float 3
run "$DDOF" info "$in" --json
check "info says which would be used" test "$(member lens.fstop.attribute) $(member lens.fstop.value) $(member lens.focus.value)" = "aperture 2.5 3"
run "$DDOF" info "$in"
check "and in words" grep -q '^lens, with --metadata: focus 3 (focus, metres), fstop 2.5 (aperture)$' "$work/out"
run "$DDOF" info "$in" --metadata fstop=focus --json
check "info with names" test "$(member lens.fstop.attribute)" = focus

# --- what is wrong
bad() { # DESCRIPTION CODE PATTERN NAMES
    refuses "$1" "$2" "$3" "$DDOF" coc "$in" -o "$out" --focus-range 0 --metadata "$4"
}
bad "no such attribute: which there are" 1 "--metadata: .*in.exr: has no number named 'tStop' for fstop; numbers in its header: .*aperture \(2.5\).*focus \(3\)" fstop=tStop
bad "not a number" 1 "has no number named 'channels' for focus" focus=channels
for list in nothing '' focus fstop= =aperture fstop=aperture, zoom=focus 'fstop=aperture,,focus=focus' AUTO; do
    bad "'$list'" 2 '--metadata: (empty|.* is neither auto nor one of focus=)' "$list"
done
bad "the same twice" 2 '--metadata: has fstop twice' fstop=aperture,fstop=focus
fresh
bad "auto finds nothing" 1 'in.exr: has no attribute of a lens that is known .*numbers in its header: pixelAspectRatio \(1\)' auto
for value in 0 -3 inf nan 2e6; do
    fresh
    set_attribute aperture float $value
    bad "f-number $value" 1 "aperture is .*$value.*, but must be above 0; give --fstop|aperture is 2e\+06" auto
done
for value in '' x 5mm '5 ' ' 5' 0x5 nan 1,5; do
    fresh
    set_attribute Lens string "$value"
    bad "the text '$value'" 1 "has no number named 'Lens'" focal-length=Lens
done
fresh
set_attribute z rational 5/0
bad "n/0" 1 "has no number named 'z'" focus=z
"$FIXTURE" make "$work/in.png" 16 8 float 8 R=0.5 G=0.5 B=0.5
refuses "PNG" 1 'in.png: has no number named .a. for focus; numbers in its header: none' "$DDOF" coc "$work/in.png" -o "$out" --depth "$in" --metadata focus=a
refuses "with --coc" 2 '--metadata: cannot be used together with --coc' "$DDOF" coc "$in" -o "$out" --coc :Z --metadata auto
done_testing
