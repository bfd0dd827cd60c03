#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT
"""Disc diffusion with conductances that follow the diameter d (pixels).

usage: fit.py fit [NAME ...]     refit from constants disturbed by 10 % (fixed seed), print them and their tables
       fit.py table [NAME ...]   tables for the constants written below (MODELS)
       fit.py verify             direct simulation of them with complex line solves on a bounded grid

Kernel = Re sum_j w_j prod_lines (1 + b_line L)^-substeps, L = 2 - 2 cos on a line's own links, u = d*d,
    B_j = max(0, 1 - 1/u) * (beta_j u + c_j)      total conductance of component j (identity for d <= 1)
    t   = u / (u + q)                              diagonals fade out for small discs
    rows and columns: B_j (2 - t) / 2, each diagonal: B_j t / 4; both divided by the number of substeps
HV models have no diagonals: rows and columns carry B_j. Weights do not depend on d; sum Re w + gamma = 1.
Model draft_x adds gamma * Re(rows(b), then columns(conj b)): one more column sweep with the same factors.
"""
import sys
import numpy as np
from scipy.ndimage import map_coordinates
from scipy.optimize import least_squares

TABLE = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 96, 192)
FIT_D = (1.5, 2, 3, 4, 5, 6, 8, 10, 12, 14, 17, 24, 48)
FIT_D_PINHOLE = (1.5, 2, 3, 4, 6, 8, 10, 12, 14, 16, 18, 20, 24, 48, 96)

# name: directions, substeps, fit weights on (negative lobes, unsoftened core, unsoftened negative values, and, where given: the
# deepest unsoftened value, second moment for d <= 8, for larger d), parameters
# parameters: q, gamma, then per component beta (re, im), c (re, im), w (re, im); the last Re w is 1 - rest
MODELS = {
    "draft": ("hv", 1, (4, 0.4, 1), [0, 0, 0.0146618, -0.0348723, 0.0197902, -0.1624852, 1, 0.4648333]),
    "draft_x": ("hvx", 1, (3.5, 0.4, 1), [0, 0.6309468, 0.0081858, -0.0280502, -0.0313316, -0.1466969, 0.3690532, 0.7781211]),
    "hv2": ("hv", 1, (3, 0.3, 1), [0, 0, 0.0079961, 0.0081893, -0.0398271, 0.0538753, 1.742465, -3.05979, 0, -0.0079664, -0.085538, -0.0730103, -0.7424653, -0.6391547]),
    "good": ("hvdd", 1, (2.95, 0, 0, 0.7, 4, 1), [12, 0, 0.0099893, 0.0095402, -0.0970743, 0.077204, 1.570337, -1.825557, 0, -0.0106438, -0.15, -0.113635, -0.570337, -0.162695]),
    "good_nohole": ("hvdd", 1, (3.5, 0.3, 2), [6.5219, 0, 0.0112865, 0.0081638, -0.0752629, 0.0858985, 1.508501, -1.846305, 0, -0.0114327, -0.15, -0.16916, -0.5085015, 0.0148006]),
    "good_l2": ("hvdd", 1, (3.0, 0, 0), [6.6362, 0, 0.0097026, 0.0085109, -0.0736597, 0.0836522, 1.598982, -2.07739, 0, -0.0104698, -0.15, -0.1387213, -0.5989822, -0.1699166]),
    "good_strict": ("hvdd", 1, (3.5, 0.3, 2), [7.7629, 0, 0.0103111, 0.0081678, 0.0486139, 0.0853582, 1.604824, -1.812945, 0, -0.0116698, 0, -0.1603623, -0.604824, 0.0301714]),
    "best": ("hvdd", 2, (2.9, 0, 0, 1, 8, 2), [12, 0, 0.0136778, -0.0088572, -0.1010171, -0.0848784, 1.278649, 1.576326, 0, -0.0119912, -0.15, -0.1995637, -0.278649, 0.0207762]),
    "best_nohole": ("hvdd", 2, (3.5, 0.15, 2), [12, 0, 0.0149647, -0.0068326, -0.064065, -0.0818118, 1.232821, 1.859031, 0, -0.0130196, -0.15, -0.266684, -0.232821, 0.1087343]),
    "best_l2": ("hvdd", 2, (3.3, 0, 0), [12, 0, 0.0135893, -0.0066307, -0.0552749, -0.0761667, 1.283361, 2.109098, 0, -0.0122841, -0.15, -0.2371251, -0.2833607, 0.0572824]),
    "best_strict": ("hvdd", 2, (3.5, 0.15, 2), [12, 0, 0.0141161, -0.0068505, 0.0324562, -0.0805452, 1.273051, 1.946063, 0, -0.0125906, 0, -0.2535087, -0.273051, 0.0833772]),
}
# weight of each diameter in the fit (its L2 is divided by this): d < 8, < 12, < 20, < 40, rest
GOAL = {"hv": (.32, .32, .30, .30, .26), "hvx": (.32, .30, .28, .28, .24),
        "good": (.30, .25, .09, .10, .034), "best": (.30, .25, .14, .10, .026),
        "good_nohole": (.25, .20, .09, .10, .08), "best_nohole": (.25, .20, .12, .10, .05),
        "good_strict": (.25, .20, .09, .10, .08), "best_strict": (.25, .20, .12, .10, .05), "good_l2": (.30, .25, .10, .10, .06), "best_l2": (.30, .25, .13, .10, .04)}


