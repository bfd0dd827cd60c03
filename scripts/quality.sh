#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT

# Runs every method below over ray-traced scenes and measures it against the picture of a real lens. Writes docs/quality:
# results.md, index.html and its pictures. quality.sh [OUT]: writes them there.
# Environment: DDOF_DATA, the folder with scenes/ (default: ../shared/data beside the sources); BUILD, a build folder that is
# there already; METHODS, keys of those to run (default: all).
set -u
cd "$(dirname "$0")/.." || exit 1
scenes=${DDOF_DATA:-../shared/data}/scenes
build=${BUILD:-build}
out=${1:-docs/quality}

# key|title|how. "ddof ..." is a render with these options; what the other words do is below, in run_method.
# A new option of the command is a new line here.
methods='
input|Input, unchanged|copy
classic|Heat, classic|ddof --conductance classic
matched|Heat, matched|ddof --conductance matched
matched2|Heat, matched, 2 substeps|ddof --conductance matched --substeps 2
disc_draft|Disc, draft|ddof --kernel disc --quality draft
disc|Disc, good|ddof --kernel disc
disc_best|Disc, best|ddof --kernel disc --quality best
heat_layers|Heat, matched, layers|ddof --conductance matched --layers auto
layers|Disc, good, layers|ddof --kernel disc --layers auto
layers_best|Disc, best, layers|ddof --kernel disc --quality best --layers auto
disc_off|Disc, good, no sprites|ddof --kernel disc --bokeh off
layers_off|Disc, good, layers, no sprites|ddof --kernel disc --layers auto --bokeh off
full|Sprites, all pixels|ddof --bokeh full
full_layers|Sprites, all pixels, layers|ddof --bokeh full --layers auto
gaussian|Gaussian|ddof --method gaussian
gaussian_layers|Gaussian, layers|ddof --method gaussian --layers auto
hexagon|Hexagon|ddof --method hexagon
hexagon_layers|Hexagon, layers|ddof --method hexagon --layers auto
gather|Disc gather|baseline gather
scatter|Disc scatter|baseline scatter
imagemagick|ImageMagick blur map|imagemagick
gegl|GEGL lens-blur|gegl
blender|Blender Defocus|blender
'
# key|folder|colour|truth|options of the command|options where ddof draws sprites|title|about
cases='
row_f2|row|pinhole.exr|dof_f2.exr|||row, f/2|Objects from 1 m to 20 m and the sky, 85 mm, focus at 4 m: near and far blur.
row_f5.6|row|pinhole.exr|dof_f5.6.exr|||row, f/5.6|The same with the lens stopped down.
foreground|foreground|pinhole.exr|dof_f1.8.exr|||foreground, f/1.8|A wire fence, sticks and leaves close to the lens before a subject in focus: half-transparent near blur.
lights|lights|pinhole.exr|dof_f1.8.exr|||lights, f/1.8|A subject before small bright balls far behind the focus.
lights_hex|lights|pinhole.exr|dof_f1.8_hex.exr||--iris blades=6,rotation=40|lights, hexagon|The same through a lens with six blades. Of the methods here only the sprites of ddof are told of them.
motion|motion|motion_blur.exr|motion_blur_dof_f1.4.exr|--depth pinhole.exr:ViewLayer.Depth.Z||motion, f/1.4|The colour is the picture with motion blur and no depth of field, the depth that of the pinhole picture in the middle of the exposure.
seq_1|seq|pinhole.0001.exr|dof_f1.4.0001.exr|||seq, frame 1|First frame of a moving camera, focus at 2.5 m.
seq_12|seq|pinhole.0012.exr|dof_f1.4.0012.exr|||seq, frame 12|Last frame, focus at 5.25 m.
'

if [ ! -d "$scenes" ]; then
    echo "quality: skipped, $scenes is not there; say with DDOF_DATA which folder holds scenes/"
    exit 0
fi
scenes=$(cd "$scenes" && pwd)
work=$(mktemp -d "${TMPDIR:-/tmp}/ddof-quality.XXXXXX") || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT PIPE TERM

