# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# Every allocation of a command fails once, those inside of libpng, libtiff, OpenEXR and cJSON too, and then that one and all after
# it: the command ends with one line and exit code 1, or gives the same picture as ever; no crash, nothing left behind.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
if [ ! -f "${FAILING_MALLOC-}" ]; then
    skip "allocations that fail" "a sanitizer or another C library has allocations of its own"
    done_testing
    exit
fi
export MALLOC_PERTURB_=85 # what is freed is no longer what it was
make() { "$FIXTURE" make "$@"; }
make "$work/in.exr" 16 9 float 32 R=noise G=0.5 B=0.1 A=1 Z=ramp:1:20 mask=0.5
make "$work/half.exr" 16 9 half 16 left.R=noise left.G=0.5 left.B=0.1 left.Z=ramp:1:20
make "$work/in.png" 16 9 float 16 R=noise G=0.5 B=0.1 A=0.5
make "$work/in.tif" 16 9 float 32 R=noise G=0.5 B=0.1
make "$work/eight.tif" 16 9 float 8 R=noise G=0.5 B=0.1
make "$work/in.pfm" 16 9 float 32 R=noise G=0.5 B=0.1
make "$work/z.png" 16 9 float 16 Y=ramp:0:1
cat >"$work/scene.json" <<'END'
{"camera": {"focal_length_mm": 85, "sensor_width_mm": 24}, "depth": {"unit": "m", "convention": "planar", "channel": "Z"},
 "renders": [{"file": "in.exr", "dof": true, "frame": 1, "f_number": 2, "focus_distance_m": 4}]}
END

failing() { # MODE N COMMAND...: sets $status
    mode=$1 n=$2
    shift 2
    if [ "$mode" = one ]; then
        LD_PRELOAD=$FAILING_MALLOC FAIL_AT=$n "$@" >"$work/out" 2>"$work/err"
    else
        LD_PRELOAD=$FAILING_MALLOC FAIL_AT=$n FAIL_ON=1 "$@" >"$work/out" 2>"$work/err"
    fi
    status=$?
} 2>/dev/null # what the shell says of a crash

# libtiff takes zlib where libdeflate has no memory: other bytes, the same pixels.
same_pixels() { # FILE
    case $1 in *.tif) ;; *) return 1 ;; esac
    for channel in R G B; do "$FIXTURE" same "$work/good" "$1" $channel || return 1; done
}

