// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// PCR: every row without the neighbours `stride` away. With TO_ROWS 0 it is the last step: no row has neighbours any more.
#ifndef VULKAN // there it lies in the push constants
uniform int stride;
#endif

void main() {
    ivec2 at = target();
    Row p, r, n;
#if ROWS == FROM_PICTURE
    fetch_three(at.x, at.y, p, r, n); // the first step, of stride 1
#else
    p = fetch_row(at.x - stride, at.y);
    r = fetch_row(at.x, at.y);
    n = fetch_row(at.x + stride, at.y);
#endif
    r = reduce(p, r, n);
#if TO_ROWS
    store_row(r);
#else
    store_y(solve_one(r));
#endif
}
