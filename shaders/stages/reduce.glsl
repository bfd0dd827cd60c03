// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// 2:1. Row k of the next level is row 2k + 1 of this one without its neighbours.
void main() {
    ivec2 at = target();
    Row p, r, n;
    fetch_three(2 * at.x + 1, at.y, p, r, n);
    store_row(reduce(p, r, n));
}