class Grid:
    """One quadrant of space and frequency for diameter d, with the softened target (coverage 'area' or 'ramp')."""
    def __init__(self, d, kind="area", reach=2.5):
        self.d, h = d, int(max(reach * d, 20))
        r = np.arange(h + 1)
        mult, w = np.where(r == 0, 1.0, 2.0), 2 * np.pi * r / (2 * h + 1)
        self.to_space = np.cos(np.outer(r, w)) * mult / (2 * h + 1)
        wx, wy = np.meshgrid(w, w)
        lap = lambda a: 2 - 2 * np.cos(a)
        self.lx, self.ly, self.lp, self.lm = lap(wx), lap(wy), lap(wx + wy), lap(wx - wy)
        self.soft = np.exp(-(wx**2 + wy**2) * (0.045 * d) ** 2 / 2)
        x, y = np.meshgrid(r, r)
        if kind == "area":
            o = (np.arange(16) + 0.5) / 16 - 0.5
            t = sum(((x + a) ** 2 + (y + b) ** 2 <= d * d / 4).astype(float) for a in o for b in o)
        else:
            t = np.clip(d / 2 + 0.5 - np.hypot(x, y), 0, 1)
        self.mult = np.outer(mult, mult)
        self.raw = t / (t * self.mult).sum()
        f = np.cos(np.outer(w, r)) * mult
        self.core = np.hypot(x, y) < d / 2 - 1.5
        self.target = self.space(f @ self.raw @ f.T)
        self.norm = np.sqrt((self.target**2 * self.mult).sum())
        self.var = (self.raw * self.mult * x * x).sum()

    def space(self, spectrum, soft=True):
        return self.to_space @ (spectrum * (self.soft if soft else 1)) @ self.to_space.T


def unpack(p):
    c = np.reshape(p[2:], (-1, 6))
    w = c[:, 4] + 1j * c[:, 5]
    w[-1] += 1 - p[1] - w.real.sum()
    return p[0], p[1], c[:, 0] + 1j * c[:, 1], c[:, 2] + 1j * c[:, 3], w


def conductances(dirs, p, d):
    """Total conductance per component of (rows = columns, each diagonal)."""
    q, _, beta, c, _ = unpack(p)
    u = d * d
    total = max(0.0, 1 - 1 / max(u, 1e-12)) * (beta * u + c)
    t = u / (u + q)
    return (total * (2 - t) / 2, total * t / 4) if dirs == "hvdd" else (total, 0 * total)


def spectrum(g, dirs, n, p, gain=False):
    """Kernel spectrum, or with gain the largest modulus of a component over all frequencies."""
    gamma, w, out, top = unpack(p)[1], unpack(p)[4], 0, 0
    for b, e, wj in zip(*(x / n for x in conductances(dirs, p, g.d)), w):
        rows, cols = 1 / (1 + b * g.lx), 1 / (1 + b * g.ly)
        s = (rows * cols / ((1 + e * g.lp) * (1 + e * g.lm))) ** n
        out, top = out + (wj * s).real + gamma * (rows * cols.conj()).real, max(top, abs(s).max())
    return top if gain else out


