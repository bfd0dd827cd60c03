# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# --channels: which channels are blurred, each as it would be by itself, and which stay sharp.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
o=$work/o/out.exr
in=$work/in.exr
lens="--fstop 2 --focal-length 50 --focus 4"
make() { "$FIXTURE" make "$@"; }
make "$in" 96 64 half 16 R=noise G=ramp:0:1 B=noise A=noise Z=ramp:1:20 diffuse.R=noise diffuse.G=ramp:0:1 diffuse.B=0.5 diffuse.A=noise \
    specular.R=noise specular.G=down:0:1 specular.B=noise N.X=noise N.Y=noise N.Z=noise light.Y=noise light.A=noise mono=noise \
    crypto00.R=noise crypto00.G=noise object_id=noise paintmask.A=noise depth_fog=noise materialID.R=noise

# blurred CHANNEL..., sharp CHANNEL...: those of $o
blurred() { for c; do "$FIXTURE" same "$in" "$o" "$c" && { echo "$c is sharp"; return 1; }; done; return 0; }
sharp() { for c; do "$FIXTURE" same "$in" "$o" "$c" || { echo "$c is blurred"; return 1; }; done; }
alike() { for c; do "$FIXTURE" same "$o" "$work/alone.exr" "$c" || { echo "$c differs"; return 1; }; done; }
data="Z N.X N.Y N.Z crypto00.R crypto00.G object_id paintmask.A depth_fog materialID.R"

passes "without --channels" "$DDOF" render "$in" -o "$o" $lens
check "RGBA is blurred" blurred R G B A
check "nothing else is" sharp diffuse.R diffuse.A specular.R light.Y mono $data
cp "$o" "$work/plain.exr"

passes "RGBA alone" "$DDOF" render "$in" -o "$o" $lens --channels RGBA
check "is what is chosen without" cmp "$o" "$work/plain.exr"

passes "two layers and RGBA" "$DDOF" render "$in" -o "$o" $lens --channels 'diffuse.*,specular.*,RGBA' --json
check "they are blurred" blurred R G B A diffuse.R diffuse.G diffuse.A specular.R specular.G specular.B
check "others are not" sharp light.Y mono $data
check "JSON: RGBA is the first image" test "$(member layers)" = '["RGBA","diffuse","specular"]'
check "JSON: nothing that is data" test "$(member left_sharp)" = '[]'
check "JSON: no views" test "$(member views)" = '[]'
near "JSON: channels of the first image" "$(member channels)" 4 0
for layer in diffuse specular; do
    passes "$layer by itself" "$DDOF" render "$in" -o "$work/alone.exr" $lens --layer $layer
    check "$layer has the same bits" alike $layer.R $layer.G $layer.B
done
check "alpha of the layer, too" sh -c "! '$FIXTURE' same '$in' '$o' diffuse.A"

for method in "--kernel disc" "--kernel disc --bokeh off --quality draft" "--layers auto" "--method gaussian" "--bokeh full"; do
    passes "$method: all at once" "$DDOF" render "$in" -o "$o" $lens $method --channels 'specular.*,RGBA'
    passes "$method: one by itself" "$DDOF" render "$in" -o "$work/alone.exr" $lens $method --layer specular
    check "$method: the same bits" alike specular.R specular.G specular.B
done

passes "everything" "$DDOF" render "$in" -o "$o" $lens --channels '*' --json
check "all light is blurred" blurred R G B A diffuse.R diffuse.A specular.B light.Y light.A mono
check "all data stays sharp" sharp $data
check "JSON lists the images" test "$(member layers)" = '["RGBA","diffuse","light","mono","specular"]'
for c in $data; do
    check "JSON: $c was left sharp" grep -q "\"$c\"" "$work/out"
    check "the note names $c" grep -q "$c (" "$work/err"
done
check "one note" test "$(wc -l <"$work/err")" -eq 1

passes "data by name" "$DDOF" render "$in" -o "$o" $lens --channels 'N.X,paintmask.A,mono'
check "is blurred" blurred N.X paintmask.A mono
check "and nothing else" sharp R N.Y N.Z Z object_id diffuse.R
check "no note" test ! -s "$work/err"
passes "a name beside a wildcard wins" "$DDOF" render "$in" -o "$o" $lens --channels '*,N.X' --json
check "is blurred, too" blurred N.X mono R
check "the rest of the vector is not" sharp N.Y N.Z

passes "part of a layer" "$DDOF" render "$in" -o "$o" $lens --channels 'diffuse.[RGB]'
check "its colours are blurred" blurred diffuse.R diffuse.G
check "its alpha is not" sharp diffuse.A R
passes "the same twice" "$DDOF" render "$in" -o "$o" $lens --channels 'RGBA,R,*.R,RGBA,specular.?' --json
check "is blurred once" test "$(member layers)" = '["RGBA","diffuse.R","specular"]'
passes "preview and report" "$DDOF" render "$in" -o "$o" $lens --channels 'diffuse.*,RGBA' --preview "$work/p.png"
check "say how many images" grep -q '2 images blurred, with 1 depth' "$work/out"

