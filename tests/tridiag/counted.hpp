/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

// A number that counts what is done with it.
#ifndef TESTS_TRIDIAG_COUNTED_HPP
#define TESTS_TRIDIAG_COUNTED_HPP

struct tally {
    unsigned long long adds, muls, divisions;
};
extern tally counted_tally;

struct counted {
    double v;
    counted() = default;
    counted(double value) : v(value) {}
    counted(int value) : v(value) {}
    explicit operator float() const { return static_cast<float>(v); }
    explicit counted(float value) : v(static_cast<double>(value)) {}
};

inline counted operator-(counted a) {
    return counted(-a.v);
}
inline counted operator+(counted a, counted b) {
    return counted_tally.adds++, counted(a.v + b.v);
}
inline counted operator-(counted a, counted b) {
    return counted_tally.adds++, counted(a.v - b.v);
}
inline counted operator*(counted a, counted b) {
    return counted_tally.muls++, counted(a.v * b.v);
}
inline counted operator/(counted a, counted b) {
    return counted_tally.divisions++, counted(a.v / b.v);
}
inline bool operator==(counted a, counted b) {
    return a.v == b.v;
}
inline bool operator!=(counted a, counted b) {
    return a.v != b.v;
}

#endif
