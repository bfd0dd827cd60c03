# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# --method, --bokeh, --iris and what belongs to them: defaults, what is drawn, what is refused, and what bench says of it.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
in=$work/in.exr
out=$work/o/out.exr
make() { "$FIXTURE" make "$@"; }
value() { "$FIXTURE" value "$out" "$@"; }
render="$DDOF render $in -o $out --coc :CoC"
# two lights behind the focus, whose discs are 20 pixels wide: yellow at 40,40 and a brighter blue one at 90,50
make "$in" 128 96 float 32 "R=0.1@40,40=20" "G=0.1@40,40=20" "B=0.1@90,50=40" CoC=20

# --- defaults
asked() { # DESCRIPTION METHOD KERNEL BOKEH OPTION...: what render says it does
    about=$1 method=$2 kernel=$3 bokeh=$4
    shift 4
    passes "$about" $render --json "$@"
    check "$about: method" test "$(member method) $(member kernel 2>/dev/null) $(member bokeh)" = "$method $kernel $bokeh"
}
asked "heat" diffusion heat off
check "heat: no iris" test "$(member iris) $(member sprites)" = "null 0"
cp "$out" "$work/heat.exr"
asked "heat, off" diffusion heat off --bokeh off --method diffusion
check "off is the default of heat" cmp "$out" "$work/heat.exr"
asked "heat with highlights" diffusion heat highlights --bokeh highlights
check "heat with highlights: iris" test "$(member iris) $(member sprites)" = "disc 2"
asked "disc" diffusion disc highlights --kernel disc
has_members "disc: members" method bokeh iris sprites sprites_dropped sprites_large
check "disc: two sprites" test "$(member sprites) $(member sprites_dropped) $(member sprites_large)" = "2 0 0"
check "disc: no note" test ! -s "$work/err"
cp "$out" "$work/disc.exr"
asked "disc, highlights" diffusion disc highlights --kernel disc --bokeh highlights --iris disc --bokeh-threshold 1 --bokeh-limit 25% \
    --max-sprites 65536 --max-sprite-area 64 --bokeh-resolution full
check "these are the defaults of disc" cmp "$out" "$work/disc.exr"
asked "disc, off" diffusion disc off --kernel disc --bokeh off
cp "$out" "$work/off.exr"
check "off is another picture" sh -c "! '$FIXTURE' same '$out' '$work/disc.exr' R"
asked "disc, reference" diffusion disc highlights --kernel disc --backend reference
asked "full" scatter "" full --bokeh full
cp "$out" "$work/full.exr"
asked "scatter" scatter "" full --method scatter
check "scatter is full" cmp "$out" "$work/full.exr"
asked "full, half resolution" scatter "" full --bokeh full --bokeh-resolution half --bokeh-limit 32 --iris disc
check "half is the default of full" cmp "$out" "$work/full.exr"
passes "for people" $render --kernel disc --iris blades=6
check "for people: what was drawn" grep -q '^bokeh: 2 highlight pixels drawn, iris blades=6$' "$work/out"
passes "full, for people" $render --bokeh full
check "full, for people: what was drawn" grep -q '^bokeh: all pixels out of focus drawn, iris disc$' "$work/out"

# --- what is drawn: 20 over a disc of 314 pixels are 0.0637, what diffusion would leave it is another bell
passes "highlights" $render --kernel disc -q
near "a light is as bright at its rim as in its middle" "$(value R 40 48)" "$(value R 40 40)" 0.01
near "a light has its energy" "$(value R 40 46)" 0.163 0.003
near "far from the light nothing changes" "$(value R 10 80)" 0.1 0.0001
passes "a square iris" $render --kernel disc -q --iris blades=4,rotation=45
above "a square has corners" "$(value R 46 46)" 0.15
above "and sides, nearer than a disc's rim" 0.12 "$(value R 40 48)"
passes "an anamorphic iris" $render --kernel disc -q --iris squeeze=2
above "an anamorphic iris is tall" "$(value R 40 48)" "$(value R 48 40)"
make "$work/nothing.exr" 128 96 float 32 R=0.9 G=noise B=1 CoC=20
for options in "--kernel disc" "--bokeh highlights"; do
    passes "no highlights, $options" "$DDOF" render "$work/nothing.exr" -o "$out" --coc :CoC $options --json
    check "no highlights, $options: none drawn" test "$(member sprites) $(member sprites_dropped) $(member sprites_large)" = "0 0 0"
    "$DDOF" render "$work/nothing.exr" -o "$work/o/t.exr" --coc :CoC $options --bokeh off -q
    check "no highlights, $options: nothing changes" "$FIXTURE" same "$out" "$work/o/t.exr" G
