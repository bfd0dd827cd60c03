#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# validation.sh VALIDATED.SH MISUSE: that validated.sh fails where a program uses Vulkan wrongly, in each of the ways that the
# program MISUSE knows, and passes where it does not. In the Test Anything Protocol.
validated=$1 misuse=$2
count=0

check() { # NAME WANTED
    count=$((count + 1))
    out=$(sh "$validated" "$misuse" "$1" 2>&1)
    status=$?
    case $out in
    *'# SKIP'*)
        echo "ok $count - $1 # SKIP no device, or no validation layers"
        return
        ;;
    *'not ok 2 - the validation layers say nothing'*) got=complaint ;;
    *'ok 2 - the validation layers say nothing'*) got=silence ;;
    *) got=nothing ;;
    esac
    if [ "$got" = "$2" ] && { [ "$status" -ne 0 ] || [ "$2" = silence ]; }; then
        echo "ok $count - $1: $2"
    else
        echo "not ok $count - $1: $got, not $2"
        echo "$out" | sed 's/^/# /'
    fi
}

check right silence
check hazard complaint
check image_hazard complaint
check usage complaint
check layout complaint
check leak complaint
echo "1..$count"
