#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# Shots: patterns, lists of frames, several in flight, what fails, what is resumed, signals.
# shellcheck source=tests/tools/tap.sh
. "${SOURCE:?}/tests/tools/tap.sh"
cd "$work" || exit 1
lens="--fstop 1.4 --focus 4"

mkdir s
for n in 1 2 3 4 5 6 8; do
    "$FIXTURE" make "s/a.000$n.exr" 40 30 half 16 "R=noise@$n,3=9" G=ramp:0:1 B=down:0:2 A=1 Z=ramp:2:20
done
"$FIXTURE" make s/a.10000.exr 40 30 half 16 R=noise G=0.1 B=1 A=1 Z=ramp:2:20
cp s/a.0001.exr s/a.01.exr # not of the pattern: too few digits
cp s/a.0001.exr s/a.0007.exr.bak

fresh() {
    rm -rf o
    mkdir o
}
frames_of() { (cd "$1" && ls) | tr '\n' ' '; }
is() { if [ "$2" = "$3" ]; then ok "$1"; else not_ok "$1" "got '$2' instead of '$3'"; fi; }
# line N KEY...: of the Nth object that was printed
line() {
    sed -n "$1p" out | "$FIXTURE" json "$2"
}

# ------------------------------------------------------------------------- patterns

run "$DDOF" render 's/a.####.exr' -o 'o/b.####.exr' $lens
is "every file of the pattern" "$(frames_of o)" "b.0001.exr b.0002.exr b.0003.exr b.0004.exr b.0005.exr b.0006.exr b.0008.exr b.10000.exr "
for n in 0001 0005 10000; do
    "$DDOF" render "s/a.$n.exr" -o single.exr $lens --quiet
    check "frame $n is what it is by itself" cmp single.exr "o/b.$n.exr"
done
check "the last line counts them" grep -q '^8 frames: 8 rendered, 0 left out, 0 failed' out
fresh
run "$DDOF" render 's/a.%04d.exr' -o 'o/%d.png' $lens --frames 1-5x2,8
is "%04d, %d, ranges with a step" "$(frames_of o)" "1.png 3.png 5.png 8.png "
fresh
run "$DDOF" render 's/a.???*.exr' -o 'o/c.###.exr' $lens --frames 2-4
is "a glob, and some of its frames" "$(frames_of o)" "c.002.exr c.003.exr c.004.exr "
fresh
refuses "a glob with one number twice" 2 'same frame number' "$DDOF" render 's/a.*.exr' -o 'o/c.###.exr' $lens
cp s/a.0001.exr 'lit.##.exr'
run "$DDOF" render 'lit.##.exr' -o o/lit.exr $lens
is "a name that exists is a file" "$(frames_of o)" "lit.exr "
fresh
run "$DDOF" coc 's/a.####.exr' -o 'o/coc.####.pfm' $lens --frames 1-2
is "coc, too" "$(frames_of o)" "coc.0001.pfm coc.0002.pfm "
fresh
mkdir z
for n in 1 2; do "$FIXTURE" make "z/d.$n.pfm" 40 30 float 32 "Y=$((n * 3))"; done
run "$DDOF" render 's/a.####.exr' -o 'o/b.####.exr' --frames 1-2 --depth 'z/d.#.pfm' --preview 'o/p.#.png' $lens
"$DDOF" render s/a.0002.exr -o single.exr --depth z/d.2.pfm $lens --quiet
check "depth and preview of the frame's number" cmp single.exr o/b.0002.exr
is "a preview for each" "$(frames_of o)" "b.0001.exr b.0002.exr p.1.png p.2.png "
fresh
passes "--method none reads and writes" "$DDOF" render 's/a.####.exr' -o 'o/b.####.exr' --method none $lens --frames 1
for c in R G B A Z; do check "--method none changes nothing in $c" "$FIXTURE" same s/a.0001.exr o/b.0001.exr $c; done
fresh

# ------------------------------------------------------------------------- the same whatever is in flight

for n in 1 2 7; do
    "$DDOF" render 's/a.####.exr' -o 'o/b.####.exr' $lens --kernel disc --in-flight $n --threads 3 --json --quiet >out 2>err
    rm -rf o/.ddof
    (cd o && sha256sum b.*) >"sums.$n"
    sed -n 's/.*"frame":\([0-9]*\),.*/\1/p' out | tr '\n' ' ' >order
    is "--in-flight $n: reports in order" "$(cat order)" "1 2 3 4 5 6 8 10000 "
done
check "in flight 1 and 2: same bytes" cmp sums.1 sums.2
check "in flight 1 and 7: same bytes" cmp sums.1 sums.7
is "a line for each frame and one for all" "$(wc -l <out)" 9
is "status" "$(line 3 status)" rendered
is "the sum" "$(line 9 rendered)" 8
above "peak memory" "$(line 9 peak_rss_bytes)" 1000000
fresh

# ------------------------------------------------------------------------- what fails

