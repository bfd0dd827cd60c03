// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// The one, two or three unknowns of a line.
void main() {
    ivec2 at = target();
    Row r = fetch_row(0, at.y);
    if (unknowns == 1)
        store_y(solve_one(r));
    else if (unknowns == 2)
        store_y(solve_two(r, fetch_row(1, at.y), at.x));
    else
        store_y(solve_three(r, fetch_row(1, at.y), fetch_row(2, at.y), at.x));
}
