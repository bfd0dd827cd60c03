#!/bin/sh
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT

# Builds the command and applies the sample's own lens to the sample frame.
set -eu
cd "$(dirname "$0")/.."
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { [ -f build/build.ninja ] || meson setup build -Dtests=false; } >"$log" 2>&1 || ! ninja -C build >>"$log" 2>&1; then
    tail -n 40 "$log" >&2
    exit 1
fi
mkdir -p out
build/tools/ddof render samples/row/pinhole.exr -o out/row.exr --camera samples/row/scene.json --render dof_f2.exr \
    --kernel disc --layers auto --preview out/row.png
echo "picture:            out/row.exr"
echo "before and after:   out/row.png"
echo "Against the picture that a real lens took of the same scene (samples/row/dof_f2.exr):"
build/tools/ddof compare out/row.exr samples/row/dof_f2.exr