fail() {
    echo "quality: $*" >&2
    [ -s "$work/log" ] && tail -n 20 "$work/log" >&2
    exit 1
}

# --- build
if ! { [ -f "$build/build.ninja" ] || meson setup "$build" -Dtests=false; } >"$work/log" 2>&1 ||
   ! ninja -C "$build" tools/ddof tests/quality/quality_baseline tests/quality/quality_report \
        tests/quality/quality_popping tests/quality/quality_highlights >>"$work/log" 2>&1; then
    fail "the build failed"
fi
ddof=$build/tools/ddof
baseline=$build/tests/quality/quality_baseline
sheet=$build/tests/quality/quality_sheet
if ! ninja -C "$build" tests/quality/quality_sheet >"$work/log" 2>&1; then
    echo "quality: no pictures, libjpeg's headers are not installed; the figures are complete"
    sheet=
fi
: >"$work/log"

# --- methods
imagemagick_program() {
    for name in magick convert-im6.q16 convert; do
        "$name" -version 2>/dev/null | grep -q ImageMagick && echo "$name" && return
    done
}
im=$(imagemagick_program)

# Why a method cannot be run here; nothing when it can.
missing() {
    case $1 in
    imagemagick) [ -n "$im" ] || echo "ImageMagick is not installed" ;;
    gegl) command -v gegl >/dev/null || echo "gegl is not installed" ;;
    blender) [ -x /usr/bin/blender ] || echo "/usr/bin/blender is not there" ;;
    esac
}

described() { # HOW: what results.md says of it
    case $1 in
    copy) echo "the picture without depth of field" ;;
    ddof*) echo "\`ddof render${1#ddof}\`" ;;
    baseline*gather) echo "tests/quality/gather.c: every pixel looks at all pixels whose discs reach it" ;;
    baseline*scatter) echo "tests/quality/scatter.c: every pixel is drawn as its disc, from far to near" ;;
    imagemagick) echo "$("$im" -version | sed -n 's/^Version: \(ImageMagick [^ ]*\).*/\1/p'), \`-compose Blur\`: sigma CoC/4, linear, 16 bits scaled to the brightest pixel" ;;
    gegl) echo "GEGL, \`gegl:lens-blur\`: radius CoC/2, linear" ;;
    blender) echo "$(/usr/bin/blender --version 2>/dev/null | head -n 1), Defocus node with a blur map, which knows no order of depth: radius CoC/2, linear" ;;
    esac
}

# Whether a render draws sprites: highlights are the default of the disc kernel.
draws_sprites() { # HOW
    case $1 in
    *"--bokeh off"*) return 1 ;;
    *"--bokeh "* | *"--kernel disc"* | *"--method scatter"*) return 0 ;;
    *) return 1 ;;
    esac
}

# Uses $input, $camera, $truth, $options, $iris of the case; $coc, $rgb (colour alone), $map.exr, $map.png, $largest made from them.
run_method() { # HOW RESULT
    case $1 in
    copy) cp "$rgb" "$2" ;;
    ddof*)
        more=
        draws_sprites "$1" && more=$iris
        # shellcheck disable=SC2086 # words
        "$ddof" render "$input" -o "$2" --camera "$camera" --render "$truth" $options ${1#ddof} $more --quiet ;;
    baseline*) "$baseline" "${1#baseline }" "$rgb" "$coc" "$2" ;;
    imagemagick)
        scale=$("$baseline" pack "$rgb" "$work/packed.png") &&
            "$im" "$work/packed.png" "$map.png" -define "compose:args=$(awk "BEGIN { s = $largest / 4; print s \"x\" s }")" \
                -compose Blur -composite -depth 16 "PNG48:$work/blurred.png" &&
            "$baseline" unpack "$work/blurred.png" "$2" "$scale" ;;
    gegl)
        gegl "$rgb" -o "$2" -- gegl:lens-blur "radius=$(awk "BEGIN { print $largest / 2 }")" linear-mask=true \
            "aux=[" gegl:load "path=$map.exr" "]" ;;
    blender)
        /usr/bin/blender --background --factory-startup --python scripts/quality_blender.py -- "$rgb" "$map.exr" "$largest" "$2" ;;
    *) fail "no such method: $1" ;;
    esac >"$work/log" 2>&1
}

