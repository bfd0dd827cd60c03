// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// 4:1 from the picture (listing 8.1, corrected): row k is row 4k + 3 of the picture. Names say the distance to it: _ is minus.
void main() {
    ivec2 at = target();
    int i = 4 * at.x + 3, line = at.y;

    // Phase 1: gather.
    float d_4 = coc_at(i - 4, line), d_3 = coc_at(i - 3, line), d_2 = coc_at(i - 2, line);
    float d_1 = coc_at(i - 1, line), d0 = coc_at(i, line), d1 = coc_at(i + 1, line);
    float d2 = coc_at(i + 2, line), d3 = coc_at(i + 3, line), d4 = coc_at(i + 4, line);
    float b_4 = link(d_4, d_3), b_3 = link(d_3, d_2), b_2 = link(d_2, d_1), b_1 = link(d_1, d0);
    float b0 = link(d0, d1), b1 = link(d1, d2), b2 = link(d2, d3), b3 = link(d3, d4);
    Row r_3 = picture_row(i - 3, line, b_4, b_3, d_3), r_2 = picture_row(i - 2, line, b_3, b_2, d_2);
    Row r_1 = picture_row(i - 1, line, b_2, b_1, d_1), r0 = picture_row(i, line, b_1, b0, d0);
    Row r1 = picture_row(i + 1, line, b0, b1, d1), r2 = picture_row(i + 2, line, b1, b2, d2);
    Row r3 = picture_row(i + 3, line, b2, b3, d3);

    // Phase 2: the 2:1 reductions around the previous, the current and the next row of half resolution.
    Row p = reduce(r_3, r_2, r_1), c = reduce(r_1, r0, r1), n = reduce(r1, r2, r3);

    // Phase 3: one more.
    store_row(reduce(p, c, n));
}
