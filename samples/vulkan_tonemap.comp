// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT
//
// Scene-linear light to what a screen shows. The tone map comes after the blur: light adds up before it, not after.
#version 450

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 2, rgba16f) uniform readonly image2D blurred;
layout(binding = 3, rgba8) uniform writeonly image2D shown;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(shown)))) return;
    vec3 x = max(imageLoad(blurred, at).rgb, 0.0);
    x = clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0); // Narkowicz 2015, a fit to ACES
    x = mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, greaterThan(x, vec3(0.0031308))); // sRGB
    imageStore(shown, at, vec4(x, 1.0));
}
