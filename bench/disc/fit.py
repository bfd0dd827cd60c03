#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
"""Disc diffusion with conductances that follow the diameter d (pixels).

usage: fit.py fit [NAME ...]     refit from constants disturbed by 1 % (fixed seed), print them and their tables
       fit.py table [NAME ...]   tables for the constants written below (MODELS)
       fit.py verify [NAME ...]  direct simulation of them with complex line solves on a bounded grid

Kernel = Re sum_j w_j prod_lines (1 + b_line L)^-substeps, L = 2 - 2 cos on a line's own links, u = d*d, v = max(1, u),
    B_j = u (beta_j v + c_j)/(v + excess)       total conductance of component j; excess = sum Re(w c)/sum Re(w beta)
    t   = v / (v + q)                           diagonals fade out for small discs
    rows and columns: B_j (2 - t) / 2, each diagonal: B_j t / 4; both divided by the number of substeps
HV models have no diagonals: rows and columns carry B_j. Weights do not depend on d; sum Re w = 1.
The second moment per axis is 2 sum Re(w B) = 2 u sum Re(w beta), at every d; sum Re(w beta) = 1/32 makes it that of the disc,
d*d/16: the fit does not seek it, it computes Im w_1 from it.
"""
import sys
import numpy as np
from scipy.ndimage import map_coordinates
from scipy.optimize import least_squares

TABLE = (0.5, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 96, 192)
FIT_D = (1, 1.5, 2, 3, 4, 6, 8, 12, 16, 20, 24, 48)
GOAL_D = (2.5, 8, 12, 20, 40)

# name: directions, substeps, fit weights, parameters
# fit weights: what L2 is divided by for d < 2.5, < 8, < 12, < 20, < 40 and above; weight of lobes for d <= 8, above; weight of an
# unsoftened value deeper than so many plateaus (the dot), that depth; the least Re c
# parameters: q, then per component beta (re, im), c (re, im), w (re, im)
MODELS = {
    "draft": ("hv", 1, ((0.5, 0.32, 0.32, 0.3, 0.3, 0.26), (3, 3), 0, 0, -0.5), [0, 0.0146618, -0.0348723, 0.0197902, -0.1624852, 1, 0.4648333]),
    "good": ("hvdd", 1, ((0.45, 0.3, 0.25, 0.08, 0.1, 0.03), (5.5, 4.1), 1, 0.85, -0.15), [8.060688, 0.0098316, 0.0099269, -0.1043853, 0.0690196, 1.491419, -1.952798, 0, -0.0098219, -0.15, -0.107426, -0.491419, -0.2848962]),
    "best": ("hvdd", 2, ((0.5, 0.5, 0.15, 0.12, 0.1, 0.0195), (5, 3.15), 2.5, 0.52, -0.15), [12, 0.013551, -0.0101849, -0.1046951, -0.0798702, 1.266083, 1.407232, 0, -0.0115604, -0.1435999, -0.1966454, -0.266083, -0.0206861]),
    # for comparison: fitted with the gate B = max(0, 1 - 1/u) (beta u + c)
    "good_gate": ("hvdd", 1, ((0.3, 0.25, 0.25, 0.1, 0.1, 0.06), (3, 3), 0, 0, -0.15), [6.6362, 0.0097026, 0.0085109, -0.0736597, 0.0836522, 1.598982, -2.07739, 0, -0.0104698, -0.15, -0.1387213, -0.598982, -0.1699166]),
    "best_gate": ("hvdd", 2, ((0.3, 0.25, 0.25, 0.13, 0.1, 0.04), (3.3, 3.3), 0, 0, -0.15), [12, 0.0135893, -0.0066307, -0.0552749, -0.0761667, 1.283361, 2.109098, 0, -0.0122841, -0.15, -0.2371251, -0.283361, 0.0572824]),
}


