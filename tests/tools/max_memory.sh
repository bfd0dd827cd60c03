# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# --max-memory: the same bytes as without it, within the limit, and no file left behind however it ends.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
o=$work/o/out.exr
in=$work/in.exr
lens="--fstop 2 --focus 4 --threads 2"
make() { "$FIXTURE" make "$@"; }
make "$in" 16 8 half 16 R=noise G=noise B=noise A=1 Z=ramp:1:20

# --- what is said
for value in '' 0 -5 M 12Q 512MB 1.5G 0x10 ' 1M' 1e9 99999999T; do
    refuses "--max-memory '$value'" 2 '--max-memory: .*(number of bytes|out of range)' "$DDOF" render "$in" -o "$o" $lens "--max-memory=$value"
done
refuses "--scratch alone" 2 '--scratch: needs --max-memory too' "$DDOF" render "$in" -o "$o" $lens --scratch "$work"
refuses "no such folder" 1 "--scratch: '.*nowhere': No such file" "$DDOF" render "$in" -o "$o" $lens --max-memory 1G --scratch "$work/nowhere"
refuses "a file as the folder" 1 "--scratch: '.*in.exr': is no folder" "$DDOF" render "$in" -o "$o" $lens --max-memory 1G --scratch "$in"
refuses "too little" 2 '--max-memory: 1M is too little for a picture 16 pixels wide; give at least [0-9]+M' "$DDOF" render "$in" -o "$o" $lens --max-memory 1M
refuses "too little, coc" 2 '--max-memory: 1k is too little' "$DDOF" coc "$in" -o "$o" $lens --max-memory=1k
refuses "reference" 1 '--max-memory: .*backend reference.*use --backend cpu' "$DDOF" render "$in" -o "$o" $lens --max-memory 1M --backend reference
passes "a picture within the limit" "$DDOF" render "$in" -o "$o" $lens --max-memory 1g --json
check "is in memory" test "$(member streamed)" = false
rm -f "$o"

# --- the same bytes
# A picture larger than the least limit there is, which depends on what this build itself takes.
wide=2000 high=1000
[ -n "$DDOF_TEST_QUICK" ] && wide=3000 high=2000
"$FIXTURE" rows "$work/rows.exr" $wide $high half
"$DDOF" render "$work/rows.exr" -o "$o" $lens --max-memory 1M 2>"$work/err"
limit=$(sed -n 's/.*give at least \([0-9]*\)M.*/\1/p' "$work/err")
check "the least limit is said" test -n "$limit"
limit=$((limit + 16))M # what a process holds at its start varies
mkdir "$work/scratch"

# same NAME ENDING ARGUMENTS...: one file with and without a limit.
same() {
    case=$1 ending=$2
    shift 2
    passes "$case in memory" "$DDOF" "$@" -o "$work/whole.$ending" -q
    passes "$case from files" "$DDOF" "$@" -o "$work/files.$ending" --max-memory $limit --scratch "$work/scratch" --json
    if [ "$1" = render ]; then check "$case is streamed" test "$(member streamed)" = true; fi
    check "$case has the same bytes" cmp "$work/whole.$ending" "$work/files.$ending"
    rm -f "$work/whole.$ending" "$work/files.$ending"
}
same "heat" exr render "$work/rows.exr" $lens
for ending in png tif pfm; do same "heat to $ending" $ending render "$work/rows.exr" $lens; done
same "coc" exr coc "$work/rows.exr" $lens
same "false colour" png coc "$work/rows.exr" $lens
for ending in png tif pfm; do
    "$DDOF" render "$work/rows.exr" -o "$work/from.$ending" --focus 4 --max-coc 0 -q
    same "$ending to itself" $ending render "$work/from.$ending" $lens --depth "$work/rows.exr:Z"
    rm -f "$work/from.$ending"
