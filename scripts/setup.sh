#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT

# setup.sh PURPOSE...: installs the Debian packages that PURPOSE (build, test, arm64, farm) needs and this system lacks. Where it
# may not, it prints the line that does, and fails. What ddof can do without is installed where it can be had, and else left out.
set -eu

packages() {
    case $1 in
    build) echo gcc g++ meson ninja-build pkg-config libopenexr-dev libpng-dev libtiff-dev libdeflate-dev libcjson-dev libegl-dev libgles-dev libvulkan-dev glslc libglfw3-dev ;;
    test) echo libcmocka-dev binutils python3 libegl1 libgl1-mesa-dri libvulkan1 mesa-vulkan-drivers vulkan-validationlayers chromium python3-numpy ;;
    arm64) echo gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user ;;
    farm) echo slurmctld slurmd slurm-client munge ;;
    *) echo "setup.sh: no such purpose: $1" >&2; exit 2 ;;
    esac
}

optional() {
    case $1 in
    build) echo libheif-dev libjxl-dev ;;
    esac
}

installed() {
    dpkg-query -W -f '${db:Status-Status}\n' "$1" 2>/dev/null | grep -qx installed
}

missing=
for purpose; do
    for package in $(packages "$purpose"); do
        installed "$package" || missing="$missing $package"
    done
done
if [ "$(id -u)" = 0 ]; then # else not worth a failure
    for purpose; do
        for package in $(optional "$purpose"); do
            installed "$package" || ! apt-cache show "$package" >/dev/null 2>&1 || missing="$missing $package"
        done
    done
fi
[ -n "$missing" ] || exit 0

line="apt-get install -y --no-install-recommends$missing"
if ! command -v apt-get >/dev/null; then
    echo "This is no Debian system: install the equivalents of these packages, then run make again:$missing" >&2
    exit 1
fi
if [ "$(id -u)" = 0 ]; then
    as_root=
elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
    as_root=sudo
else
    echo "Some packages are missing. As root, run this line, then make again:" >&2
    echo "    apt-get update && $line" >&2
    exit 1
fi
echo "Installing:$missing"
log=$(mktemp)
if ! { $as_root env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=600 update &&
       $as_root env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=600 install -y --no-install-recommends $missing
     } >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    rm -f "$log"
    echo "Installing failed. The line was: apt-get update && $line" >&2
    exit 1
fi
rm -f "$log"
