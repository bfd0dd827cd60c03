// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// A row and its colour in one rgba32ui texel (listing 8.3, with the mask its slides have). Two halves fill w. Without
// alpha the third lies in the six lowest mantissa bits of each coefficient, 6 + 6 + 4. With ALPHA the signs, which are known, and ten
// mantissa bits of each give 11 + 11 + 10 for the third and fourth. Coefficients are rounded, not cut: a cut would
// make all of them a little smaller.

const uint KEPT = ALPHA != 0 ? 0x7ffffc00u : 0xffffffc0u;
const uint STOLEN = ALPHA != 0 ? 0x3ffu : 0x3fu;
const uint HALF_STEP = ALPHA != 0 ? 0x200u : 0x20u;

// To the nearest half float, ties to even, for |x| <= 65504: GL leaves the rounding open, both of packHalf2x16() and of a half
// float target, and one that cuts makes every level darker.
vec4 nearest_half(vec4 x) {
    uvec4 bits = floatBitsToUint(x);
    return uintBitsToFloat((bits + 0xfffu + ((bits >> 13) & 1u)) & 0xffffe000u);
}

uvec4 pack(Row r) {
    r.x = nearest_half(r.x);
    uvec3 bits = (floatBitsToUint(vec3(r.a, r.g, r.c)) + HALF_STEP) & KEPT;
    if (ALPHA != 0) {
        uint rest = packHalf2x16(r.x.zw);
        uvec3 piece = uvec3(rest, rest >> 11, rest >> 22);
        bits |= (piece & STOLEN) | ((piece << 21) & 0x80000000u);
    } else {
        uint rest = packHalf2x16(vec2(r.x.z, 0.0)) & 0xffffu;
        bits |= uvec3(rest, rest >> 6, rest >> 12) & STOLEN;
    }
    return uvec4(bits, packHalf2x16(r.x.xy));
}

Row unpack(uvec4 d) {
    vec3 agc = uintBitsToFloat(d.xyz & KEPT);
    uvec3 piece = d.xyz & STOLEN;
    vec2 zw;
    if (ALPHA != 0) {
        agc.xz = -agc.xz;
        piece |= (d.xyz & 0x80000000u) >> 21;
        zw = unpackHalf2x16(piece.x | (piece.y << 11) | (piece.z << 22));
    } else {
        zw = vec2(unpackHalf2x16(piece.x | (piece.y << 6) | (piece.z << 12)).x, 1.0);
    }
    return Row(agc.x, agc.y, agc.z, vec4(unpackHalf2x16(d.w), zw));
}