done
rm -f "$work/o/"*

# --- limits
passes "threshold" $render --kernel disc --bokeh-threshold 30 --json
check "threshold: the brighter one is left" test "$(member sprites) $(member sprites_dropped)" = "1 0"
passes "threshold above all" $render --kernel disc --bokeh-threshold 50 --json
check "threshold above all: none" test "$(member sprites)" = 0
check "threshold above all: as off" "$FIXTURE" same "$out" "$work/off.exr" R
passes "as many as there are" $render --kernel disc --max-sprites 2 --json
check "as many as there are: no note" test ! -s "$work/err"
passes "too many" $render --kernel disc --max-sprites 1 --json
check "too many: counted" test "$(member sprites) $(member sprites_dropped) $(member sprites_large)" = "1 1 0"
check "too many: said" grep -q "^ddof: note: $in: 1 bright pixel was left to diffusion; --max-sprites or --max-sprite-area would" "$work/err"
near "too many: one line" "$(wc -l <"$work/err")" 1 0
passes "too large" $render --kernel disc --bokeh-limit 10% --json
check "too large: counted" test "$(member sprites) $(member sprites_dropped) $(member sprites_large)" = "0 0 2"
check "too large: said" grep -q "^ddof: note: $in: 2 bright pixels were left to diffusion, out of focus by more than --bokeh-limit" "$work/err"
near "too large: one line" "$(wc -l <"$work/err")" 1 0
check "too large: as off" "$FIXTURE" same "$out" "$work/off.exr" R
passes "limit in pixels" $render --kernel disc --bokeh-limit 21 --json
check "limit in pixels: none too large" test "$(member sprites) $(member sprites_large)" = "2 0"
for option in "--max-sprites 1" "--bokeh-limit 10"; do
    passes "$option --quiet" $render --kernel disc $option --quiet
    check "$option --quiet: no note" test ! -s "$work/err"
done
make "$work/hole.exr" 128 96 float 32 "R=0.1@40,40=20" "G=0.1@90,50=40" "B=0.1@5,5=nan" CoC=20
passes "a hole and a light too many" "$DDOF" render "$work/hole.exr" -o "$out" --coc :CoC --kernel disc --max-sprites 1
check "a hole and a light too many: both are said" sh -c "grep -q 'bright pixel was left' '$work/err' && grep -q 'not finite' '$work/err'"
near "a hole and a light too many: two lines" "$(wc -l <"$work/err")" 2 0
make "$work/wide.exr" 320 320 float 32 "R=0.1@160,160=2000" G=5 B=0.1 CoC=70
passes "too large an area" "$DDOF" render "$work/wide.exr" -o "$out" --coc :CoC --kernel disc --max-sprite-area 1 --json
check "too large an area: the brightest is drawn" test "$(member sprites)" = 1
near "too large an area: the others are counted" "$(member sprites_dropped)" 102399 0
rm -f "$work/o/"*

