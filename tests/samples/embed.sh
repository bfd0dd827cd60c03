# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# samples/vulkan_embed on the first Vulkan driver of this machine. Prints TAP. Environment: VULKAN_EMBED the program.
# shellcheck shell=sh
: "${VULKAN_EMBED:?}"
work=$(mktemp -d "${TMPDIR:-/tmp}/ddof-test.XXXXXX") || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT PIPE TERM
export LC_ALL=C
# a driver keeps memory until the process ends, and the mutexes within it are not seen whole
export ASAN_OPTIONS="${ASAN_OPTIONS:-}:detect_leaks=0" TSAN_OPTIONS="${TSAN_OPTIONS:-}:ignore_noninstrumented_modules=1"
checks=0
failures=0

# is DESCRIPTION COMMAND...: the command succeeds.
is() {
    about=$1
    shift
    checks=$((checks + 1))
    if "$@"; then
        echo "ok $checks - $about"
    else
        failures=$((failures + 1))
        echo "not ok $checks - $about"
        sed 's/^/#   /' "$work/said" | head -5
    fi
}

# embed FOLDER ARGUMENT...: sets $status; what it says is in $work/said.
embed() {
    mkdir -p "$work/$1"
    folder=$work/$1
    shift
    "$VULKAN_EMBED" "$folder" "$@" >"$work/said" 2>&1
    status=$?
}

# detail FRAME: the sum of the differences between neighbouring pixels, over the bytes of the file.
detail() {
    od -An -v -tu1 -w3 "$1" | awk '{ d = $2 - last; sum += d < 0 ? -d : d; last = $2 } END { print sum }'
}

sizes() { [ "$(wc -c <"$1")" -eq $((15 + 320 * 180 * 3)) ]; }
colourful() { [ "$(od -An -v -tu1 -w1 "$1" | sort -u | wc -l)" -gt 64 ]; }
differ() { ! cmp -s "$1" "$2"; }
less() { [ "$(detail "$1")" -lt "$(detail "$2")" ]; }
says() { [ "$status" -eq "$1" ] && [ "$(wc -l <"$work/said")" -eq 1 ] && grep -q "$2" "$work/said"; }

embed lens 3 320x180
if grep -q 'no Vulkan' "$work/said"; then
    echo "1..0 # SKIP $(cat "$work/said")"
    exit 0
fi
is "three frames" [ "$status" -eq 0 ]
is "says nothing" [ ! -s "$work/said" ]
for frame in 0000 0001 0002; do
    is "frame $frame is there and whole" sizes "$work/lens/$frame.ppm"
    is "frame $frame is not constant" colourful "$work/lens/$frame.ppm"
done
is "no fourth frame" [ ! -e "$work/lens/0003.ppm" ]
is "the frames differ" differ "$work/lens/0000.ppm" "$work/lens/0001.ppm"
is "so do the next two" differ "$work/lens/0001.ppm" "$work/lens/0002.ppm"

embed pinhole 1 320x180 1000
is "a pinhole" [ "$status" -eq 0 ]
is "the lens takes detail away" less "$work/lens/0000.ppm" "$work/pinhole/0000.ppm"

embed odd 1 67x35
is "an odd size" [ "$status" -eq 0 ]

embed none 0
is "refuses 0 frames" says 2 '^usage: '
embed none 1 0x5
is "refuses an empty frame" says 2 '^usage: '
embed none 1 100000x1
is "refuses what no GPU can" [ "$status" -eq 1 ]
"$VULKAN_EMBED" "$work/absent" 1 32x32 >"$work/said" 2>&1
status=$?
is "a folder that is not there" says 1 'cannot write'

export VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT
embed validated 2 320x180
if grep -q 'vkCreateInstance gave VkResult -6' "$work/said"; then # no such layer
    checks=$((checks + 1))
    echo "ok $checks - validation # SKIP VK_LAYER_KHRONOS_validation is not installed"
else
    is "validation, and that of synchronisation, says nothing" [ ! -s "$work/said" ]
    is "validation lets it through" [ "$status" -eq 0 ]
fi

echo "1..$checks"
[ $failures -eq 0 ]
