#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# symbols.sh NM LIBRARY INCLUDE: the shared library exports what the public headers declare, and nothing else.
# In the Test Anything Protocol.
nm=$1 library=$2 include=$3
count=0

none() { # NAME LIST
    count=$((count + 1))
    [ -z "$2" ] && echo "ok $count - $1" && return
    echo "not ok $count - $1"
    echo "$2" | sed 's/^/#   /'
}

exported=$("$nm" -D --defined-only "$library" | awk '{sub(/@.*/, "", $NF); print $NF}' |
    grep -v '^__odr_asan' | sort -u)
declared=$(cat "$include"/ddof/*.h | sed -n 's/^DDOF_API .*[ *]\(ddof_[a-z0-9_]*\)(.*/\1/p' | sort -u)
lines=$(grep -h -c '^DDOF_API ' "$include"/ddof/*.h | awk '{n += $1} END {print n}')

found=$(echo "$declared" | wc -l)
none 'every declaration is understood' "$([ "$found" -eq "$lines" ] || echo "$found of $lines: $declared")"
none 'only names that begin with ddof_' "$(echo "$exported" | grep -v '^ddof_')"
none 'only what a header declares' "$(echo "$exported" | grep '^ddof_' | while read -r name; do
    echo "$declared" | grep -qx "$name" || echo "$name"
done)"
none 'all that the headers declare' "$(echo "$declared" | while read -r name; do
    echo "$exported" | grep -qx "$name" || echo "$name"
done)"
echo "1..$count"