# --- an iris from a picture
make "$work/square.png" 16 16 float 8 Y=1
make "$work/colour.png" 16 16 float 8 R=0 G=1 B=0
make "$work/alpha.png" 16 16 float 8 Y=1 A=0.5
make "$work/many.exr" 16 16 float 32 R=0 G=1 B=0 other.Y=1
for iris in square.png colour.png alpha.png many.exr many.exr:other.Y; do
    passes "image=$iris" $render --kernel disc --iris "image=$work/$iris" --json
    check "image=$iris: named" test "$(member iris)" = "image=$work/$iris"
    near "image=$iris: a corner" "$(value R 48 48)" 0.15 0.01
    near "image=$iris: a side" "$(value R 48 40)" "$(value R 48 48)" 0.005
    near "image=$iris: its end" "$(value R 52 40)" "$(value R 10 80)" 0.01
done
make "$work/left.png" 16 16 float 8 Y=ramp:1:-0.9
passes "a picture is upright behind the focus" $render --kernel disc --iris "image=$work/left.png" -q
above "its left is on the left" "$(value R 32 40)" "$(value R 48 40)"
passes "a picture before the focus" $render --coc-scale -1 --kernel disc --iris "image=$work/left.png" -q
above "its left is on the right" "$(value R 48 40)" "$(value R 32 40)"
passes "a picture turned" $render --kernel disc --iris "image=$work/left.png,rotation=90" -q
above "its left is at the bottom" "$(value R 40 48)" "$(value R 40 32)"
make "$work/largest.png" 4096 2 float 8 Y=1
passes "the largest picture" $render --kernel disc --iris "image=$work/largest.png" -q
rm -f "$work/o/"*

# --- an iris that is refused
bad() { # LIST CODE PATTERN
    refuses "--iris $1" "$2" "--iris: $3" $render --kernel disc --iris "$1"
}
bad foo 2 "'foo' is none of disc, blades, image, rotation, .*; write it like --iris blades=6"
bad foo=3 2 "'foo=3' is none of"
bad blades=6,foo=3 2 "'foo=3' is none of"
bad blades=6, 2 "'' is none of"
bad ,disc 2 "'' is none of"
bad Disc 2 "'Disc' is none of"
bad blades=5,rotation=3,blades=6 2 'blades is there twice; leave one of them out'
bad disc,disc 2 'disc is there twice'
bad disc=1 2 'disc takes no value'
for key in blades image rotation curvature edge cats-eye squeeze fringe; do
    bad $key 2 "$key needs a value; write it like --iris"
    bad $key= 2 "$key needs a value"
done
for text in x 0x3 nan inf 6.5 '6 '; do bad "blades=$text" 2 "blades: '$text' is not a whole number"; done
for text in x nan inf '' 3,5; do bad "blades=6,rotation=$text" 2 "(rotation: '$text' is not a number|rotation needs a value|'5' is none of)"; done
for text in 2 0 -6 65; do bad "blades=$text" 2 "blades: $text is out of range; it must be 3 to 64"; done
bad rotation=4000 2 'rotation: 4000 is out of range; it must be -3600 to 3600'
bad blades=6,curvature=1.1 2 'curvature: 1.1 is out of range; it must be 0 to 1'
bad edge=-1.1 2 'edge: -1.1 is out of range; it must be -1 to 1'
bad cats-eye=2 2 'cats-eye: 2 is out of range; it must be 0 to 1'
bad squeeze=0.5 2 'squeeze: 0.5 is out of range; it must be 1 to 4'
bad fringe=0.6 2 'fringe: 0.6 is out of range; it must be -0.5 to 0.5'
bad "blades=6,image=$work/square.png" 2 'blades and image cannot be used together; give one of them'
bad disc,blades=6 2 'disc and blades cannot be used together'
bad curvature=0.4 2 'curvature needs blades too'
bad "image=$work/square.png,curvature=0.4" 2 'curvature needs blades too'
bad "image=$work/nothing.png" 1 '.*nothing.png: no such file; give FILE or FILE:CHANNEL'
bad "image=$work/square.png:" 2 ".*square.png:' ends in ':'"
bad image=:R 2 'image=:R names no file'
bad "image=$work/square.png:Q" 1 ".*square.png: has no channel 'Q'"
bad "image=$work" 1 "$work: is a folder; give a picture file"
: >"$work/empty.png"
bad "image=$work/empty.png" 1 '.*empty.png: '
echo "this is no picture" >"$work/text.png"
bad "image=$work/text.png" 1 '.*text.png: is no EXR, PNG, TIFF, PFM.* picture; convert it'
head -c 60 "$work/square.png" >"$work/cut.png"
bad "image=$work/cut.png" 1 '.*cut.png'
make "$work/long.png" 4097 2 float 8 Y=1
bad "image=$work/long.png" 1 '.*long.png is 4097x2, but an iris has at most 4096 pixels a side; make it smaller'
make "$work/black.png" 16 16 float 8 Y=0
bad "image=$work/black.png" 1 '.*black.png lets no light through, all of it is black; make white what is open'
make "$work/clear.png" 16 16 float 8 Y=1 A=0
bad "image=$work/clear.png" 1 '.*clear.png lets no light through'
make "$work/nan.exr" 16 16 float 32 Y=nan
bad "image=$work/nan.exr" 1 '.*nan.exr lets no light through'
refuses "--iris, empty" 2 '--iris: empty; write it like --iris blades=6,rotation=10' $render --kernel disc --iris ''

