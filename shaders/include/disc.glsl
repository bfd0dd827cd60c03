// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// What a link of the disc kernel conducts: the formulas of src/disc.h, for one component along one direction.

// For pixels whose |CoC| are d, e, as conductance() in coc.glsl has them.
vec2 disc_conductance(float d, float e) {
    float smaller = min(min(d, e), COC_LIMIT), u = smaller * smaller, v = max(u, 1.0);
    float part = (disc_level - disc_slope * v / (v + disc_fade)) * u / (v + disc_excess);
    return smaller < 0.0 ? vec2(0.0) : part * (disc_beta * v + disc_offset) + vec2(BETA_FLOOR, 0.0);
}
