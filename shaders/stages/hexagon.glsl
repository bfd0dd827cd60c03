// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Two passes: of the picture, its mean upwards and that with the one to the lower left; of these, the three rhombi.
uniform highp sampler2D color_map; // LAST: upwards
uniform highp sampler2D both_map;
uniform vec3 first_line, second_line;

layout(location = 0) out highp vec4 target;
#if !LAST
layout(location = 1) out highp vec4 both_target;
#endif

void main() {
    Line first = Line(first_line.x, int(first_line.y), first_line.z), second = Line(second_line.x, int(second_line.y), second_line.z);
#if LAST
    target = written((gather(color_map, first) + 2.0 * gather(both_map, second)) / 3.0);
#else
    vec4 up = gather(color_map, first);
    target = written(up);
    both_target = written(0.5 * (up + gather(color_map, second)));
#endif
}
