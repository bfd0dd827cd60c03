// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// 1:2. Every second unknown of this level is known, on the next one: those with odd indices are copied.
void main() {
    ivec2 at = target();
    int i = at.x, k = i >> 1;
    vec4 y_n = fetch_y(k, at.y); // y[i + 1], or y[i] where i is odd
    if ((i & 1) == 0) y_n = substitute(fetch_row(i, at.y), fetch_y(k - 1, at.y), y_n);
    store_y(y_n);
}
