# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# Bad input: one clear line that names the file or option and the remedy, a non-zero exit, and no partial output.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
o=$work/o/out.exr
in=$work/in.exr
lens="--fstop 2 --focal-length 50 --focus 4"
make() { "$FIXTURE" make "$@"; }
make "$in" 64 48 float 32 R=noise G=noise B=noise A=1 Z=ramp:1:20

# --- files that are not there or cannot be read
refuses "missing file" 1 'missing.exr: ' "$DDOF" render "$work/missing.exr" -o "$o" $lens
refuses "missing file, info" 1 'missing.exr: ' "$DDOF" info "$work/missing.exr"
refuses "missing file, compare" 1 'missing.exr: ' "$DDOF" compare "$in" "$work/missing.exr"
refuses "a folder" 1 "$work: " "$DDOF" info "$work"
: >"$work/empty.exr"
refuses "empty file" 1 'empty.exr: ' "$DDOF" info "$work/empty.exr"
echo "this is no picture, whatever its name says" >"$work/text.exr"
refuses "a text file" 1 'text.exr: ' "$DDOF" render "$work/text.exr" -o "$o" $lens
refuses "missing depth file" 1 '--depth: .*nothing.exr: no such file; give FILE or FILE:CHANNEL' "$DDOF" render "$in" -o "$o" --depth "$work/nothing.exr" $lens
refuses "missing depth file with channel" 1 '--depth: .*nothing.exr:Z: no such file' "$DDOF" render "$in" -o "$o" --depth "$work/nothing.exr:Z" $lens
refuses "missing CoC file" 1 '--coc: .*nothing.exr: no such file' "$DDOF" render "$in" -o "$o" --coc "$work/nothing.exr"
refuses "missing camera file" 1 'nothing.json: .*--camera' "$DDOF" render "$in" -o "$o" --camera "$work/nothing.json"
if [ "$(id -u)" -ne 0 ]; then
    cp "$in" "$work/secret.exr"
    chmod 0 "$work/secret.exr"
    refuses "unreadable file" 1 'secret.exr: .*denied' "$DDOF" info "$work/secret.exr"
else
    skip "unreadable file" "root reads everything"
fi

# --- truncated files of each format, at several places
make "$work/t.png" 64 48 float 16 R=noise G=noise B=noise
make "$work/t.tif" 64 48 float 32 R=noise G=noise B=noise
make "$work/t.pfm" 64 48 float 32 R=noise G=noise B=noise
make "$work/z.exr" 64 48 float 32 Z=ramp:1:20
cp "$in" "$work/t.exr"
for ending in exr png tif pfm; do
    size=$(wc -c <"$work/t.$ending")
    for percent in 1 10 50 90 99; do
        head -c $((size * percent / 100)) "$work/t.$ending" >"$work/cut.$ending"
        refuses "$ending cut at $percent %" 1 "cut.$ending" "$DDOF" render "$work/cut.$ending" -o "$work/o/out.$ending" --depth "$work/z.exr" $lens
    done
    head -c $((size / 2)) "$work/t.$ending" >"$work/cut.$ending"
    refuses "$ending cut, as depth" 1 "cut.$ending" "$DDOF" render "$in" -o "$o" --depth "$work/cut.$ending" --depth-kind inverse $lens
done
"$FIXTURE" header "$work/huge.exr" 100000 100000
refuses "100k x 100k header without data, info" 1 'huge.exr: ' "$DDOF" info "$work/huge.exr"
refuses "100k x 100k header without data, render" 1 'huge.exr: ' "$DDOF" render "$work/huge.exr" -o "$o" $lens
"$FIXTURE" header "$work/beyond.exr" 2000000000 2000000000
refuses "2e9 x 2e9 header" 1 'beyond.exr: ' "$DDOF" info "$work/beyond.exr"
"$FIXTURE" header "$work/negative.exr" -5 0
refuses "empty window in a header" 1 'negative.exr: ' "$DDOF" info "$work/negative.exr"

# --- channels
make "$work/rgb.exr" 64 48 float 32 R=1 G=1 B=1 spec.R=1 spec.G=1 spec.B=1
refuses "no depth channel: says which there are" 1 'rgb.exr: .*spec.R' "$DDOF" render "$work/rgb.exr" -o "$o" $lens
refuses "no depth in a PNG" 1 't.png: .*--depth' "$DDOF" render "$work/t.png" -o "$work/o/out.png" $lens
refuses "named depth channel is not there" 1 '--depth: .*in.exr.*Q' "$DDOF" render "$in" -o "$o" --depth :Q $lens
refuses "named depth channel is not there, file" 1 '--depth: .*z.exr.*Q' "$DDOF" render "$in" -o "$o" --depth "$work/z.exr:Q" $lens
refuses "channel name forgotten" 2 "--depth: .* ends in ':'" "$DDOF" render "$in" -o "$o" --depth "$work/z.exr:" $lens
refuses "named layer is not there" 1 'in.exr: .*beauty' "$DDOF" render "$in" -o "$o" --layer beauty $lens
make "$work/grey.exr" 64 48 float 32 Y=0.5
refuses "one channel is colour or depth, not both" 1 'grey.exr: has no depth.*--depth' "$DDOF" render "$work/grey.exr" -o "$o" $lens
refuses "info of a layer that is not there" 1 '--layer: .*beauty' "$DDOF" info "$in" --layer beauty

