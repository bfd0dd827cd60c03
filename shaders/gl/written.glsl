// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// As it is kept where half floats are written: within their range, and rounded by us (pack.glsl).
vec4 written(vec4 x) {
#if TO_HALF
    return nearest_half(clamp(x, -65504.0, 65504.0));
#else
    return x;
#endif
}
