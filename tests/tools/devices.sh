# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
#
# ddof devices: what it lists, and what it says where there is nothing.
# shellcheck shell=sh disable=SC2154,SC2086
. "${SOURCE:?}/tests/tools/tap.sh"
. "${SOURCE:?}/tests/tools/drivers.sh"
device_members="index name driver usable refused is_software max_side subgroup_least subgroup_most max_workgroup shared_bytes memory_bytes"

# counts LIST: how many devices the last run's object has there.
counts() {
    n=0
    while member "$1.devices.$n.index" >/dev/null 2>&1; do n=$((n + 1)); done
    echo $n
}

# --- the processor
passes "devices" "$DDOF" devices
check "devices: the best instruction set" grep -Eq '^  (baseline|avx2|avx512|neon) \(best\)' "$work/out"
for backend in gl vulkan; do
    check "devices: $backend, or that there is none" grep -Eq "^$backend:( no device: .+)?$" "$work/out"
done
passes "devices --json" "$DDOF" devices --json
has_members "devices: members" version cpu.name cpu.best cpu.available gl.devices gl.why_none vulkan.devices vulkan.why_none
check "devices: the best is available" sh -c "echo '$(member cpu.available)' | grep -q '\"$(member cpu.best)\"'"
best=$(member cpu.best)
passes "devices: the best can be asked for" "$DDOF" bench --size 8x8 --runs 1 --cpu "$best" --json
check "devices: and is what works" test "$(member device)" = "$best"
passes "devices --quiet" "$DDOF" devices --quiet
check "devices --quiet prints nothing" test ! -s "$work/out"
passes "devices --quiet --json" "$DDOF" devices --quiet --json
has_members "devices --quiet: still the object" cpu.best

# --- what it is not asked
refuses "devices with a file" 2 'one argument too many' "$DDOF" devices x
refuses "devices --threads" 2 "--threads: not an option of .ddof devices." "$DDOF" devices --threads 2
refuses "devices --backend" 2 "--backend: not an option of .ddof devices." "$DDOF" devices --backend gl

# --- no Vulkan
passes "no Vulkan" $no_vulkan "$DDOF" devices
if grep -q '^vulkan: no device' "$work/out"; then
    check "no Vulkan: says why" grep -Eq '^vulkan: no device: .+' "$work/out"
    passes "no Vulkan, as JSON" $no_vulkan "$DDOF" devices --json
    check "no Vulkan: an empty list" test "$(member vulkan.devices)" = '[]'
    check "no Vulkan: why" test -n "$(member vulkan.why_none)"
else
    skip "no Vulkan" "this loader finds one all the same"
fi

# --- each backend's devices
"$DDOF" devices >"$work/text" 2>/dev/null
for backend in gl vulkan; do
    run "$DDOF" devices --json
    count=$(counts $backend)
    if [ "$count" -eq 0 ]; then
        skip "$backend devices" "none here"
        continue
    fi
    check "$backend: devices, so no reason for none" test "$(member $backend.why_none)" = null
    listed=$(sed -n "/^$backend:/,/^vulkan:/p" "$work/text" | sed '1d' | grep -Ec '^  [0-9]+: .')
    near "$backend: the text lists as many" "$listed" "$count" 0
    refused_before=no
    i=0
    while [ $i -lt "$count" ]; do
        at=$backend.devices.$i
        members=
        for key in $device_members; do members="$members $at.$key"; done
        has_members "$backend $i: members" $members
        near "$backend $i: index" "$(member $at.index)" $i 0
        check "$backend $i: name" test -n "$(member $at.name)"
        if [ "$(member $at.usable)" = true ]; then
            above "$backend $i: pictures" "$(member $at.max_side)" 1023
            check "$backend $i: refused is null" test "$(member $at.refused)" = null
            check "$backend $i: those that can be used come first" test $refused_before = no
        else
            refused_before=yes
            check "$backend $i: says why it is refused" test -n "$(member $at.refused)"
        fi
        i=$((i + 1))
    done
done
done_testing