# --- sizes
make "$work/small.exr" 32 48 float 32 Z=ramp:1:20 R=1 G=1 B=1
refuses "depth of another size: names both" 1 'small.exr: its depth is 32x48, but the colour of .*in.exr is 64x48' "$DDOF" render "$in" -o "$o" --depth "$work/small.exr" $lens
refuses "CoC of another size: names both" 1 'small.exr: its CoC is 32x48, but the colour of .*in.exr is 64x48' "$DDOF" render "$in" -o "$o" --coc "$work/small.exr:Z"
hold() { # DESCRIPTION CODE PATTERN HOLDOUT
    refuses "holdout $1" "$2" "--holdout: .*$3" "$DDOF" render "$in" -o "$o" $lens --holdout "$4"
}
hold "of another size" 1 'small.exr is 32x48, but the picture is 64x48; give one of the same size' "$work/small.exr:Z"
hold "that is not there" 1 'nothing.exr: no such file; give FILE or FILE:CHANNEL' "$work/nothing.exr"
hold "without such a channel" 1 "has no channel 'mask'; its channels are: A, B, G, R, Z" ":mask"
hold "whose channel is forgotten" 2 "ends in ':'" "$in:"
refuses "compare of two sizes: names both" 1 'small.exr: is 32x48, but .*in.exr is 64x48' "$DDOF" compare "$in" "$work/small.exr"
refuses "mask of another size" 1 '--mask: .*small.exr is 32x48, but the pictures are 64x48' "$DDOF" compare "$in" "$in" --mask "$work/small.exr"
make "$work/moved.exr" 32 24 float 32 window=16,12,64,48 R=1 G=1 B=1 Z=3
make "$work/other.exr" 32 24 float 32 window=20,12,64,48 Z=3
refuses "depth of another place" 1 'other.exr: its depth lies elsewhere' "$DDOF" render "$work/moved.exr" -o "$o" --depth "$work/other.exr" $lens

# --- the lens
refuses "focus inside the focal length" 2 '--focus: 0.04 \(40 mm\) lies inside the focal length of 50 mm' "$DDOF" render "$in" -o "$o" --fstop 2 --focal-length 50 --focus 0.04
refuses "focus inside the focal length, other unit" 2 '--focus: 4 \(4 mm\) lies inside' "$DDOF" render "$in" -o "$o" $lens --unit 1
refuses "focus at a pixel inside the focal length" 1 '--focus-at: .*focal' "$DDOF" render "$in" -o "$o" --fstop 2 --focal-length 5000 --focus-at 0,0
refuses "no lens at all" 2 '--fstop: missing; .*--max-coc' "$DDOF" render "$in" -o "$o"
refuses "f-number forgotten" 2 '--fstop: missing' "$DDOF" render "$in" -o "$o" --focal-length 50 --focus 4
refuses "f-number forgotten, with blur" 2 '--fstop: missing' "$DDOF" render "$in" -o "$o" --focal-length 50 --focus 4 --max-coc 5
refuses "focus forgotten" 2 '--focus: missing' "$DDOF" render "$in" -o "$o" --fstop 2
refuses "blur forgotten" 2 '--fstop: missing' "$DDOF" render "$in" -o "$o" --focus 4
refuses "blur without focus" 2 '--focus: missing' "$DDOF" render "$in" -o "$o" --max-coc 5
refuses "two kinds of focus" 2 '--focus-at: cannot be used together with --focus' "$DDOF" render "$in" -o "$o" $lens --focus-at 3,3
refuses "infinite focus without a lens" 2 '--focus: inf needs a lens' "$DDOF" render "$in" -o "$o" --focus inf --max-coc 5
refuses "ray depth without a focal length" 2 '--focal-length: missing; ray' "$DDOF" render "$in" -o "$o" --focus 4 --max-coc 5 --depth-kind ray
refuses "focus outside of the picture" 2 '--focus-at: 64,0 lies outside of .*in.exr, which is 64x48' "$DDOF" render "$in" -o "$o" --fstop 2 --focus-at 64,0
refuses "focus outside of the data window" 2 '--focus-at: .*moved.exr holds no pixel there' "$DDOF" render "$work/moved.exr" -o "$o" --fstop 2 --focus-at 1,1
refuses "near and far forgotten" 2 '--near: missing; --depth-kind normalized' "$DDOF" render "$in" -o "$o" $lens --depth-kind normalized
refuses "far forgotten" 2 '--far: missing' "$DDOF" render "$in" -o "$o" $lens --depth-kind device --near 1
refuses "near is far" 2 '--near: the same as --far' "$DDOF" render "$in" -o "$o" $lens --depth-kind device --near 1 --far 1
refuses "near without meaning" 2 '--near: has no meaning' "$DDOF" render "$in" -o "$o" $lens --near 1
refuses "infinite end of linear depth" 2 '--far: inf needs --depth-kind device' "$DDOF" render "$in" -o "$o" $lens --depth-kind normalized --near 1 --far inf
refuses "depth of a PNG without its meaning" 2 '--depth-kind: missing; .*t.png holds values from 0 to 1' "$DDOF" render "$in" -o "$o" $lens --depth "$work/t.png:R"
for option in "--depth $work/z.exr" "--depth-kind ray" "--near 1" "--far 1" "--camera x.json" "--focal-length 50" "--sensor-width 36" "--fstop 2" "--unit 10" "--focus 4" "--focus-at 1,1" "--focus-range 1" "--max-coc 5" "--max-coc-near 5" "--max-coc-far 5"; do
    refuses "CoC excludes ${option%% *}" 2 "${option%% *}: cannot be used together with --coc" "$DDOF" render "$in" -o "$o" --coc :Z $option
