// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT
//
// Striped balls and small lamps over a checkered floor at dusk: colour as scene-linear light, depth as a reversed-Z
// buffer with its far plane at infinity.
#version 450

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba16f) uniform writeonly image2D color;
layout(binding = 1, r32f) uniform writeonly image2D depth;
layout(push_constant) uniform Constants {
    float half_width; // tangent of half the horizontal field of view
    float near_plane; // metres
    float time;       // 0 to 1: once around
};

const float FAR = 1e9;
const float TURN = 6.2831853;
const vec3 EYE = vec3(0.0, 0.42, 0.0); // looks along +z, and a little down
const int BALLS = 7, LAMPS = 14;
const vec3 SUN = vec3(-0.49, 0.62, -0.61); // towards it

// Centre and radius of a ball (i < BALLS) or a lamp.
vec4 sphere(int i) {
    if (i < BALLS) {
        float z = 2.1 * pow(1.36, float(i)), r = 0.03 * z + 0.06;
        float side = 0.15 * z * sin(2.4 * float(i) + 0.5);
        float hop = abs(sin(TURN * (time + 0.37 * float(i)))) * 0.3 * r;
        return vec4(side, r + hop, z, r);
    }
    float k = float(i - BALLS) / float(LAMPS), turn = TURN * (time + 3.0 * k);
    float z = 1.9 + 10.0 * k;
    return vec4(0.17 * z * sin(turn), 0.4 + 0.06 * z * cos(turn), z, 0.0025 * z + 0.006);
}

// The nearest hit of a ray beyond `from`: its distance, and which sphere; -1 is the floor.
float hit(vec3 origin, vec3 way, float from, int spheres, out int which) {
    float nearest = way.y < 0.0 ? -origin.y / way.y : FAR;
    which = -1;
    if (nearest < from) nearest = FAR;
    for (int i = 0; i < spheres; i++) {
        vec4 s = sphere(i);
        vec3 to = s.xyz - origin;
        float b = dot(to, way), d = b * b - dot(to, to) + s.w * s.w;
        if (d < 0.0) continue;
        float t = b - sqrt(d);
        if (t > from && t < nearest) {
            nearest = t;
            which = i;
        }
    }
    return nearest;
}

vec3 sky(vec3 way) {
    return mix(vec3(0.36, 0.17, 0.09), vec3(0.02, 0.05, 0.13), smoothstep(0.0, 0.13, way.y + 0.02));
}

vec3 hue(float at) { return 0.5 + 0.5 * cos(TURN * (at + vec3(0.0, 0.33, 0.67))); }

vec3 light(vec3 way) {
    int which, other;
    float t = hit(EYE, way, 0.0, BALLS + LAMPS, which);
    if (t >= FAR) return sky(way);
    if (which >= BALLS) return 12.0 * (0.02 + pow(hue(float(which) * 0.29), vec3(2.0)));
    vec3 at = EYE + t * way, normal = vec3(0.0, 1.0, 0.0), paint;
    if (which < 0) {
        vec2 tile = floor(at.xz / 0.25);
        float contrast = 0.42 * exp(-0.06 * at.z); // the far tiles are smaller than a pixel
        paint = vec3(0.45 + contrast * (mod(tile.x + tile.y, 2.0) * 2.0 - 1.0)) * vec3(1.0, 0.93, 0.85);
    } else {
        vec4 s = sphere(which);
        normal = (at - s.xyz) / s.w;
        float turned = atan(normal.z, normal.x) / TURN + time * (which % 2 == 0 ? 1.0 : -1.0);
        bool stripe = fract(8.0 * turned + 0.25 * sin(9.0 * normal.y)) < 0.5;
        paint = stripe ? vec3(0.9, 0.86, 0.8) : 0.08 + 0.75 * hue(0.13 * float(which));
    }
    bool shaded = hit(at, SUN, 1e-3, BALLS, other) < FAR;
    float sun = shaded ? 0.0 : max(dot(normal, SUN), 0.0);
    return paint * (sun * vec3(0.6, 0.42, 0.26) + (0.22 + 0.1 * normal.y) * vec3(0.35, 0.45, 0.75));
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(color);
    if (any(greaterThanEqual(at, size))) return;
    const vec3 right = vec3(1.0, 0.0, 0.0), forward = normalize(vec3(0.0, -0.045, 1.0)), up = cross(forward, right);
    vec3 sum = vec3(0.0), way;
    for (int i = 0; i < 5; i++) { // four samples for the colour; the last one, in the middle, for the depth
        vec2 offset = i < 4 ? vec2(i % 2, i / 2) * 0.5 + 0.25 : vec2(0.5);
        vec2 screen = ((vec2(at) + offset) * 2.0 - vec2(size)) / float(size.x) * half_width;
        way = normalize(forward + screen.x * right - screen.y * up);
        if (i < 4) sum += 0.25 * light(way);
    }
    int which;
    float t = hit(EYE, way, 0.0, BALLS + LAMPS, which);
    imageStore(color, at, vec4(sum, 1.0));
    imageStore(depth, at, vec4(t < FAR ? near_plane / (t * dot(way, forward)) : 0.0));
}
