#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT

# arm64_cmocka.sh DIR: unpacks Debian's arm64 build of the test framework below DIR, without touching the system's packages.
set -eu
root=$1
[ -f "$root/usr/include/cmocka.h" ] && exit 0
mkdir -p "$root/lists/partial" "$root/debs/partial"
cd "$root"
options="-oAPT::Architecture=arm64 -oAPT::Architectures=arm64 -oDir::State::Lists=$PWD/lists -oDebug::NoLocking=1"
apt-get $options update >apt.log 2>&1
(cd debs && apt-get $options -o APT::Sandbox::User=root download libcmocka0 libcmocka-dev >>../apt.log 2>&1)
for deb in debs/*.deb; do dpkg -x "$deb" .; done
