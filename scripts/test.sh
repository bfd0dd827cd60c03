#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT

# test.sh VARIANT...: builds and runs every test in each variant; the last line counts all of them.
#   release  as it is shipped
#   long     of that what takes many minutes: Vulkan's large pictures and many sizes, whose shaders drivers compile anew
#   asan     AddressSanitizer and UndefinedBehaviorSanitizer
#   tsan     ThreadSanitizer, without GL and Vulkan, whose drivers bring threads that it cannot see into
#   fuzz     every target of tests/fuzz with libFuzzer for two seconds; skipped where there is no clang that has it
#   farm     contrib/slurm on a cluster of one node in a temporary folder; skipped where Slurm is not there and cannot be installed
#   arm64    the library's NEON kernels, cross-compiled, under qemu (-O2: GCC 12 for arm64 crashes on the tests at -O3)
set -u
cd "$(dirname "$0")/.."
passed=0 failed=0 skipped=0

options() {
    case $1 in
    release | long) ;;
    asan) echo --buildtype=debugoptimized -Db_sanitize=address,undefined -Db_lundef=false -Ddefault_library=static ;;
    tsan) echo --buildtype=debugoptimized -Dgl=disabled -Dvulkan=disabled -Db_sanitize=thread -Db_lundef=false -Ddefault_library=static ;;
    farm) ;;
    fuzz) echo -Dfuzz=true --buildtype=debugoptimized -Dgl=disabled -Dvulkan=disabled -Db_sanitize=address,undefined -Db_lundef=false -Ddefault_library=static ;;
    arm64) echo --cross-file build-test/arm64.ini --buildtype=debugoptimized -Dtools=false -Dvulkan=disabled -Ddefault_library=static ;;
    *) echo "test.sh: no such variant: $1 (release, long, asan, tsan, fuzz, farm, arm64)" >&2; exit 2 ;;
    esac
}

# Adds what a JUnit report counted.
count() {
    set -- $(sed -n 's/.*<testsuite name=[^>]* tests="\([0-9]*\)" errors="\([0-9]*\)" failures="\([0-9]*\)" skipped="\([0-9]*\)".*/\1 \2 \3 \4/p' "$1" |
        awk '{ bad = $2 + $3; p += $1 - bad - $4; f += bad; s += $4 } END { print p + 0, f + 0, s + 0 }')
    echo "$variant: $1 passed, $2 failed, $3 skipped"
    passed=$((passed + $1)) failed=$((failed + $2)) skipped=$((skipped + $3))
}

has_libfuzzer() {
    echo 'int LLVMFuzzerTestOneInput(const char *data, long size) { return size < 0 && *data; }' |
        clang -fsanitize=fuzzer,address -x c - -o build-test/libfuzzer 2>/dev/null
}

run() {
    variant=$1 dir=build-test/$1
    flags=$(options "$variant") || exit 2
    echo "== $variant"
    compilers=
    [ "$1" = fuzz ] && compilers="env CC=clang CXX=clang++"
    if ! { [ -f "$dir/build.ninja" ] || $compilers meson setup "$dir" -Dshader_cache="$PWD/build-test/shader_cache" $flags; } >"build-test/$variant.log" 2>&1 ||
       ! ninja -C "$dir" >>"build-test/$variant.log" 2>&1; then
        tail -n 40 "build-test/$variant.log"
        echo "$variant: the build failed (build-test/$variant.log)"
        failed=$((failed + 1))
        return
    fi
    rm -f "$dir/meson-logs/testlog.junit.xml"
    suites="--no-suite long"
    [ "$1" = long ] && suites="--suite long"
    # shellcheck disable=SC2086
    meson test -C "$dir" --no-rebuild --print-errorlogs -t 4 $suites >"build-test/$variant.tests" 2>&1
    status=$?
    sed -n '/^ *[0-9]*\/[0-9]* /p' "build-test/$variant.tests"
    if [ $status -ne 0 ]; then sed -n '/^―/,$p' "build-test/$variant.tests" | tail -n 150; fi
    if [ -f "$dir/meson-logs/testlog.junit.xml" ]; then
        before=$failed
        count "$dir/meson-logs/testlog.junit.xml"
        # a program that crashed before it could report counts once
        [ $status -eq 0 ] || [ $failed -gt $before ] || failed=$((failed + 1))
    else
        failed=$((failed + 1))
    fi
}

# The programs of the release build, and of it no more than is needed.
run_farm() {
    variant=farm dir=build-test/release
    echo "== $variant"
    if ! sh scripts/setup.sh farm >build-test/farm.log 2>&1; then
        echo "farm: skipped, Slurm is not there: $(tail -n 1 build-test/farm.log)"
        skipped=$((skipped + 1))
        return
    fi
    if ! { [ -f "$dir/build.ninja" ] || meson setup "$dir"; } >>build-test/farm.log 2>&1 ||
       ! ninja -C "$dir" tools/ddof tests/tools/fixture >>build-test/farm.log 2>&1; then
        tail -n 40 build-test/farm.log
        echo "farm: the build failed (build-test/farm.log)"
        failed=$((failed + 1))
        return
    fi
    DDOF=$PWD/$dir/tools/ddof FIXTURE=$PWD/$dir/tests/tools/fixture SOURCE=$PWD sh scripts/test_farm.sh >build-test/farm.tests 2>&1
    status=$?
    cat build-test/farm.tests
    bad=$(grep -c '^not ok' build-test/farm.tests)
    [ $status -eq 0 ] || [ "$bad" -gt 0 ] || bad=1
    failed=$((failed + bad))
    passed=$((passed + $(grep '^ok' build-test/farm.tests | grep -vc '# SKIP')))
    skipped=$((skipped + $(grep -c '# SKIP' build-test/farm.tests)))
}

purposes="build test"
for variant; do
    options "$variant" >/dev/null || exit 2
    [ "$variant" = arm64 ] && purposes="$purposes arm64"
done
sh scripts/setup.sh $purposes || exit 1
mkdir -p build-test
sed "s|@ROOT@|$PWD|" scripts/arm64.ini >build-test/arm64.ini
export ASAN_OPTIONS=${ASAN_OPTIONS:-allocator_may_return_null=1} UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1:halt_on_error=1}
export TSAN_OPTIONS=${TSAN_OPTIONS:-halt_on_error=1}
for variant; do
    if [ "$variant" = arm64 ] && ! sh scripts/arm64_cmocka.sh build-test/arm64-root; then
        echo "arm64: skipped, the test framework could not be had for arm64"
        skipped=$((skipped + 1))
        continue
    fi
    if [ "$variant" = fuzz ] && ! has_libfuzzer; then
        echo "fuzz: skipped, there is no clang with libFuzzer"
        skipped=$((skipped + 1))
        continue
    fi
    if [ "$variant" = farm ]; then run_farm; else run "$variant"; fi
done
echo "$passed passed, $failed failed, $skipped skipped"
[ $failed -eq 0 ]
