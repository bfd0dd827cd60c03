# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# For tests that load drivers: the same software ones everywhere. Sourced after tap.sh.
# shellcheck shell=sh disable=SC2154,SC2034

# a driver keeps memory until the process ends, and the mutexes within it are not seen whole
ASAN_OPTIONS="${ASAN_OPTIONS:-}:detect_leaks=0"
TSAN_OPTIONS="${TSAN_OPTIONS:-}:ignore_noninstrumented_modules=1"
LIBGL_ALWAYS_SOFTWARE=1
: "${MESA_SHADER_CACHE_DIR:=$work}"
export ASAN_OPTIONS TSAN_OPTIONS LIBGL_ALWAYS_SOFTWARE MESA_SHADER_CACHE_DIR
for icd in /usr/share/vulkan/icd.d/lvp_icd.*.json; do
    [ -f "$icd" ] && VK_ICD_FILENAMES=$icd && export VK_ICD_FILENAMES
done
# for a command that is to find no Vulkan driver; a loader that cannot be led astray leaves the test to be skipped
no_vulkan="env VK_ICD_FILENAMES=/nonexistent VK_DRIVER_FILES=/nonexistent"
