// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// 1:4 to the picture (listing 8.2, corrected, without what it computes and does not use). Names say the distance to row
// i = 4k + 3, the known one of the group of four that this pixel belongs to.
void main() {
    ivec2 at = target();
    int k = at.x >> 2, place = at.x & 3, i = 4 * k + 3, line = at.y;
    vec4 y_4 = fetch_y(k - 1, line), y0 = fetch_y(k, line);

    // Phase 1: the row of half resolution between two known ones.
    float d_4 = coc_at(i - 4, line), d_3 = coc_at(i - 3, line), d_2 = coc_at(i - 2, line);
    float d_1 = coc_at(i - 1, line), d0 = coc_at(i, line);
    float b_4 = link(d_4, d_3), b_3 = link(d_3, d_2), b_2 = link(d_2, d_1), b_1 = link(d_1, d0);
    Row r_3 = picture_row(i - 3, line, b_4, b_3, d_3), r_2 = picture_row(i - 2, line, b_3, b_2, d_2);
    Row r_1 = picture_row(i - 1, line, b_2, b_1, d_1);

    // Phase 2: its unknown.
    vec4 y_2 = substitute(reduce(r_3, r_2, r_1), y_4, y0);

    // Phase 3: those beside it. Of the two only the one that is asked for.
    Row r = r_1;
    if (place == 0) r = r_3;
    vec4 y = substitute(r, place == 0 ? y_4 : y_2, place == 0 ? y_2 : y0);
    store_y(place == 3 ? y0 : place == 1 ? y_2 : y);
}
