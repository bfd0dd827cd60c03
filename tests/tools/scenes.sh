# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# Ray-traced scenes: the command with --camera against pictures taken through a real lens. The sample that comes with the
# sources is always there; the others where DDOF_DATA says.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
out=$work/o/out.exr

compare_with() { # FOLDER INPUT TRUTH PSNR SSIM [OPTIONS]: rendered with the camera file, tone-mapped
    folder=$1 input=$2 truth=$3 psnr=$4 ssim=$5
    shift 5
    about=$(basename "$folder")/$truth
    passes "$about: render" "$DDOF" render "$folder/$input" -o "$out" --camera "$folder/scene.json" --json "$@"
    run "$DDOF" compare "$out" "$folder/$truth" --json
    above "$about: PSNR $(member psnr_tonemapped) dB" "$(member psnr_tonemapped)" "$psnr"
    above "$about: SSIM $(member ssim_tonemapped)" "$(member ssim_tonemapped)" "$ssim"
    lens_psnr=$(member psnr_tonemapped)
    run "$DDOF" compare "$folder/$input" "$folder/$truth" --json
    above "$about: nearer to the truth than the pinhole picture" "$lens_psnr" "$(member psnr_tonemapped 2>/dev/null || echo 0)"
}

sample=$SOURCE/samples/row
if [ -f "$sample/pinhole.exr" ] && [ -f "$sample/scene.json" ]; then
    passes "sample: info" "$DDOF" info "$sample/pinhole.exr" --json
    near "sample: depth begins at 1 m" "$(member depth.min)" 1 0.05
    passes "sample: render" "$DDOF" render "$sample/pinhole.exr" -o "$out" --camera "$sample/scene.json" --preview "$work/o/p.png" --json
    near "sample: focus" "$(member focus_distance)" 4 0
    near "sample: near CoC" "$(member coc_min_px)" -48.8 0.2
    near "sample: far CoC" "$(member coc_max_px)" 16.4 0.1
    near "sample: no holes" "$(member nonfinite_pixels)" 0 0
    check "sample: depth is untouched" "$FIXTURE" same "$sample/pinhole.exr" "$out" Z
    check "sample: type and compression are kept" sh -c "'$DDOF' info '$out' | grep -q 'scanline, ZIP' && '$DDOF' info '$out' | grep -q 'R half'"
else
    skip "sample" "samples/row is not there"
fi

# The heat kernel is no disc and one layer knows no background: `lights` shows how far that is from a lens. The bounds
# keep the state of the method, they are no aims.
scenes=$DATA/scenes
if [ ! -d "$scenes" ]; then
    skip "ray-traced scenes" "no DDOF_DATA"
    done_testing
    exit
fi
compare_with "$scenes/row" pinhole.exr dof_f5.6.exr 32 0.93 --render dof_f5.6.exr
if [ -z "${DDOF_TEST_QUICK:-}" ]; then # figures are the same under a sanitizer
compare_with "$scenes/row" pinhole.exr dof_f2.exr 32 0.92
compare_with "$scenes/lights" pinhole.exr dof_f1.8.exr 12.5 0.4
compare_with "$scenes/lights" pinhole.exr dof_f1.8_hex.exr 12 0.4 --render dof_f1.8_hex.exr
# Highlights: what a lens makes of small lights, round and with six blades; better than diffusion alone and than Blender's
# Defocus with the exact CoC (22.1 dB, 0.904).
for layers in off auto; do
    compare_with "$scenes/lights" pinhole.exr dof_f1.8.exr 23.5 0.92 --kernel disc --layers $layers
    compare_with "$scenes/lights" pinhole.exr dof_f1.8_hex.exr 23.5 0.92 --kernel disc --layers $layers --render dof_f1.8_hex.exr \
        --iris blades=6,rotation=40
done
run "$DDOF" compare "$out" "$scenes/lights/dof_f1.8.exr" --json
hexagons=$(member psnr_tonemapped)
run "$DDOF" compare "$out" "$scenes/lights/dof_f1.8_hex.exr" --json
above "lights: six blades are no disc" "$(member psnr_tonemapped)" "$(awk "BEGIN { print $hexagons + 1 }")"
# The subject is in focus: no light of the background over it, no more than without any. It fills this part of the picture.
passes "lights: no sprites" "$DDOF" render "$scenes/lights/pinhole.exr" -o "$work/o/none.exr" --camera "$scenes/lights/scene.json" \
    --kernel disc --layers auto --bokeh off
passes "lights: sprites" "$DDOF" render "$scenes/lights/pinhole.exr" -o "$out" --camera "$scenes/lights/scene.json" --kernel disc --layers auto
for at in "320 180" "330 240" "360 310" "410 190"; do
    for channel in R G B; do
        # shellcheck disable=SC2086 # two words
        near "lights: the subject at $at keeps its $channel" "$("$FIXTURE" value "$out" $channel $at)" "$("$FIXTURE" value "$work/o/none.exr" $channel $at)" 0.002
    done
done
compare_with "$scenes/foreground" pinhole.exr dof_f1.8.exr 30.5 0.9 --kernel disc --layers auto
fi
passes "motion: render" "$DDOF" render "$scenes/motion/pinhole.exr" -o "$out" --camera "$scenes/motion/scene.json" --json
near "motion: focus" "$(member focus_distance)" 4 0
near "motion: near CoC as the renderer says" "$(member coc_min_px)" -10.854 0.01
for channel in X Y Z W; do check "motion: vector $channel is untouched" "$FIXTURE" same "$scenes/motion/pinhole.exr" "$out" ViewLayer.Vector.$channel; done
passes "foreground: render" "$DDOF" render "$scenes/foreground/pinhole.exr" -o "$out" --camera "$scenes/foreground/scene.json" --json
near "foreground: near CoC as the renderer says" "$(member coc_min_px)" -58.913 0.01
frames="0001 0004 0008 0012"
[ -z "${DDOF_TEST_QUICK:-}" ] || frames=0004
for frame in $frames; do
    compare_with "$scenes/seq" pinhole.$frame.exr dof_f1.4.$frame.exr 28 0.85
done
run "$DDOF" render "$scenes/seq/pinhole.0007.exr" -o "$out" --camera "$scenes/seq/scene.json" --json
near "seq: the focus of its frame" "$(member focus_distance)" 4 0
check "seq: the entry of its frame" test "$(member camera_render)" = dof_f1.4.0007.exr
done_testing