done
same "disc and highlights" exr render "$work/rows.exr" $lens --kernel disc --quality draft --bokeh-threshold 0.99
same "layers" exr render "$work/rows.exr" $lens --layers auto
same "gaussian" exr render "$work/rows.exr" $lens --method gaussian
same "holdout, scaled CoC" exr render "$work/rows.exr" --threads 2 --coc "$work/rows.exr:Z" --coc-scale 2 --holdout "$work/rows.exr:R"
passes "preview in memory" "$DDOF" render "$work/rows.exr" -o "$o" $lens --preview "$work/whole.png" -q
passes "preview from files" "$DDOF" render "$work/rows.exr" -o "$o" $lens --preview "$work/files.png" --max-memory $limit -q
check "preview has the same bytes" cmp "$work/whole.png" "$work/files.png"
rm -f "$o"
ln -s rows.exr "$work/shot.1.exr"
ln -s rows.exr "$work/shot.2.exr"
"$DDOF" render "$work/rows.exr" -o "$work/whole.exr" $lens -q
passes "two frames at a time, from files" "$DDOF" render "$work/shot.#.exr" -o "$work/shot.out.#.exr" $lens --in-flight 2 --max-memory $((2 * ${limit%M}))M --scratch "$work/scratch" --json
check "both are streamed" test "$(grep -c '"streamed": *true' "$work/out")" -eq 2
for frame in 1 2; do check "frame $frame has the same bytes" cmp "$work/whole.exr" "$work/shot.out.$frame.exr"; done
refuses "two frames at a time, too little" 2 '--max-memory: .*give at least [0-9]+M, or --in-flight 1' "$DDOF" render "$work/shot.#.exr" -o "$work/o/shot.#.exr" $lens --in-flight 2 --max-memory 2M
check "no file is left" test -z "$(ls -A "$work/scratch")"
rm -f "$o"

# --- no room
largest() ( # BLOCKS COMMAND...: a limit on the size of files, in blocks of 512 bytes
    blocks=$1
    shift
    ulimit -f "$blocks"
    exec "$@"
)
refuses "file too large" 1 "--scratch: '.*': a file of [0-9]+ MiB is larger than files may be here" largest 4096 "$DDOF" render "$work/rows.exr" -o "$o" $lens --max-memory $limit
mkdir "$work/small"
if mount -t tmpfs -o size=4m tmpfs "$work/small" 2>/dev/null; then
    refuses "full disk" 1 "--scratch: '.*small': the disk is full: [0-9]+ MiB are needed, [0-9]+ are free; free space or give" "$DDOF" render "$work/rows.exr" -o "$o" $lens --max-memory $limit --scratch "$work/small"
    check "full disk: nothing is left" test -z "$(ls -A "$work/small")"
    umount "$work/small"
    mount -t tmpfs -o size=1g tmpfs "$work/small"
    passes "scratch in memory" "$DDOF" render "$work/rows.exr" -o "$o" $lens --max-memory $limit --scratch "$work/small"
    check "scratch in memory is noted" grep -q "note: --scratch: '.*small' is itself in memory" "$work/err"
    umount "$work/small"
    rm -f "$o"
else
    skip "full disk" "only root may mount one"
fi

# --- stopped
for signal in INT TERM KILL; do
    "$DDOF" render "$work/rows.exr" -o "$o" $lens --kernel disc --quality best --max-memory $limit --scratch "$work/scratch" -q 2>"$work/err" &
    process=$!
    sleep 0.5
    listed=$(ls -A "$work/scratch")
    kill -$signal $process
    wait $process 2>/dev/null
    status=$?
    if [ $status -eq 0 ]; then # it was faster than the signal
        skip "SIG$signal" "it had ended already"
        rm -f "$o"
        continue
    fi
    ok "SIG$signal stops it"
    check "SIG$signal: files have no name" test -z "$listed$(ls -A "$work/scratch")"
    if [ $signal != KILL ]; then check "SIG$signal leaves nothing" test -z "$(ls -A "$work/o")"; fi
    rm -rf "$work/o"
    mkdir "$work/o"
done

# --- within the limit
if [ -n "$DDOF_TEST_QUICK" ]; then
    skip "peak within the limit" "a sanitizer's own memory counts"
else
    "$FIXTURE" rows "$work/middle.exr" 6000 4000 half
    passes "6000 x 4000 in 128M" "$DDOF" render "$work/middle.exr" -o "$o" $lens --max-memory 128M --json
    check "is streamed" test "$(member streamed)" = true
    above "peak within the limit" $((128 << 20)) "$(member peak_rss_bytes)"
    passes "6000 x 4000 coc in 128M" "$DDOF" coc "$work/middle.exr" -o "$o" $lens --max-memory 128M
fi
done_testing