: >"$work/methods.tsv"
echo "$methods" >"$work/known"
while IFS='|' read -r key title how <&3; do
    [ -n "$key" ] || continue
    case " ${METHODS:-$key} " in *" $key "*) ;; *) continue ;; esac
    why=$(missing "${how%% *}")
    if [ -n "$why" ]; then
        echo "quality: $title is skipped, $why"
    else
        printf '%s\t%s\t%s\n' "$key" "$title" "$(described "$how")" >>"$work/methods.tsv"
        echo "$key|$how" >>"$work/methods"
    fi
done 3<"$work/known"
[ -s "$work/methods" ] || fail "none of the methods $METHODS is known and installed"

# --- cases
mkdir -p "$out" "$work/pictures" || exit 1
run_case() {
    input=$scenes/$folder/$colour camera=$scenes/$folder/scene.json
    options=$(echo "$extra" | sed "s|--depth |--depth $scenes/$folder/|")
    coc=$work/coc.exr rgb=$work/rgb.exr map=$work/map
    # shellcheck disable=SC2086 # words
    "$ddof" coc "$input" -o "$coc" --camera "$camera" --render "$truth" $options --quiet || fail "$title: no CoC"
    "$baseline" rgb "$input" "$rgb" || fail "$title: no colour"
    largest=$("$baseline" map "$coc" "$map.exr") || fail "$title: no map"
    "$baseline" map "$coc" "$map.png" >/dev/null || fail "$title: no map"
    [ -z "$sheet" ] || "$sheet" "$scenes/$folder/$truth" "$work/pictures/$case.truth.jpg" || fail "$title: no picture"
    while IFS='|' read -r key how <&3; do
        rm -f "$work/result.exr"
        run_method "$how" "$work/result.exr" || fail "$title: $key failed"
        "$ddof" compare "$work/result.exr" "$scenes/$folder/$truth" --coc "$coc" --json >"$work/$case.$key.json" ||
            fail "$title: $key: cannot be compared"
        if [ "$folder" = lights ]; then
            seen=$("$build/tests/quality/quality_highlights" "$work/result.exr" "$scenes/$folder/$truth" "$rgb" "$coc") ||
                fail "$title: $key: no highlights"
            printf '%-12s %-14s %s\n' "$case" "$key" "${seen#highlights: }" >>"$work/highlights"
        fi
        [ -z "$sheet" ] && continue
        "$sheet" "$work/result.exr" "$work/pictures/$case.$key.jpg" || fail "$title: $key: no picture"
        "$sheet" "$work/result.exr" "$scenes/$folder/$truth" "$work/pictures/$case.$key.d.jpg" || fail "$title: $key: no picture"
    done 3<"$work/methods"
}
: >"$work/cases.tsv"
echo "$cases" >"$work/cases"
while IFS='|' read -r case folder colour truth extra iris title about <&4; do
    [ -n "$case" ] || continue
    if [ ! -f "$scenes/$folder/$truth" ]; then
        echo "quality: $title is skipped, $scenes/$folder/$truth is not there"
        continue
    fi
    echo "quality: $title"
    printf '%s\t%s\t%s\n' "$case" "$title" "$about" >>"$work/cases.tsv"
    run_case
done 4<"$work/cases"

