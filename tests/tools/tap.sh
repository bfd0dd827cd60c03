# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# What the tests of the command share. Sourced, not run. Prints TAP, so that every check counts as a test.
# Environment: DDOF the command, FIXTURE tests/tools/fixture, SOURCE the root of the sources; DDOF_DATA the folder with
# scenes/ and openexr-images/ (default: ../shared/data beside the sources).
# shellcheck shell=sh

: "${DDOF:?}" "${FIXTURE:?}" "${SOURCE:?}"
if [ ! -x "$DDOF" ] || [ ! -x "$FIXTURE" ]; then
    echo "Bail out! $DDOF or $FIXTURE is not there"
    exit 1
fi
DATA=${DDOF_DATA:-$SOURCE/../shared/data}
checks=0
failures=0
status=0
work=$(mktemp -d "${TMPDIR:-/tmp}/ddof-test.XXXXXX") || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT PIPE TERM
mkdir "$work/o"
unset LC_ALL LANG 2>/dev/null
export LC_ALL=C

ok() {
    checks=$((checks + 1))
    echo "ok $checks - $1"
}

not_ok() {
    checks=$((checks + 1))
    failures=$((failures + 1))
    echo "not ok $checks - $1"
    [ -f "$work/err" ] && sed 's/^/#   stderr: /' "$work/err" | head -5
    shift
    for line; do echo "#   $line"; done
}

skip() {
    checks=$((checks + 1))
    echo "ok $checks - $1 # SKIP $2"
}

# check DESCRIPTION COMMAND...: the command succeeds.
check() {
    about=$1
    shift
    if "$@" >"$work/check" 2>&1; then ok "$about"; else not_ok "$about" "failed: $*" "$(head -3 "$work/check")"; fi
}

# run COMMAND...: sets $status; output in $work/out and $work/err.
run() {
    "$@" >"$work/out" 2>"$work/err"
    status=$?
}

# passes DESCRIPTION COMMAND...: exit code 0.
passes() {
    about=$1
    shift
    run "$@"
    if [ $status -eq 0 ]; then ok "$about"; else not_ok "$about" "exit code $status of: $*"; fi
}

# refuses DESCRIPTION CODE PATTERN COMMAND...: that exit code, nothing on standard output, one line on standard error that begins
# with "ddof: " and matches the pattern, and nothing left in $work/o.
refuses() {
    about=$1 code=$2 pattern=$3
    shift 3
    run "$@"
    if [ $status -ne "$code" ]; then
        not_ok "$about" "exit code $status instead of $code: $*"
    elif [ -s "$work/out" ]; then
        not_ok "$about" "standard output: $(head -1 "$work/out")"
    elif [ "$(wc -l <"$work/err")" -ne 1 ]; then
        not_ok "$about" "not one line on standard error"
    elif ! grep -q '^ddof: ' "$work/err" || ! grep -Eq -e "$pattern" "$work/err"; then
        not_ok "$about" "does not say '$pattern'"
    elif [ -n "$(ls -A "$work/o")" ]; then
        not_ok "$about" "left behind: $(ls -A "$work/o")"
        rm -rf "$work/o"
        mkdir "$work/o"
    else
        ok "$about"
    fi
}

# near DESCRIPTION A B TOLERANCE: two numbers agree.
near() {
    if awk -v a="$2" -v b="$3" -v t="$4" 'BEGIN { d = a - b; exit !(d <= t && -d <= t) }'; then
        ok "$1"
    else
        not_ok "$1" "$2 is not $3 within $4"
    fi
}

# above DESCRIPTION A B: A > B.
above() {
    if awk -v a="$2" -v b="$3" 'BEGIN { exit !(a > b) }'; then ok "$1"; else not_ok "$1" "$2 is not above $3"; fi
}

# member KEY: of the object that the last run printed.
member() { "$FIXTURE" json "$1" <"$work/out"; }

# has_members DESCRIPTION KEY...: the last run printed one JSON object that has them all.
has_members() {
    about=$1
    shift
    for key; do
        member "$key" >/dev/null 2>&1 || {
            not_ok "$about" "no member $key in: $(head -c 200 "$work/out")"
            return
        }
    done
    ok "$about"
}

done_testing() {
    echo "1..$checks"
    [ $failures -eq 0 ]
}
