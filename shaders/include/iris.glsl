// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// What a sprite looks like: the formulas of src/iris.h. Whoever includes this has defined, as constants or uniforms:
//     int iris_kind (0 disc, 1 polygon, 2 image), float iris_blades, iris_curvature, iris_edge, iris_squeeze, iris_aspect,
//     vec2 iris_turn (cosine and sine of the rotation), float iris_texel(int level, ivec2 at) with 0 <= at < 128 >> level.

float iris_cover(float inside) {
    return clamp(inside + 0.5, 0.0, 1.0);
}

float iris_texel_or_none(int level, ivec2 at) {
    int side = 128 >> level;
    return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(side))) ? iris_texel(level, at) : 0.0;
}

// p: from the middle, in radii, y upwards.
float iris_image(int level, vec2 p) {
    float side = float(128 >> level);
    vec2 t = vec2(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y) * side - 0.5, corner = floor(t), part = t - corner;
    ivec2 at = ivec2(corner);
    float above = mix(iris_texel_or_none(level, at), iris_texel_or_none(level, at + ivec2(1, 0)), part.x);
    float below = mix(iris_texel_or_none(level, at + ivec2(0, 1)), iris_texel_or_none(level, at + ivec2(1, 1)), part.x);
    return mix(above, below, part.y);
}

// The mask of a sprite of this diameter, in pixels of the target, at `offset` from its middle, y downwards; not divided by its sum.
// side: 1 behind the focus, -1 before it. cat: c t, 0 where there is no cat's eye. level: of the image's table.
float iris_mask(vec2 offset, float diameter, float side, vec2 cat, int level) {
    float radius = 0.5 * diameter;
    vec2 p0 = side * vec2(offset.x * iris_squeeze, -offset.y / iris_aspect);
    vec2 p = vec2(p0.x * iris_turn.x + p0.y * iris_turn.y, p0.y * iris_turn.x - p0.x * iris_turn.y);
    float inside = radius - length(p), cut = cat == vec2(0.0) ? 1e9 : radius - length(p0 + radius * cat);
    float cover;
    if (iris_kind == 2) {
        cover = iris_image(level, p / radius) * iris_cover(cut);
    } else {
        if (iris_kind == 1) { // the normal of the nearest side is at (k + 1/2) sector
            float sector = 6.28318530717958648 / iris_blades;
            float axis = p.x < 0.0 ? 3.14159265358979324 : 0.0; // atan() of -0 may be half a turn off, and elsewhere 1e-3:
            float normal = (floor((p.y == 0.0 ? axis : atan(p.y, p.x)) / sector) + 0.5) * sector;
            vec2 n = vec2(cos(normal), sin(normal)), turn = vec2(cos(sector), sin(sector)); // the sides beside it are asked, too
            float beyond = max(dot(p, n), max(dot(p, vec2(n.x * turn.x - n.y * turn.y, n.y * turn.x + n.x * turn.y)),
                                              dot(p, vec2(n.x * turn.x + n.y * turn.y, n.y * turn.x - n.x * turn.y))));
            inside = mix(radius * cos(0.5 * sector) - beyond, inside, iris_curvature);
        }
        cover = iris_cover(min(inside, cut));
    }
    float r = min(length(p) / radius, 1.0);
    return cover * (1.0 + side * iris_edge * (2.0 * r * r - 1.0));
}

const float IRIS_OCTAVE = 64.0;

// The node of a diameter from 1 to 4096, and back: sprites have diameters of nodes.
float iris_node(float diameter) {
    return clamp(floor(log2(diameter) * IRIS_OCTAVE + 0.5), 0.0, 13.0 * IRIS_OCTAVE);
}

float iris_diameter(float node) {
    return exp2(node / IRIS_OCTAVE);
}

int iris_level(float node, bool half_size) {
    float below = (half_size ? 8.0 : 7.0) * IRIS_OCTAVE - node;
    return clamp(int(floor(below / IRIS_OCTAVE)), 0, 4);
}