# --- popping: a pulled focus, frame by frame
popping=$build/tests/quality/quality_popping
pull_options='--kernel disc --layers auto'
pull() {
    for truth in "$scenes"/seq/dof_f1.4.*.exr; do
        frame=${truth%.exr} frame=${frame##*.}
        # shellcheck disable=SC2086 # words
        "$ddof" render "$scenes/seq/pinhole.$frame.exr" -o "$work/pull.$frame.exr" --camera "$scenes/seq/scene.json" \
            --render "$truth" $pull_options --quiet || return 1
        "$ddof" coc "$scenes/seq/pinhole.$frame.exr" -o "$work/pull.$frame.coc.exr" --camera "$scenes/seq/scene.json" \
            --render "$truth" --quiet || return 1
    done
    set -- "$scenes"/seq/dof_f1.4.*.exr
    ls "$work"/pull.????.exr >"$work/pulled" && ls "$work"/pull.*.coc.exr >"$work/pulled.coc" || return 1
    # shellcheck disable=SC2046 # words without spaces: mktemp's
    "$popping" $# $(cat "$work/pulled") "$@" $(cat "$work/pulled.coc") >"$work/popped" && tail -n 1 "$work/popped"
}
pulled=
if ls "$scenes"/seq/dof_f1.4.*.exr >/dev/null 2>&1; then
    pulled=$(pull) || fail "the focus pull failed"
    echo "quality: focus pull: $pulled"
fi
# The focus alone, over 48 frames of a still picture: from 1.5 m to 12 m, evenly in 1/distance
pull_still() {
    for frame in $(seq -w 1 48); do
        focus=$(awk "BEGIN { print 1 / (1 / 1.5 + ($frame - 1) / 47 * (1 / 12 - 1 / 1.5)) }")
        # shellcheck disable=SC2086 # words
        "$ddof" render "$scenes/row/pinhole.exr" -o "$work/still.$frame.exr" --focal-length 85 --fstop 2 --focus "$focus" $1 --quiet &&
            "$ddof" coc "$scenes/row/pinhole.exr" -o "$work/still.$frame.coc.exr" --focal-length 85 --fstop 2 --focus "$focus" \
                --quiet || return 1
    done
    # shellcheck disable=SC2046
    "$popping" 48 $(ls "$work"/still.??.exr) $(ls "$work"/still.*.coc.exr) >"$work/popped" && tail -n 1 "$work/popped"
}
if [ -f "$scenes/row/pinhole.exr" ]; then
    still=$(pull_still "$pull_options") && still_one=$(pull_still "--kernel disc") || fail "the focus pull of a still picture failed"
    pulled="$pulled. Of a still picture, \`row\`, over 48 frames: $still (without layers: $still_one)"
    echo "quality: focus pull of a still picture: $still; without layers: $still_one"
fi

# --- report
cat >"$work/about" <<'END'
Every method gives the same pictures a depth of field, and is measured against path-traced pictures of the same views through
a real aperture. Made by `make quality`; [the pictures](index.html). Bold is the best of a column.

- PSNR and SSIM are those of `ddof compare`, tone-mapped by x/(1 + x) and the sRGB curve unless scene-linear is said; FLIP and HDR-FLIP are
  means at 67 pixels per degree; regions are those of `--coc`: [what they are](../cli.md#regions-and-flip).
- All methods get one CoC, by the thin lens, from a depth that is not antialiased. The truth has some noise of its own, most of
  it in the bright discs of `lights` (4 % to 7 %).
- The gather and the scatter are what discs alone can do with one layer of pixels: neither knows what is hidden behind a near object.
END
if [ -s "$work/highlights" ]; then
    {
        echo "- Highlights by themselves, exposed to mid grey (tests/quality/highlights.c):"
        echo
        sed 's/^/      /' "$work/highlights"
        echo
    } >>"$work/about"
fi
if [ -n "$pulled" ]; then
    cat >>"$work/about" <<END
- Popping: over the twelve frames of \`seq\`, a focus pull with a moving camera, by \`ddof render $pull_options\`: root mean square
  of the second difference in time, of tone-mapped pixels outside silhouettes: $pulled.
END
fi
"$build/tests/quality/quality_report" markdown "$work" >"$work/results.md" || fail "no results.md"
"$build/tests/quality/quality_report" html "$work" >"$work/pictures/index.html" || fail "no index.html"
rm -f "$out"/*.jpg "$out/index.html"
cp "$work/results.md" "$out/results.md" || exit 1
if [ -n "$sheet" ]; then cp "$work/pictures/"* "$out/" || exit 1; fi
echo "results:  $out/results.md"
[ -z "$sheet" ] || echo "pictures: $out/index.html ($(du -sk "$out" | cut -f1) KiB)"