class Grid:
    """One quadrant of space and frequency for diameter d, with the softened target (the area of each pixel the disc covers)."""
    def __init__(self, d, reach=2.5):
        self.d, h = d, int(max(reach * d, 20))
        r = np.arange(h + 1)
        mult, w = np.where(r == 0, 1.0, 2.0), 2 * np.pi * r / (2 * h + 1)
        self.to_space = np.cos(np.outer(r, w)) * mult / (2 * h + 1)
        wx, wy = np.meshgrid(w, w)
        lap = lambda a: 2 - 2 * np.cos(a)
        self.lx, self.ly, self.lp, self.lm = lap(wx), lap(wy), lap(wx + wy), lap(wx - wy)
        self.soft = np.exp(-(wx**2 + wy**2) * (0.045 * d) ** 2 / 2)
        x, y = np.meshgrid(r, r)
        o = (np.arange(16) + 0.5) / 16 - 0.5
        t = sum(((x + a) ** 2 + (y + b) ** 2 <= d * d / 4).astype(float) for a in o for b in o)
        self.mult = np.outer(mult, mult)
        self.raw = t / (t * self.mult).sum()
        f = np.cos(np.outer(w, r)) * mult
        self.target = self.space(f @ self.raw @ f.T)
        self.norm = np.sqrt((self.target**2 * self.mult).sum())

    def space(self, spectrum, soft=True):
        return self.to_space @ (spectrum * (self.soft if soft else 1)) @ self.to_space.T


def unpack(p):
    c = np.reshape(p[1:], (-1, 6))
    return p[0], c[:, 0] + 1j * c[:, 1], c[:, 2] + 1j * c[:, 3], c[:, 4] + 1j * c[:, 5]


def complete(p):
    """Re of the last weight from sum Re w = 1, Im of the first from sum Re(w beta) = 1/32."""
    p = p.copy()
    p[-2] = 1 - p[5:-6:6].sum()
    b, bi, w, wi = (p[i::6] for i in (1, 2, 5, 6))
    p[6] = ((w * b).sum() - (wi[1:] * bi[1:]).sum() - 1 / 32) / bi[0]
    return p


def conductances(dirs, p, d):
    """Total conductance per component of (rows = columns, each diagonal)."""
    q, beta, c, w = unpack(p)
    u, v = d * d, max(1.0, d * d)
    total = u * (beta * v + c) / (v + (w * c).real.sum() / (w * beta).real.sum())
    t = v / (v + q)
    return (total * (2 - t) / 2, total * t / 4) if dirs == "hvdd" else (total, 0 * total)


def spectrum(g, dirs, n, p, gain=False):
    """Kernel spectrum, or with gain the largest modulus of a component over all frequencies."""
    w, out, top = unpack(p)[3], 0, 0
    for b, e, wj in zip(*(x / n for x in conductances(dirs, p, g.d)), w):
        s = 1 / ((1 + b * g.lx) * (1 + b * g.ly) * (1 + e * g.lp) * (1 + e * g.lm)) ** n
        out, top = out + (wj * s).real, max(top, abs(s).max())
    return top if gain else out


def variance(dirs, p, d):
    """Exact second moment per axis, from the conductances."""
    (bh, bd), w = conductances(dirs, p, d), unpack(p)[3]
    return 2 * (w * (bh + 2 * bd)).real.sum()


def stability(dirs, n, p):
    """The least Re(1 + b L), any frequency, any d. A line whose links differ is solvable too: its matrix has a real part of at
    least this, since every link's own b is one of these."""
    return min((1 + 4 * np.minimum(x.real, 0) / n).min() for d in np.geomspace(0.05, 1e5, 4000) for x in conductances(dirs, p, d))


def isotropy(k):
    """min/max over angle of the outermost radius at half maximum (cubic interpolation)."""
    h = len(k) - 1
    i = np.abs(np.arange(-h, h + 1))
    f, r, rad = k[np.ix_(i, i)], np.linspace(0, h * 0.95, h * 40), []
    for a in np.linspace(0, np.pi / 4, 16):
        v = map_coordinates(f, [h + r * np.sin(a), h + r * np.cos(a)], order=3)
        m = np.nonzero(v >= f.max() / 2)[0][-1]
        rad.append(r[m] + (r[1] - r[0]) * (v[m] - f.max() / 2) / (v[m] - v[m + 1]))
    return min(rad) / max(rad)


def fit(name):
    dirs, n, (goals, lobe, dot, allowed, least), start = MODELS[name]
    grids, m = [Grid(d) for d in FIT_D], len(start) // 6
    lo = np.array([0.0] + [0, -.08, least, -2, -9, -9] * m)
    hi = np.array([12.0] + [.08, .08, 2, 2, 9, 9] * m)
    if m == 2:                          # second component: purely imaginary growth
        hi[7], hi[9] = 1e-9, 0
    free = [i for i in range(len(start)) if hi[i] - lo[i] > 1e-6 and i not in (6, len(start) - 2) and (i or dirs == "hvdd")]
    base = np.clip(np.array(start) * (1 + 0.01 * np.random.default_rng(1).normal(size=len(start))), lo, hi)

    def residual(v):
        p, out = base.copy(), []
        p[free] = v
        p = complete(p)
        for g in grids:
            k, raw = (g.space(spectrum(g, dirs, n, p), soft) for soft in (True, False))
            parts = np.array([k - g.target, lobe[g.d > 8] * np.minimum(k, 0)])
            out += [np.ravel(parts * np.sqrt(g.mult) / (g.norm * goals[sum(g.d >= x for x in GOAL_D)])),
                    [dot * min(0, raw.min() * g.d**2 * np.pi / 4 + allowed) * (g.d > 3)]]
        return np.concatenate(out)

    v0 = np.clip(base[free], lo[free] + 1e-10, hi[free] - 1e-10)
    base[free] = least_squares(residual, v0, bounds=(lo[free], hi[free]), x_scale="jac", max_nfev=100).x
    return complete(base).round(7)


