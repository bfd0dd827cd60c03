# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# Small files that declare large things, within little memory; outputs that must not be touched; a disk that is full.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
o=$work/o/out.exr
lens="--fstop 2 --focal-length 50 --focus 4"
"$FIXTURE" make "$work/in.exr" 64 48 float 32 R=noise G=noise B=noise Z=ramp:1:20
"$FIXTURE" make "$work/z.exr" 64 48 float 32 Z=ramp:1:20
# Sanitizers reserve terabytes: there the sizes alone are looked at.
memory="ulimit -v 1000000"
[ -z "${DDOF_TEST_QUICK-}" ] || memory=:

# bomb DESCRIPTION PATTERN FILE: refused by info or, where its header is right, by render
bomb() {
    refuses "$1" 1 "$2" sh -c "$memory; exec '$DDOF' render '$3' -o '$o' --depth '$work/z.exr' $lens -q"
    refuses "$1, as depth" 1 "$2" sh -c "$memory; exec '$DDOF' render '$work/in.exr' -o '$o' --depth '$3' --depth-kind inverse --focus 4 --max-coc 5 -q"
}

"$FIXTURE" header "$work/wide.exr" 1048576 2047
bomb "EXR of 2 Gpixels without a pixel" 'wide.exr: ' "$work/wide.exr"
"$FIXTURE" header "$work/side.exr" 1048577 1
bomb "EXR of too long a side" 'side.exr: .*too large' "$work/side.exr"
printf 'PF\n1048576 2047\n-1.0\n' >"$work/wide.pfm"
bomb "PFM of 2 Gpixels without a pixel" 'wide.pfm: is cut off' "$work/wide.pfm"
printf 'PF\n99999999999999999999 3\n-1.0\n' >"$work/digits.pfm"
bomb "PFM of a size that is no number of pixels" 'digits.pfm: .*too large' "$work/digits.pfm"
printf '\211\120\116\107\015\012\032\012\000\000\000\015\111\110\104\122\000\020\000\000\000\000\007\377\010\002\000\000\000\231\222\223\373\000\000\000\014\111\104\101\124\170\234\143\140\240\014\000\000\000\100\000\001\267\064\174\357\000\000\000\000\111\105\116\104\256\102\140\202' >"$work/wide.png"
bomb "PNG of 2 Gpixels in 69 bytes" 'wide.png: .*more than its 69 bytes can hold' "$work/wide.png"
# 60000 x 30000 of CCITT fax 4, which no ratio bounds, in a strip of 64 bytes
{
    printf '\111\111\052\000\110\000\000\000'
    head -c 64 /dev/zero | tr '\000' '\377'
    printf '\011\000\000\001\004\000\001\000\000\000\140\352\000\000\001\001\004\000\001\000\000\000\060\165\000\000\002\001\003\000\001\000\000\000\001\000\000\000\003\001\003\000\001\000\000\000\004\000\000\000\006\001\003\000\001\000\000\000\000\000\000\000\021\001\004\000\001\000\000\000\010\000\000\000\025\001\003\000\001\000\000\000\001\000\000\000\026\001\004\000\001\000\000\000\060\165\000\000\027\001\004\000\001\000\000\000\100\000\000\000\000\000\000\000'
} >"$work/fax.tif"
bomb "TIFF of 1.8 Gpixels in 190 bytes" 'fax.tif' "$work/fax.tif"
refuses "TIFF of 1.8 Gpixels in 190 bytes, read" 1 'fax.tif: ' sh -c "$memory; exec '$DDOF' compare '$work/fax.tif' '$work/fax.tif'"

# --- camera files
camera() { # DESCRIPTION PATTERN FILE
    refuses "$1" 1 "$2" sh -c "$memory; exec '$DDOF' coc '$work/in.exr' -o '$o' --camera '$3'"
}
camera "camera file without end" '/dev/zero: larger than 16 MiB' /dev/zero
head -c 200000 /dev/zero | tr '\000' '[' >"$work/deep.json"
camera "camera file of 200000 brackets" 'deep.json: .*not valid JSON' "$work/deep.json"

# --- outputs that someone wants kept
echo precious >"$work/o/kept.exr"
chmod 444 "$work/o/kept.exr"
run "$DDOF" render "$work/in.exr" -o "$work/o/kept.exr" $lens
check "a write-protected output is refused" sh -c "[ $status -eq 1 ] && grep -q 'kept.exr: is write-protected' '$work/err' && [ \"\$(cat '$work/o/kept.exr')\" = precious ]"
check "a write-protected output: nothing else is left" test "$(ls -A "$work/o")" = kept.exr
rm -f "$work/o/kept.exr"
mounted() { [ "$(id -u)" -eq 0 ] && mkdir -p "$work/disk" && mount -t tmpfs -o "$1" none "$work/disk" 2>/dev/null; }
if mounted size=64k,mode=755; then
    cp "$work/in.exr" "$work/disk/in.exr" 2>/dev/null
    head -c 3000 /dev/zero >"$work/disk/old.exr"
    mount -o remount,ro "$work/disk"
    refuses "read-only file system" 1 'disk/out.exr: ' "$DDOF" render "$work/in.exr" -o "$work/disk/out.exr" $lens
    refuses "read-only file system, over a file" 1 'disk/old.exr: ' "$DDOF" render "$work/in.exr" -o "$work/disk/old.exr" $lens
    umount "$work/disk"
else
    skip "read-only file system" "no tmpfs can be mounted"
fi
if mounted size=8k; then
    for ending in exr png tif pfm; do
        refuses "full disk, $ending" 1 "out.$ending: .*(full|[Nn]o space)" "$DDOF" render "$work/in.exr" -o "$work/disk/out.$ending" $lens -q
        check "full disk, $ending: nothing is left" sh -c "[ -z \"\$(ls -A '$work/disk')\" ]"
    done
    umount "$work/disk"
else
    skip "full disk" "no tmpfs can be mounted"
fi
ln -s /dev/full "$work/full.exr"
refuses "/dev/full" 1 'full.exr: .*full' "$DDOF" render "$work/in.exr" -o "$work/full.exr" $lens
check "/dev/full: what leads there is left" test -L "$work/full.exr"
refuses "/dev/full, standard output" 1 'standard output: ' sh -c "exec '$DDOF' info '$work/in.exr' >/dev/full"
done_testing
