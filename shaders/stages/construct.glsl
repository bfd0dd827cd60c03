// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// cr-vanilla, first pass: the coefficients of every pixel of the picture, to a surface of their own.
void main() {
    ivec2 at = target();
    store_row(fetch_row(at.x, at.y));
}