rm -f "$work"/o/*
refuses "no such channel" 2 "--channels: .*in.exr has no channel 'volume.\*'; its channels are: A, B, .*specular.R" "$DDOF" render "$in" -o "$o" $lens --channels 'RGBA,volume.*'
refuses "case counts" 2 "no channel 'DIFFUSE" "$DDOF" render "$in" -o "$o" $lens --channels 'DIFFUSE.*'
refuses "nothing but data" 2 "--channels: 'N.\*' names nothing but data .*N.X \(normals\)" "$DDOF" render "$in" -o "$o" $lens --channels 'N.*'
refuses "the depth in use" 2 '--channels: Z is the depth that the blur follows' "$DDOF" render "$in" -o "$o" $lens --channels 'RGBA,Z'
refuses "an empty list" 2 "--channels: ',,' names no channel" "$DDOF" render "$in" -o "$o" $lens --channels ,,
refuses "another format" 2 '--output: .*out.png: holds one image, and 2 are to be blurred' "$DDOF" render "$in" -o "$work/o/out.png" $lens --channels 'RGBA,mono'
refuses "of other commands" 2 '--channels: ' "$DDOF" coc "$in" -o "$o" $lens --channels RGBA
passes "one image in another format" "$DDOF" render "$in" -o "$work/o/out.png" $lens --channels RGBA
make "$work/grey.png" 96 64 float 8 R=noise G=noise B=noise
passes "of a PNG" "$DDOF" render "$work/grey.png" -o "$work/o/grey.png" --depth "$in:Z" $lens --channels '*'

# --- what docs/channels.md lists is what is looked for
sed -n '/^} data_names/,/^};/p' "$SOURCE/tools/channels.c" | sed 's/{"/\n&/g' | sed -n 's/^{"\([^"]*\)".*/\1/p' >"$work/names"
check "there are such names" test "$(wc -l <"$work/names")" -gt 30
while read -r name; do
    grep -qF "\`$name\`" "$SOURCE/docs/channels.md" || echo "$name"
done <"$work/names" >"$work/missing"
check "docs/channels.md lists all names of data" test ! -s "$work/missing"

# --- attributes pass through
cp "$in" "$work/a1.exr"
"$FIXTURE" attribute "$work/a1.exr" chromaticities chromaticities c1ca363f2a1d883edcd7813e7d3f353fcba1c53d9eefa73d14ae473e7b14ae3e
cp "$work/a1.exr" "$work/a2.exr"
"$FIXTURE" attribute "$work/a2.exr" whiteLuminance float 100
cp "$work/a2.exr" "$work/a3.exr"
"$FIXTURE" attribute "$work/a3.exr" acesImageContainerFlag int 1
passes "chromaticities and ACES" "$DDOF" render "$work/a3.exr" -o "$o" $lens --channels 'RGBA,diffuse.*'
for name in chromaticities whiteLuminance acesImageContainerFlag; do
    check "$name is kept" test "$("$FIXTURE" hex "$o" $name)" = "$("$FIXTURE" hex "$work/a3.exr" $name)"
done
passes "the same without them" "$DDOF" render "$in" -o "$work/alone.exr" $lens --channels 'RGBA,diffuse.*'
check "they do not change the blur" alike R G B A diffuse.R

# --- deep pictures
rm -f "$work"/o/*
"$FIXTURE" deep "$work/deep.exr" 40 30
refuses "deep colour" 1 'deep.exr: its colour lies in deep samples \(deep scanline, part deep, 40x30\); flatten it in the compositor' "$DDOF" render "$work/deep.exr" -o "$o" $lens
refuses "deep depth" 1 '--depth: .*deep.exr: its depth lies in deep samples .*flatten it' "$DDOF" render "$in" -o "$o" $lens --depth "$work/deep.exr"
refuses "deep layers" 1 'deep.exr: .*deep samples' "$DDOF" render "$work/deep.exr" -o "$o" $lens --channels '*'

# --- a hole in one layer is none in another
make "$work/hole.exr" 96 64 float 32 R=noise G=noise B=noise Z=ramp:1:20 a.R=noise@20,30=nan a.G=noise a.B=noise b.R=noise b.G=noise b.B=noise
passes "a hole in one layer" "$DDOF" render "$work/hole.exr" -o "$o" $lens --channels 'a.*,b.*,RGBA' --json
near "is counted" "$(member nonfinite_pixels)" 1 0
for layer in a b; do
    passes "layer $layer by itself" "$DDOF" render "$work/hole.exr" -o "$work/alone.exr" $lens --layer $layer
    check "layer $layer: the same bits" alike $layer.R $layer.G $layer.B
done
done_testing