# Sets $bad to what is wrong after a run. Without other programs where all is well: there are thousands of runs.
judge() { # OUTPUT
    lines=0
    while read -r line; do
        case $line in
        "ddof: note: "*) ;;
        "ddof: "*) lines=$((lines + 1)) ;;
        *) lines=99 ;;
        esac
    done <"$work/err"
    if [ $status -eq 0 ]; then
        [ $lines -eq 0 ] || bad="it succeeds, but says $(tail -1 "$work/err")"
        cmp -s "$work/good" "${1:-$work/out}" || same_pixels "$1" || bad="it succeeds with another result"
        [ -z "$1" ] || rm -f "$1"
    elif [ $status -ne 1 ]; then
        bad="exit code $status"
    elif [ $lines -ne 1 ] && ! { [ $mode = all ] && [ $lines -eq 2 ]; }; then # info: the range, and the report without it
        bad="not one line on standard error: $(head -c 300 "$work/err")"
    fi
    for file in "$work"/o/* "$work"/o/.[!.]*; do
        [ ! -e "$file" ] || bad="$bad left behind: $file"
    done
}

# survives DESCRIPTION OUTPUT COMMAND...: OUTPUT "" stands for what is printed
survives() {
    about=$1 output=$2
    shift 2
    rm -f "$work/count"
    FAIL_COUNT=$work/count LD_PRELOAD=$FAILING_MALLOC "$@" >"$work/out" 2>"$work/err"
    status=$?
    total=$(cat "$work/count" 2>/dev/null || echo 0)
    if [ $status -ne 0 ] || [ "$total" -lt 10 ]; then
        not_ok "$about" "exit code $status of: $*; $total allocations"
        return
    fi
    if [ -n "$output" ]; then mv "$output" "$work/good"; else cp "$work/out" "$work/good"; fi
    bad='' failed=0
    for mode in one all; do
        n=1
        while [ $n -le "$total" ] && [ -z "$bad" ]; do
            failing $mode $n "$@"
            [ $status -eq 0 ] || failed=$((failed + 1))
            judge "$output"
            [ -z "$bad" ] || bad="$mode, allocation $n of $total: $bad"
            # not each of them where there are many; where all fail after it, it matters less which is the first
            if [ $mode = one ]; then n=$((n + 1 + total / 400)); else n=$((n + 1 + total / 40)); fi
        done
    done
    rm -f "$work"/o/* "$work"/o/.[!.]*
    if [ -n "$bad" ]; then
        not_ok "$about" "$bad"
    elif [ $failed -eq 0 ]; then
        not_ok "$about" "none of $total allocations was missed"
    else
        ok "$about ($total allocations)"
    fi
}

o=$work/o/out
blur="--focus 3 --max-coc 5 --threads 1"
survives "EXR" "$o.exr" "$DDOF" render "$work/in.exr" -o "$o.exr" $blur -q
survives "EXR, half, a layer" "$o.exr" "$DDOF" render "$work/half.exr" -o "$o.exr" $blur --layer left -q
survives "EXR, two threads" "$o.exr" "$DDOF" render "$work/in.exr" -o "$o.exr" --focus 3 --max-coc 5 --threads 2 -q
survives "EXR to PNG" "$o.png" "$DDOF" render "$work/in.exr" -o "$o.png" $blur -q
survives "EXR to PFM" "$o.pfm" "$DDOF" render "$work/in.exr" -o "$o.pfm" $blur -q
z="--depth $work/z.png --depth-kind inverse"
survives "PNG, depth of a PNG" "$o.png" "$DDOF" render "$work/in.png" -o "$o.png" $blur $z -q
survives "PFM" "$o.pfm" "$DDOF" render "$work/in.pfm" -o "$o.pfm" $blur --depth "$work/in.exr" -q
survives "camera file" "$o.exr" "$DDOF" render "$work/in.exr" -o "$o.exr" --threads 1 --camera "$work/scene.json" -q
printf '{"focus": [[1, 3], [9, 4]], "fstop": [[1, 2]]}' >"$work/keys.json"
survives "keyframes" "$o.exr" "$DDOF" render "$work/in.exr" -o "$o.exr" --threads 1 --animate "$work/keys.json" -q
survives "autofocus" "$o.exr" "$DDOF" render "$work/in.exr" -o "$o.exr" --threads 1 --fstop 2 --autofocus 3,3,4x4 -q
cp "$work/in.exr" "$work/lens.exr"
"$FIXTURE" attribute "$work/lens.exr" focus float 4
"$FIXTURE" attribute "$work/lens.exr" aperture float 2
survives "metadata" "$o.exr" "$DDOF" render "$work/lens.exr" -o "$o.exr" --threads 1 --metadata auto -q
survives "disc, layers, holdout, iris of a picture" "$o.exr" "$DDOF" render "$work/in.exr" -o "$o.exr" $blur -q --kernel disc --layers auto \
    --holdout :mask --bokeh highlights --bokeh-threshold 0.4 --iris "image=$work/z.png"
survives "scatter" "$o.exr" "$DDOF" render "$work/in.exr" -o "$o.exr" $blur -q --method scatter
survives "coc" "$o.exr" "$DDOF" coc "$work/in.exr" -o "$o.exr" $blur -q
survives "info" "" "$DDOF" info "$work/in.exr"
survives "info --json" "" "$DDOF" info "$work/in.exr" --json
survives "compare --json" "" "$DDOF" compare "$work/in.exr" "$work/in.pfm" --json
# libtiff 4.5 follows NULL when it has no memory for a directory: all but its own allocations
export FAIL_NOT=libtiff
survives "EXR to TIFF" "$o.tif" "$DDOF" render "$work/in.exr" -o "$o.tif" $blur -q
survives "TIFF" "$o.tif" "$DDOF" render "$work/in.tif" -o "$o.tif" $blur --depth "$work/in.exr" -q
survives "TIFF of 8 bits" "$o.tif" "$DDOF" render "$work/eight.tif" -o "$o.tif" $blur --depth "$work/in.exr" -q
done_testing
