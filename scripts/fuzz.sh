#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT

# fuzz.sh TARGET [SECONDS]: libFuzzer on one of the targets of tests/fuzz (300 seconds). What it learns lies in
# build-fuzz/found/TARGET and is used by the next run; an input that breaks a rule is left as build-fuzz/found/TARGET-crash-*.
# fuzz.sh --keep TARGET: the smallest part of all that which reaches as much, into tests/fuzz/corpus/TARGET.
set -eu
cd "$(dirname "$0")/.."
keep=
if [ "${1-}" = --keep ]; then
    keep=1
    shift
fi
target=${1:?fuzz.sh TARGET [SECONDS]} seconds=${2:-300} build=build-fuzz
if [ ! -f $build/build.ninja ]; then
    CC=clang CXX=clang++ meson setup $build -Dfuzz=true -Dgl=disabled -Dvulkan=disabled --buildtype=debugoptimized \
        -Db_sanitize=address,undefined -Db_lundef=false -Ddefault_library=static
fi
ninja -C $build "tests/fuzz/fuzz_$target"
corpus=tests/fuzz/corpus/$target found=$build/found/$target
mkdir -p "$found" "$corpus"
export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1:halt_on_error=1}
limits="-max_len=16384 -timeout=20 -rss_limit_mb=2048 -malloc_limit_mb=1024"
if [ -n "$keep" ]; then
    mkdir "$corpus.new"
    # shellcheck disable=SC2086
    $build/tests/fuzz/fuzz_"$target" -set_cover_merge=1 $limits "$corpus.new" "$corpus" "$found"
    rm -r "$corpus"
    mv "$corpus.new" "$corpus"
    du -sb "$corpus"
    exit
fi
# shellcheck disable=SC2086
exec $build/tests/fuzz/fuzz_"$target" $limits -max_total_time="$seconds" -artifact_prefix="$found-" -print_final_stats=1 \
    "$found" "$corpus"