def variance(dirs, p, d):
    """Exact second moment per axis, from the conductances."""
    (bh, bd), (_, gamma, _, _, w) = conductances(dirs, p, d), unpack(p)
    return 2 * (w * (bh + 2 * bd)).real.sum() + 2 * gamma * bh.real.sum()


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
    dirs, n, neg, start = MODELS[name]
    neg, hole, small, large = neg[:3], *(neg[3:] or (0, 0.3, 0.1))
    grids = [Grid(d) for d in (FIT_D_PINHOLE if hole else FIT_D)]
    goals, m = GOAL.get(name) or GOAL[dirs], len(start) // 6
    lo = np.array([0.0, -3] + [0, -.08, -.5, -2, -9, -9] * m)
    hi = np.array([12.0, 3] + [.08, .08, 2, 2, 9, 9] * m)
    if m == 2:                          # second component: purely imaginary growth, small constant real part
        hi[8], lo[10], hi[10] = 1e-9, *((0, 1e-9) if "strict" in name else (-.15, 0))
    free = [i for i in range(len(start)) if hi[i] - lo[i] > 1e-6 and i != len(start) - 2
            and (i != 0 or dirs == "hvdd") and (i != 1 or dirs == "hvx")]
    base = np.clip(np.array(start) * (1 + 0.1 * np.random.default_rng(1).normal(size=len(start))), lo, hi)

    def residual(v, p=base.copy()):
        p[free], out = v, []
        for g in grids:
            goal = goals[sum(g.d >= x for x in (8, 12, 20, 40))]
            k, raw = (g.space(spectrum(g, dirs, n, p), soft) for soft in (True, False))
            parts = k - g.target, neg[0] * np.minimum(k, 0), neg[1] * (raw - g.raw) * g.core, neg[2] * np.minimum(raw, 0)
            out += [np.ravel(np.array(parts) * np.sqrt(g.mult) / (g.norm * goal)), [
                    (small if g.d <= 8 else large) * (variance(dirs, p, g.d) / (g.d**2 / 16) - 1),
                    hole * min(0, raw.min() * g.d**2 * np.pi / 4) * (g.d > 3)]]
        return np.concatenate(out)

    v0 = np.clip(base[free], lo[free] + 1e-10, hi[free] - 1e-10)
    s = least_squares(residual, v0, bounds=(lo[free], hi[free]), x_scale="jac", max_nfev=200)
    base[free] = s.x
    return base


def show(name, p):
    dirs, n = MODELS[name][:2]
    q, gamma, beta, c, w = unpack(np.array(p, float))
    print(f"\n{name}: {dirs}, {n} substep(s), q {q:.6g}, gamma {gamma:.6g}, sum|w| {abs(w).sum() + abs(gamma):.2f}")
    for b, k, x in zip(beta, c, w):
        print(f"  beta {b.real:.8f}{b.imag:+.8f}i  c {k.real:.6f}{k.imag:+.6f}i  w {x.real:.6f}{x.imag:+.6f}i")
    print("| d | L2 area | L2 ramp | min/peak % | isotropy (of target) | m2/(d^2/16)-1 % | m2/m2(area disc)-1 % | max gain | unsoftened min, centre / plateau |\n" + "|---" * 9 + "|")
    for d in TABLE:
        g, r = Grid(d), Grid(d, "ramp")
        k, v = g.space(spectrum(g, dirs, n, p)), variance(dirs, p, d)
        raw = g.space(spectrum(g, dirs, n, p), False) * max(d * d * np.pi / 4, 1)
        err = [np.sqrt(((k - t.target) ** 2 * t.mult).sum()) / t.norm for t in (g, r)]
        print(f"| {d} | {err[0]:.3f} | {err[1]:.3f} | {100 * k.min() / k.max():+.2f} | {isotropy(k):.3f} ({isotropy(g.target):.3f}) | "
              f"{100 * (v / (d * d / 16) - 1):+.1f} | " + (f"{100 * (v / g.var - 1):+.1f}" if g.var else "-")
              + f" | {spectrum(g, dirs, n, p, gain=True):.2f} | {raw.min():+.2f}, {raw[0, 0]:+.2f} |", flush=True)


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
    for d in (3, 8, 12):
        size = 2 * int(5 * d + 10) + 1
        idx, mid = np.arange(size * size).reshape(size, size), size // 2
        diag = [np.diagonal(m, k) for m in (idx, idx[:, ::-1]) for k in range(1 - size, size)]
        (_, gamma, _, _, w), out = unpack(np.array(p, float)), 0
        for b, e, wj in zip(*(x / n for x in conductances(dirs, p, d)), w):
            a = np.zeros((size, size), complex)
            a[mid, mid] = 1
            for _ in range(n):
                rows = lines(a, b, idx)
                a = lines(rows.copy(), b, idx.T)
                a = lines(a, e, diag) if dirs == "hvdd" else a
            out = out + (wj * a).real + (gamma * lines(rows.conj(), b, idx.T).real if gamma else 0)
        g = Grid(d, reach=5)
        x, m, k = np.arange(size) - mid, len(g.mult), g.space(spectrum(g, dirs, n, p), False)
        print(f"{name} d {d}: max difference/peak {abs(out[mid:mid + m, mid:mid + m] - k).max() / out.max():.1e}  sum-1 {out.sum() - 1:+.1e}"
              f"  m2/formula-1 {(out.sum(0) * x * x).sum() / variance(dirs, p, d) - 1:+.1e}", flush=True)


if __name__ == "__main__":
    mode = sys.argv[1] if len(sys.argv) > 1 else "table"
    for nm in sys.argv[2:] or MODELS:
        verify(nm) if mode == "verify" else show(nm, fit(nm) if mode == "fit" else MODELS[nm][3])
