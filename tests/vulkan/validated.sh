#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# validated.sh PROGRAM [ARGUMENT...]: runs a test program under Vulkan's validation layers, synchronization validation included,
# and adds a test of its own to what it prints: that they said nothing. It is skipped where they are not installed.
set -u
dir=$(mktemp -d "${TMPDIR:-/tmp}/ddof-validated.XXXXXX") || exit 1
trap 'rm -rf "$dir"' EXIT
trap 'exit 1' HUP INT PIPE TERM
cat >"$dir/vk_layer_settings.txt" <<END
khronos_validation.debug_action = VK_DBG_LAYER_ACTION_LOG_MSG
khronos_validation.log_filename = /dev/fd/9
khronos_validation.report_flags = error,warn,info
khronos_validation.enables = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT
END

installed=
for place in "${VK_LAYER_PATH:-/usr/share/vulkan/explicit_layer.d}" /usr/share/vulkan/explicit_layer.d \
    /usr/local/share/vulkan/explicit_layer.d /etc/vulkan/explicit_layer.d \
    "${XDG_DATA_HOME:-${HOME:-/}/.local/share}/vulkan/explicit_layer.d"; do
    [ -f "$place/VkLayer_khronos_validation.json" ] && installed=yes
done
if [ -n "$installed" ]; then
    VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation
    VK_LAYER_SETTINGS_PATH=$dir
    export VK_INSTANCE_LAYERS VK_LAYER_SETTINGS_PATH
fi

# Through a pipe: each instance opens the log anew, and would empty a file.
{ "$@" 9>&1 >"$dir/out"; echo $? >"$dir/status"; } | cat >"$dir/log"
status=$(cat "$dir/status")
count=$(grep -c -E '^(not )?ok ' "$dir/out")
sed "s/^1\.\.$count\$/1..$((count + 1))/" "$dir/out"
name="$((count + 1)) - the validation layers say nothing"
if [ -z "$installed" ]; then
    echo "ok $name # SKIP they are not installed"
elif grep 'msgNum:' "$dir/log" | grep -q -v '(INFO'; then
    echo "not ok $name"
    grep 'msgNum:' "$dir/log" | grep -v '(INFO' | sed 's/^/# /' | cut -c 1-900 | head -n 60
    status=1
elif grep -q 'Enables:.*SYNCHRONIZATION_VALIDATION' "$dir/log"; then # it says so itself
    echo "ok $name"
elif grep -E '^ok ' "$dir/out" | grep -q -v '# SKIP'; then
    echo "not ok $name"
    echo "# they were not loaded"
    status=1
else
    echo "ok $name # SKIP nothing was run"
fi
exit "$status"
