# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# compare --coc and --ppd: the picture divided by its circle of confusion, and FLIP.
# shellcheck shell=sh disable=SC2154
. "${SOURCE:?}/tests/tools/tap.sh"
make() { "$FIXTURE" make "$@"; }
a=$work/a.exr
b=$work/b.exr
coc=$work/coc.exr
make "$a" 60 20 float 32 R=0.5 G=0.5 B=0.5
make "$b" 60 20 float 32 R=0.6 G=0.6 B=0.6
make "$coc" 60 20 float 32 CoC=ramp:-29.5:29.5 other=0

# --- a ramp has no edge
passes "compare --coc" "$DDOF" compare "$a" "$b" --coc "$coc" --json
has_members "members of a region" regions.in_focus.psnr regions.in_focus.ssim regions.in_focus.psnr_tonemapped \
    regions.in_focus.ssim_tonemapped regions.in_focus.flip regions.in_focus.flip_hdr regions.in_focus.max_error \
    regions.in_focus.pixels regions.in_focus.nonfinite_pixels regions.defocused.flip regions.silhouette.flip
near "two columns are in focus" "$(member regions.in_focus.pixels)" 40 0
near "the others are not" "$(member regions.defocused.pixels)" 1160 0
near "no silhouette" "$(member regions.silhouette.pixels)" 0 0
check "an empty region is null" test "$(member regions.silhouette.flip)" = null
near "flat: a region is as the whole" "$(member regions.in_focus.flip)" "$(member flip)" 0.000001
passes "compare --coc FILE:CHANNEL" "$DDOF" compare "$a" "$b" --coc "$coc:other" --json
near "another channel: all in focus" "$(member regions.in_focus.pixels)" 1200 0

# --- one pixel that is 4 px before the focus: everything within 4 px of it or its neighbours, by Pythagoras
make "$work/dot.exr" 60 20 float 32 "CoC=0@30,10=-4"
passes "compare with an edge" "$DDOF" compare "$a" "$b" --coc "$work/dot.exr" --json
near "a disc of 49 pixels, at five places side by side" "$(member regions.silhouette.pixels)" 73 0
near "the rest is in focus" "$(member regions.in_focus.pixels)" 1127 0
make "$work/hole.exr" 60 20 float 32 "CoC=5@30,10=nan"
run "$DDOF" compare "$a" "$b" --coc "$work/hole.exr" --json
near "no CoC: in no region" "$(member regions.defocused.pixels)" 1199 0
near "no CoC: no edge" "$(member regions.silhouette.pixels)" 0 0

# --- the measure is taken where it says
make "$work/c.exr" 60 20 float 32 "R=0.5@59,3=0.7" G=0.5 B=0.5
run "$DDOF" compare "$a" "$work/c.exr" --coc "$coc" --json
near "an error in the blur: not in focus" "$(member regions.in_focus.max_error)" 0 0
near "an error in the blur: there" "$(member regions.defocused.max_error)" 0.2 0.000001
near "an error in the blur: FLIP in focus" "$(member regions.in_focus.flip)" 0 0
above "an error in the blur: FLIP there" "$(member regions.defocused.flip)" 0.0001
passes "compare --coc, for people" "$DDOF" compare "$a" "$b" --coc "$coc"
check "a line a region" grep -Eq '^in focus +40 ' "$work/out"
check "an empty line" grep -Eq '^silhouette +0 +nan' "$work/out"

# --- FLIP
passes "compare with itself" "$DDOF" compare "$a" "$a" --json
has_members "FLIP: members" flip flip_hdr ppd flip_hdr_start flip_hdr_stop flip_hdr_exposures
near "equal: FLIP" "$(member flip)" 0 0
near "equal: HDR-FLIP" "$(member flip_hdr)" 0 0
near "67 pixels in a degree" "$(member ppd)" 67 0
near "a flat picture: two exposures" "$(member flip_hdr_exposures)" 2 0
near "a flat picture: 0.85 of white" "$(member flip_hdr_start)" 2.08330 0.0001
run "$DDOF" compare "$a" "$b" --json
# 0.5 and 0.6 are 1/3 and 3/8 tone-mapped; L of these greys is 64.42 and 67.65
near "0.1 apart: FLIP" "$(member flip)" 0.13073 0.0005
run "$DDOF" compare "$b" "$a" --json
near "0.1 apart: the other way round" "$(member flip)" 0.13073 0.0005
near "the second picture chooses the exposures" "$(member flip_hdr_start)" 2.08330 0.0001
run "$DDOF" compare "$a" "$work/c.exr" --json
far=$(member flip)
run "$DDOF" compare "$a" "$work/c.exr" --json --ppd 20
near "--ppd is said" "$(member ppd)" 20 0
check "and it changes what is seen" test "$(member flip)" != "$far"
check "threads change nothing" test "$("$DDOF" compare "$a" "$work/c.exr" --threads 1 --json)" = "$("$DDOF" compare "$a" "$work/c.exr" --threads 5 --json)"

# --- refused
refuses "--coc and --mask" 2 '--coc: cannot be given with --mask' "$DDOF" compare "$a" "$b" --coc "$coc" --mask "$coc"
refuses "--coc of another size" 1 '--coc: .*is 8x8, but the pictures are 60x20; give one of the same size' sh -c "'$FIXTURE' make '$work/small.exr' 8 8 float 32 CoC=1 && '$DDOF' compare '$a' '$b' --coc '$work/small.exr'"
refuses "--coc that is not there" 1 '--coc: .*nowhere.exr' "$DDOF" compare "$a" "$b" --coc "$work/nowhere.exr"
refuses "--coc without a file" 2 '--coc: .*the file.s name is missing' "$DDOF" compare "$a" "$b" --coc :CoC
refuses "--coc without the channel" 1 '--coc: .*no channel|--coc: .*nothing' "$DDOF" compare "$a" "$b" --coc "$coc:nothing"
for value in 0 -1 0.5 1001 nan x; do
    refuses "--ppd $value" 2 '--ppd: .*(out of range|not a number)' "$DDOF" compare "$a" "$b" --ppd=$value
done
refuses "--ppd of another command" 2 "--ppd: not an option of 'ddof render' but of 'ddof compare'" "$DDOF" render "$a" -o "$work/o/x.exr" --ppd 3
done_testing
