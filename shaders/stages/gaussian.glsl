// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Along rows, then along columns.
uniform highp sampler2D color_map;
uniform vec3 first_line;

layout(location = 0) out highp vec4 target;

void main() {
    target = written(gather(color_map, Line(first_line.x, int(first_line.y), first_line.z)));
}