# --- options that do not go together
"$DDOF" bench --backend gl --size 8x8 --runs 1 2>&1 | grep -q 'was built without its GL' && no_gl=yes || no_gl=
both() { # CODE PATTERN OPTION...
    code=$1 pattern=$2
    shift 2
    refuses "$*" "$code" "$pattern" $render "$@"
}
for option in "--iris disc" "--bokeh-limit 10" "--bokeh-resolution half"; do
    both 2 "${option%% *}: needs --bokeh highlights or --bokeh full too" $option
    both 2 "${option%% *}: needs --bokeh highlights or --bokeh full too" $option --kernel disc --bokeh off
    both 2 "${option%% *}: needs --bokeh highlights or --bokeh full too" $option --method gaussian
done
for option in "--bokeh-threshold 2" "--max-sprites 10" "--max-sprite-area 2"; do
    both 2 "${option%% *}: needs --bokeh highlights too" $option
    both 2 "${option%% *}: needs --bokeh highlights; here every pixel out of focus is drawn" $option --bokeh full
    both 2 "${option%% *}: needs --bokeh highlights; here every pixel out of focus is drawn" $option --method scatter
done
for method in gaussian hexagon; do
    both 2 "--bokeh: highlights cannot be used together with --method $method; take --method diffusion" --method $method --bokeh highlights
    both 2 "--bokeh: full cannot be used together with --method $method" --method $method --bokeh full
    for backend in reference vulkan; do
        both 2 "--method: the $backend backend has no '$method'; take --backend cpu or" --method $method --backend $backend
    done
done
for bokeh in off highlights; do
    both 2 "--bokeh: $bokeh cannot be used together with --method scatter" --method scatter --bokeh $bokeh
done
for method in gaussian hexagon scatter; do
    for option in "--kernel disc" "--kernel heat" "--quality best" "--conductance matched" "--substeps 2" "--backend gl --solver cr" "--backend gl --shared-chain"; do
        case $option in *gl*) [ -z "$no_gl" ] || continue ;; esac # a build without GL says that first
        both 2 "cannot be used together with --method $method; it belongs to --method diffusion" --method $method $option
    done