done
refuses "scale without CoC" 2 '--coc-scale: needs --coc' "$DDOF" render "$in" -o "$o" $lens --coc-scale 2
refuses "entry without camera" 2 '--render: needs --camera' "$DDOF" render "$in" -o "$o" $lens --render x
refuses "instruction set of another machine" 2 "--cpu: '(neon|avx2)' is not on this machine.*there are: baseline" "$DDOF" render "$in" -o "$o" $lens --cpu neon,avx2

# --- values
make "$work/nan.exr" 16 8 float 32 R=nan G=nan B=nan Z=3
refuses "nothing but NaN colour" 1 'nan.exr: no pixel has finite colour and depth' "$DDOF" render "$work/nan.exr" -o "$o" $lens
make "$work/nanz.exr" 16 8 float 32 R=1 G=1 B=1 Z=nan
refuses "nothing but NaN depth" 1 'nanz.exr: no pixel has finite' "$DDOF" render "$work/nanz.exr" -o "$o" $lens
refuses "nothing but NaN depth, coc" 1 'nanz.exr: no pixel has finite depth' "$DDOF" coc "$work/nanz.exr" -o "$o" $lens
refuses "focus on NaN depth" 1 '--focus-at: ' "$DDOF" render "$work/nanz.exr" -o "$o" --fstop 2 --focus-at 3,3

# --- places that cannot be written to
refuses "no such folder" 1 "nowhere/out.exr: folder '.*nowhere': No such file" "$DDOF" render "$in" -o "$work/nowhere/out.exr" $lens
refuses "a file as folder" 1 'in.exr/out.exr: ' "$DDOF" render "$in" -o "$in/out.exr" $lens
mkdir "$work/dir.exr"
refuses "output is a folder" 1 'dir.exr: is a folder' "$DDOF" render "$in" -o "$work/dir.exr" $lens
refuses "folder of the system" 1 '/proc/out.exr' "$DDOF" render "$in" -o /proc/out.exr $lens
refuses "preview elsewhere" 1 "nowhere/p.png: folder" "$DDOF" render "$in" -o "$o" --preview "$work/nowhere/p.png" $lens
refuses "preview in another format" 2 '--preview: .*p.exr: previews are PNG' "$DDOF" render "$in" -o "$o" --preview "$work/o/p.exr" $lens
refuses "preview over the output" 2 '--preview: .*is the output too' "$DDOF" render "$in" -o "$work/o/p.png" --preview "$work/o/p.png" $lens
if [ "$(id -u)" -ne 0 ]; then
    mkdir "$work/closed"
    chmod 555 "$work/closed"
    refuses "unwritable folder" 1 "closed/out.exr: folder '.*closed': Permission denied" "$DDOF" render "$in" -o "$work/closed/out.exr" $lens
else
    skip "unwritable folder" "root writes everywhere"
fi
# a limit of the size of files stands for a full disk: the write fails in the middle
make "$work/large.exr" 640 480 float 32 R=noise G=noise B=noise Z=noise
for ending in exr png tif pfm; do
    refuses "full disk, $ending" 1 "out.$ending: " sh -c "ulimit -f 64; exec '$DDOF' render '$work/large.exr' -o '$work/o/out.$ending' $lens --quiet"
done
if [ -w /dev/shm ] && [ "$(id -u)" -eq 0 ] && mkdir "$work/disk" && mount -t tmpfs -o size=256k none "$work/disk" 2>/dev/null; then
    refuses "full disk" 1 'disk/out.exr: .*(full|[Nn]o space)' "$DDOF" render "$work/large.exr" -o "$work/disk/out.exr" $lens
    check "full disk: nothing left" sh -c "[ -z \"\$(ls -A '$work/disk')\" ]"
    umount "$work/disk"
else
    skip "full disk" "no tmpfs can be mounted"
fi
echo precious >"$work/kept.exr"
run sh -c "ulimit -f 64; exec '$DDOF' render '$work/large.exr' -o '$work/kept.exr' $lens --quiet"
check "a failed write leaves what was there" sh -c "[ $status -eq 1 ] && [ \"\$(cat '$work/kept.exr')\" = precious ]"
done_testing