run "$DDOF" render 's/a.####.exr' -o 'o/b.####.exr' $lens --frames 5-9 --keep-going --json
is "--keep-going: the code of the failure" $status 1
is "all others" "$(frames_of o)" "b.0005.exr b.0006.exr b.0008.exr "
is "which failed" "$(line 6 failed)" "[7,9]"
check "and why" grep -q '^ddof: frame 7: s/a.0007.exr: ' err
is "a failed frame has its line" "$(line 3 status)" failed
fresh
head -c 1500 s/a.0003.exr >s/a.0009.exr
run "$DDOF" render 's/a.####.exr' -o 'o/b.####.exr' $lens --frames 7-9,10000 --in-flight 1
is "the first failure ends it" "$status $(frames_of o)" "1 "
check "what was not begun is said" grep -q 'stopped at the first failure, 3 frames were not begun' err
run "$DDOF" render 's/a.####.exr' -o 'o/b.####.exr' $lens --frames 8-9 -k
is "a damaged frame" "$status $(frames_of o)" "1 b.0008.exr "
rm s/a.0009.exr
fresh
refuses "one output for all" 2 'every frame would be written' "$DDOF" render 's/a.####.exr' -o o/b.exr $lens
refuses "one preview for all" 2 'preview: o/p.png: every frame' "$DDOF" render 's/a.####.exr' -o 'o/#.exr' --preview o/p.png $lens
refuses "no file of the pattern" 1 'no file of this pattern' "$DDOF" render 's/q.####.exr' -o 'o/b.####.exr' $lens
refuses "no folder of the pattern" 1 "folder 'no/'" "$DDOF" render 'no/q.####.exr' -o 'o/b.####.exr' $lens
refuses "no file of the glob" 1 'no such file' "$DDOF" render 's/q.*.exr' -o 'o/b.####.exr' $lens
refuses "--frames of one file" 2 'is one file' "$DDOF" render s/a.0001.exr -o 'o/b.####.exr' --frames 1 $lens
refuses "--resume of one file" 2 'is for several frames' "$DDOF" render s/a.0001.exr -o o/b.exr --resume $lens
for list in '' x 1- -5 5-1 1,1 2-5,3 1-5x0 1-5x '1 2' 1,,2 1, 99999999999 0-99999999 -1-3; do
    refuses "--frames '$list'" 2 '^ddof: --frames: ' "$DDOF" render 's/a.####.exr' -o 'o/b.####.exr' --frames="$list" $lens
done
refuses "a wrong lens, once for all" 2 '' "$DDOF" render 's/a.####.exr' -o 'o/b.####.exr' --focus 4 --keep-going --in-flight 1
refuses "many files" 2 'one pattern, like' "$DDOF" render s/a.0001.exr s/a.0002.exr -o 'o/b.####.exr' $lens

# ------------------------------------------------------------------------- resume

fresh
again() {
    "$DDOF" render 's/a.####.exr' -o 'o/b.####.exr' --frames 1-4 --resume --json "$@" >out 2>err
    line 5 rendered
}
is "nothing is there: all" "$(again $lens)" 4
is "again: none" "$(again $lens)" 0
is "what is left out says so" "$(line 1 status)" skipped
is "threads and in flight do not count" "$(again $lens --threads 1 --in-flight 1 --quiet)" 0
is "other settings: all" "$(again --fstop 2 --focus 4)" 4
is "the first settings: all" "$(again $lens)" 4
truncate -s -1 o/b.0002.exr
is "an output that was cut off" "$(again $lens)" 1
cp s/a.0001.exr o/b.0003.exr
is "another file in the output's place" "$(again $lens)" 1
rm o/b.0004.exr
is "one that is gone" "$(again $lens)" 1
cp s/a.0005.exr s/a.0002.exr
is "another input" "$(again $lens)" 1
"$DDOF" render s/a.0002.exr -o single.exr $lens --quiet
check "is what was rendered" cmp single.exr o/b.0002.exr
echo '{"made_of": 3' >o/.ddof/b.0001.exr.json
is "a damaged record" "$(again $lens)" 1
is "a record of another shape" "$(echo '[]' >o/.ddof/b.0001.exr.json; again $lens)" 1
rm -rf o/.ddof
is "no records" "$(again $lens)" 4
"$FIXTURE" make z/m.png 40 30 half 8 Y=ramp:0:1
is "a holdout" "$(again $lens --holdout z/m.png)" 4
is "the same holdout" "$(again $lens --holdout z/m.png)" 0
touch -d '2001-02-03' z/m.png
is "a changed holdout" "$(again $lens --holdout z/m.png)" 4

# ------------------------------------------------------------------------- signals

fresh
for n in 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30; do cp s/a.0001.exr "s/a.00$n.exr"; done
for signal in INT TERM; do
    fresh
    "$DDOF" render 's/a.####.exr' -o 'o/b.####.exr' $lens --frames 11-30 --in-flight 2 >out 2>err &
    pid=$!
    n=0
    while [ ! -e o/b.0012.exr ] && [ $n -lt 500 ]; do
        sleep 0.01
        n=$((n + 1))
    done
    kill -$signal $pid
    wait $pid
    status=$?
    if [ $status -eq 0 ]; then # it was faster than the signal
        skip "$signal in the middle" "it had ended already"
    else
        is "$signal: the code" $status 130
        check "$signal: what is complete is counted" grep -Eq "interrupted; $(ls o | wc -l) frames are complete" err
        is "$signal: no temporary file is left" "$(find o -name '*.tmp')" ""
    fi
    run "$DDOF" render 's/a.####.exr' -o 'o/b.####.exr' $lens --frames 11-30 --resume --quiet
    is "$signal: --resume does the rest" "$status $(ls o | wc -l)" "0 20"
    check "$signal: with the same bytes" cmp o/b.0011.exr o/b.0030.exr
done
done_testing