done
both 2 "--method: 'box' is none of diffusion\|gaussian\|hexagon\|scatter" --method box
both 2 "--bokeh: 'on' is none of off\|highlights\|full" --bokeh on
both 2 "--bokeh-resolution: 'third' is none of full\|half" --kernel disc --bokeh-resolution third
for text in 0 -1 x nan inf; do both 2 '--bokeh-threshold: .*(out of range; it must be above 0|not a number)' --kernel disc --bokeh-threshold=$text; done
for text in 0 -1 4097; do both 2 '--bokeh-limit: .* is out of range' --kernel disc --bokeh-limit=$text; done
for text in x 5%% nan; do both 2 '--bokeh-limit: .* is not a number of pixels or percent' --kernel disc --bokeh-limit $text; done
both 2 "--bokeh-limit: 101% is more than the picture's width of 128 pixels" --kernel disc --bokeh-limit 101%
both 2 "--bokeh-limit: 129 is more than the picture's width of 128 pixels" --kernel disc --bokeh-limit 129
for text in 0 1.5 1048577 x; do both 2 '--max-sprites: .*(out of range|whole number)' --kernel disc --max-sprites $text; done
for text in 0 1.5 1025 x; do both 2 '--max-sprite-area: .*(out of range|whole number)' --kernel disc --max-sprite-area $text; done
for option in "--append counter" "--quads geometry"; do
    both 2 "${option%% *}: not an option of 'ddof render' but of 'ddof bench'" $option
    refuses "bench $option" 2 "${option%% *}: needs --bokeh highlights or --bokeh full too" "$DDOF" bench $option
    refuses "bench $option on the CPU" 2 "${option%% *}: belongs to the Vulkan backend; add --backend vulkan" "$DDOF" bench --bokeh full $option
done
refuses "bench --append twice" 2 "--append: 'twice' is none of counter\|arguments" "$DDOF" bench --append twice
refuses "bench --quads mesh" 2 "--quads: 'mesh' is none of instanced\|geometry" "$DDOF" bench --quads mesh
refuses "bench --in-place with highlights" 2 '--in-place: the first solve would leave no highlights' "$DDOF" bench --bokeh highlights --in-place
for option in "--method gaussian" "--bokeh full" "--bokeh highlights"; do
    refuses "bench --table $option" 2 "${option%% *}: is not for --table" "$DDOF" bench --table $option
done
refuses "bench --iris without a picture" 1 '--iris: .*nothing.png: no such file' "$DDOF" bench --bokeh full --iris "image=$work/nothing.png" --size 8x8

# --- bench (numbers are never judged here)
small="--size 320x180 --runs 2"
passes "bench" "$DDOF" bench $small --kernel disc --json
check "bench: no sprites by default" test "$(member method) $(member kernel) $(member bokeh) $(member sprites)" = "diffusion disc good off 0"
has_members "bench: disc by heat" heat_ratio
if member bokeh_ratio >/dev/null 2>&1; then not_ok "bench: no bokeh_ratio"; else ok "bench: no bokeh_ratio"; fi
for more in "" --depth "--type half --layout planar" "--channels 1" "--kernel disc" "--kernel disc --quality best --bokeh-resolution half --iris blades=5"; do
    passes "bench --bokeh highlights $more" "$DDOF" bench $small --coc 20 --bokeh highlights $more --json
    check "bench --bokeh highlights $more: all of them" test "$(member bokeh) $(member sprites) $(member sprites_dropped) $(member sprites_large)" = "highlights 1800 0 0"
    has_members "bench --bokeh highlights $more: ratio" bokeh_ratio median_ms memcpy_ratio
done
passes "bench --bokeh highlights, CoC of 0" "$DDOF" bench $small --bokeh highlights --coc 0 --json
check "bench --bokeh highlights, CoC of 0: in focus" test "$(member sprites)" = 0
passes "bench --bokeh highlights, 1x1" "$DDOF" bench --size 1x1 --runs 1 --bokeh highlights --json
for more in "--bokeh full" "--method scatter"; do
    passes "bench $more" "$DDOF" bench --size 64x48 --runs 1 --coc 8 $more --json
    check "bench $more: method" test "$(member method) $(member bokeh)" = "scatter full"
    has_members "bench $more: by heat" heat_ratio
done
passes "bench, for people" "$DDOF" bench $small --coc 20 --kernel disc --bokeh highlights
check "bench, for people: heat" grep -Eq '^good +[0-9.]+ times the heat kernel, median' "$work/out"
check "bench, for people: bokeh" grep -Eq '^bokeh +[0-9.]+ times the same without sprites, median' "$work/out"
check "bench, for people: sprites" grep -Eq '^sprites +1800 pixels drawn' "$work/out"
done_testing