def show(name, p):
    dirs, n = MODELS[name][:2]
    p = np.array(p, float)
    q, beta, c, w = unpack(p)
    print(f"\n{name}: {dirs}, {n} substep(s), q {q:.6g}, sum|w| {abs(w).sum():.2f}, "
          f"excess {(w * c).real.sum() / (w * beta).real.sum():.3f}, m2/(d^2/16)-1 {32 * (w * beta).real.sum() - 1:+.1e}, "
          f"min Re(1 + b L) {stability(dirs, n, p):.3f}")
    for b, k, x in zip(beta, c, w):
        print(f"  beta {b.real:.7f}{b.imag:+.7f}i  c {k.real:.7f}{k.imag:+.7f}i  w {x.real:.7f}{x.imag:+.7f}i")
    print("| d | L2 | min/peak % | isotropy (of target) | max gain | unsoftened min, centre / plateau |\n" + "|---" * 6 + "|")
    for d in TABLE:
        g = Grid(d)
        s = spectrum(g, dirs, n, p)
        k, raw = g.space(s), g.space(s, False) * max(d * d * np.pi / 4, 1)
        print(f"| {d} | {np.sqrt(((k - g.target) ** 2 * g.mult).sum()) / g.norm:.3f} | {100 * k.min() / k.max():+.2f} | {isotropy(k):.3f} "
              f"({isotropy(g.target):.3f}) | {spectrum(g, dirs, n, p, gain=True):.2f} | {raw.min():+.2f}, {raw[0, 0]:+.2f} |", flush=True)


def lines(a, b, systems):
    """Solve (I + b Laplacian) along each index list, insulating ends: complex Thomas."""
    f = a.astype(complex).ravel()
    for i in systems:
        c, y = np.zeros(len(i), complex), f[i]
        for k in range(len(i)):
            up, down = (b if k else 0), (b if k + 1 < len(i) else 0)
            den = 1 + up + down - up * (c[k - 1] if k else 0)
            c[k], y[k] = down / den, (y[k] + up * (y[k - 1] if k else 0)) / den
        for k in range(len(i) - 2, -1, -1):
            y[k] += c[k] * y[k + 1]
        f[i] = y
    return f.reshape(a.shape)


def verify(name):
    dirs, n, _, p = MODELS[name]
    p = np.array(p, float)
    for d in (0.7, 3, 8, 12):
        size = 2 * int(5 * d + 10) + 1
        idx, mid = np.arange(size * size).reshape(size, size), size // 2
        diag = [np.diagonal(m, k) for m in (idx, idx[:, ::-1]) for k in range(1 - size, size)]
        out = 0
        for b, e, wj in zip(*(x / n for x in conductances(dirs, p, d)), unpack(p)[3]):
            a = np.zeros((size, size), complex)
            a[mid, mid] = 1
            for _ in range(n):
                a = lines(lines(a, b, idx), b, idx.T)
                a = lines(a, e, diag) if dirs == "hvdd" else a
            out = out + (wj * a).real
        g = Grid(d, reach=5)
        x, m, k = np.arange(size) - mid, min(len(g.mult), size - mid), g.space(spectrum(g, dirs, n, p), False)
        print(f"{name} d {d}: max difference/peak {abs(out[mid:mid + m, mid:mid + m] - k[:m, :m]).max() / out.max():.1e}  sum-1 {out.sum() - 1:+.1e}"
              f"  m2/formula-1 {(out.sum(0) * x * x).sum() / variance(dirs, p, d) - 1:+.1e}", flush=True)


if __name__ == "__main__":
    mode = sys.argv[1] if len(sys.argv) > 1 else "table"
    for nm in sys.argv[2:] or MODELS:
        verify(nm) if mode == "verify" else show(nm, fit(nm) if mode == "fit" else MODELS[nm][3])
