#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# headers.sh INCLUDE C-COMPILER [C++-COMPILER]: every public header compiles alone, strictly, in C17 and in C++17, and
# so does a program that fills a frame in. In the Test Anything Protocol.
include=$1 c=$2 cxx=$3
strict='-pedantic-errors -Wall -Wextra -Wshadow -Werror -fsyntax-only'
count=0

report() { # STATUS NAME OUTPUT
    count=$((count + 1))
    [ "$1" -eq 0 ] && echo "ok $count - $2" && return
    echo "not ok $count - $2"
    echo "$3" | sed 's/^/# /'
}

compile() { # NAME SOURCE
    # shellcheck disable=SC2086 # a compiler may be several words
    output=$(printf '%b' "$2" | $c -std=c17 -Wstrict-prototypes $strict -I"$include" -x c - 2>&1)
    report $? "$1 in C17" "$output"
    if [ -z "$cxx" ]; then
        count=$((count + 1))
        echo "ok $count - $1 in C++17 # SKIP no C++ compiler"
        return
    fi
    # shellcheck disable=SC2086
    output=$(printf '%b' "$2" | $cxx -std=c++17 $strict -I"$include" -x c++ - 2>&1)
    report $? "$1 in C++17" "$output"
}

# shellcheck disable=SC2086
has_vulkan() { printf '#include <vulkan/vulkan_core.h>\n' | $c -fsyntax-only -x c - 2>/dev/null; }

for header in "$include"/ddof/*.h; do
    name=ddof/${header##*/}
    if [ "$name" = ddof/vulkan.h ] && ! has_vulkan; then # the only one that needs headers from elsewhere
        count=$((count + 1))
        echo "ok $count - $name # SKIP the headers of Vulkan are not installed"
        continue
    fi
    compile "$name" "#include <$name>\n#include <$name>\nint main(void) { return 0; }\n"
done

compile 'a program' '#include <ddof/ddof.h>
int main(void) {
    static float rgba[16], z[4];
    static unsigned short half[4];
    void *planes[1] = {half};
    ddof_context *ctx = NULL;
    static ddof_frame frame;
    static ddof_settings settings;
    frame.color = ddof_image_interleaved(rgba, 2, 2, 4, DDOF_FLOAT, 0);
    frame.depth = ddof_image_interleaved(z, 2, 2, 1, DDOF_FLOAT, 0);
    frame.output = ddof_image_planar(planes, 2, 2, 1, DDOF_HALF, 0);
    if (ddof_create(&ctx, NULL) != DDOF_OK) return 1;
    ddof_status status = ddof_render(ctx, &frame, &settings, NULL);
    ddof_destroy(&ctx);
    return status == DDOF_OK;
}
'
echo "1..$count"
