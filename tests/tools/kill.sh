#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# A shot that is killed again and again at any moment: what is under an output's name is whole, and --resume makes the frames
# of an undisturbed run, byte by byte.
# shellcheck source=tests/tools/tap.sh
. "${SOURCE:?}/tests/tools/tap.sh"
cd "$work" || exit 1
kills=50
[ -z "${DDOF_TEST_QUICK:-}" ] || kills=10 # a sanitizer makes it slow and finds nothing more

mkdir s whole
for n in 1 2 3 4 5 6 7 8; do
    "$FIXTURE" make "s/a.$n.exr" 200 120 half 16 "R=noise@$n,3=9" G=ramp:0:1 B=down:0:2 A=1 Z=ramp:2:20
done
shot() (exec "$DDOF" render 's/a.#.exr' -o "$1/b.#.exr" --fstop 1.4 --focus 4 --kernel disc --quiet "$2")
shot whole --resume || not_ok "an undisturbed run"
(cd whole && sha256sum b.*.exr) >sums

# milliseconds, 0 to 199
moment() { echo $(($(od -An -N2 -tu2 /dev/urandom) % 200)); }

killed=0 rounds=0 torn=0 wrong=0
while [ $killed -lt $kills ] && [ $rounds -lt 2000 ]; do
    rounds=$((rounds + 1))
    shot o --resume 2>/dev/null &
    pid=$!
    sleep "0.$(printf %03d "$(moment)")"
    kill -KILL $pid 2>/dev/null
    wait $pid 2>/dev/null
    if [ $? -eq 0 ]; then # done before it could be killed: begin anew
        (cd o && sha256sum b.*.exr) | cmp -s - sums || wrong=$((wrong + 1))
        rm -rf o
        mkdir o
        continue
    fi
    killed=$((killed + 1))
    for f in o/b.*.exr; do
        [ -e "$f" ] && ! cmp -s "$f" "whole/${f#o/}" && torn=$((torn + 1))
    done
done
if [ $killed -eq $kills ]; then ok "killed $kills times"; else not_ok "killed $kills times" "only $killed"; fi
if [ $torn -eq 0 ]; then ok "no output was ever half a picture"; else not_ok "no output was ever half a picture" "$torn were"; fi
if [ $wrong -eq 0 ]; then ok "rounds that came to their end"; else not_ok "rounds that came to their end" "$wrong differ"; fi
passes "--resume afterwards" shot o --resume
(cd o && sha256sum b.*.exr) >after
check "the frames of an undisturbed run" cmp sums after
if [ -z "$(find o -name '*.tmp')" ]; then
    ok "nothing of the killed ones is left"
elif (cd o && ls .ddof-*.tmp) >/dev/null 2>&1 && [ "$(stat -f -c %T o)" != ext2/ext3 ]; then
    skip "nothing of the killed ones is left" "this file system has no files without names"
else
    not_ok "nothing of the killed ones is left" "$(find o -name '*.tmp')"
fi
done_testing
