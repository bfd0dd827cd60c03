# SPDX-FileCopyrightText: 2026 The ddof authors
# SPDX-License-Identifier: MIT

"""FLIP in float64, the slow way, against what `ddof compare` says: two-dimensional kernels, whole pictures, no code shared.

flip.py COMMAND  compares on made-up pictures; prints TAP
flip.py          prints the figures that tests/tools/flip.c has
"""
import json
import os
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    print("1..1\nok 1 - FLIP in float64 # SKIP no numpy for " + sys.executable)
    sys.exit(0)

# Linear Rec. 709 to XYZ, from the primaries' and the white point's chromaticities as fractions; white is its row sums.
TO_XYZ = np.array([[10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
                   [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
                   [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382]])
WHITE = TO_XYZ.sum(axis=1)
SENSITIVITY = [[(1, 0.0047)], [(1, 0.0053)], [(34.1, 0.04), (13.5, 0.025)]]


def opponent(rgb):
    x, y, z = np.moveaxis(rgb @ TO_XYZ.T / WHITE, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def from_opponent(c):
    y = (c[..., 0] + 16) / 116
    xyz = np.stack([y + c[..., 1] / 500, y, y - c[..., 2] / 200], axis=-1) * WHITE
    return np.clip(xyz @ np.linalg.inv(TO_XYZ).T, 0, 1)


def hunt_lab(rgb):
    t = rgb @ TO_XYZ.T / WHITE
    d = 6 / 29
    f = np.where(t > d**3, np.cbrt(t), t / (3 * d * d) + 4 / 29)
    lightness = 116 * f[..., 1] - 16
    return np.stack([lightness, lightness / 100 * 500 * (f[..., 0] - f[..., 1]),
                     lightness / 100 * 200 * (f[..., 1] - f[..., 2])], axis=-1)


def hyab(p, q):
    return abs(p[..., 0] - q[..., 0]) + np.sqrt(((p - q)[..., 1:] ** 2).sum(axis=-1))


def correlate(plane, kernel):
    r = kernel.shape[0] // 2
    wide = np.pad(plane, r, mode="edge")
    out = np.zeros_like(plane)
    for j in range(2 * r + 1):
        for i in range(2 * r + 1):
            out += kernel[j, i] * wide[j:j + plane.shape[0], i:i + plane.shape[1]]
    return out


def square(radius):
    return np.meshgrid(np.arange(-radius, radius + 1.0), np.arange(-radius, radius + 1.0))


def sensitivity_kernel(terms, ppd):
    x, y = square(int(np.ceil(3 * np.sqrt(0.04 / (2 * np.pi**2)) * ppd)))
    z = (x * x + y * y) / ppd**2
    k = sum(a * np.sqrt(np.pi / b) * np.exp(-np.pi**2 * z / b) for a, b in terms)
    return k / k.sum()


def feature_strength(luminance, ppd, point):
    sigma = 0.041 * ppd
    x, y = square(int(np.ceil(3 * sigma)))
    k = (x * x / sigma**2 - 1 if point else -x) * np.exp(-(x * x + y * y) / (2 * sigma**2))
    k = np.where(k > 0, k / k[k > 0].sum(), -k / k[k < 0].sum())
    return np.hypot(correlate(luminance, k), correlate(luminance, k.T))


def ldr_flip(a, b, ppd):
    seen, features = [], []
    for rgb in (a, b):
        c = opponent(rgb)
        blurred = [correlate(c[..., i], sensitivity_kernel(SENSITIVITY[i], ppd)) for i in range(3)]
        seen.append(hunt_lab(from_opponent(np.stack(blurred, axis=-1))))
        luminance = (c[..., 0] + 16) / 116
        features.append([feature_strength(luminance, ppd, point) for point in (False, True)])
    most = hyab(hunt_lab(np.array([0.0, 1, 0])), hunt_lab(np.array([0.0, 0, 1]))) ** 0.7
    d = hyab(*seen) ** 0.7
    color = np.where(d < 0.4 * most, 0.95 * d / (0.4 * most), 0.95 + 0.05 * (d - 0.4 * most) / (0.6 * most))
    feature = np.sqrt(np.maximum(abs(features[0][0] - features[1][0]), abs(features[0][1] - features[1][1])) / np.sqrt(2))
    return color ** (1 - feature)


def exposures(reference):
    # (k0 x^2 + k1 x)/(k3 x^2 + k4 x + k5) = 0.85
    t = 0.85
    x = max(np.roots([0.9036 - t * 0.8748, 0.018 - t * 0.354, -t * 0.14]).real)
    luminance = reference @ np.array([0.2126, 0.7152, 0.0722])
    start, stop = np.log2(x / luminance.max()), np.log2(x / np.median(luminance))
    return np.linspace(start, stop, max(2, int(np.ceil(stop - start))))


def hdr_flip(test, reference, ppd):
    def aces(rgb, stops):
        v = rgb * 2**stops
        return np.clip((0.9036 * v * v + 0.018 * v) / (0.8748 * v * v + 0.354 * v + 0.14), 0, 1)
    return np.max([ldr_flip(aces(test, e), aces(reference, e), ppd) for e in exposures(reference)], axis=0)


def compact(rgb):
    return rgb / (1 + rgb)


def formula_pictures():
    """The pictures of tests/tools/metrics.c and flip.c."""
    y, x, c = np.meshgrid(np.arange(48), np.arange(64), np.arange(3), indexing="ij")
    v = (x * (7 + c) + y * (5 + 2 * c) + c * 11) % 64 / 64
    light = np.where((x - 20) ** 2 + (y - 15) ** 2 < 36, 4, 0)
    b = v * 0.875 + (x * 3 + y * 13 + c) % 16 / 128 - 1 / 64 + light
    return (v + light).astype(np.float32), b.astype(np.float32)


def smooth_pictures(width, height, seed, peak):
    r = np.random.default_rng(seed)
    y, x = np.mgrid[0:height, 0:width] / 16
    a = np.stack([0.5 + 0.5 * np.sin(x * r.uniform(0.3, 3) + y * r.uniform(0.3, 3) + i) for i in range(3)], axis=-1)
    a = a ** 2 + peak * (r.uniform(size=(height, width, 1)) > 0.99)
    b = 0.9 * np.roll(a, 2, axis=1) + 0.02 * r.uniform(size=a.shape)
    return a.astype(np.float32), b.astype(np.float32)


def write_pfm(path, rgb):
    with open(path, "wb") as f:
        f.write(b"PF\n%d %d\n-1.0\n" % (rgb.shape[1], rgb.shape[0]))
        f.write(rgb[::-1].astype("<f4").tobytes())


def figures():
    a, b = (p.astype(np.float64).clip(0) for p in formula_pictures())
    for ppd in (67, 20):
        tone = ldr_flip(compact(a), compact(b), ppd)
        display = ldr_flip(a.clip(0, 1), b.clip(0, 1), ppd)
        hdr = hdr_flip(a, b, ppd)
        print("ppd %d: compact %.7f, at 20,15 %.7f, at 63,47 %.7f; display %.7f; hdr %.7f, at 20,15 %.7f" %
              (ppd, tone.mean(), tone[15, 20], tone[47, 63], display.mean(), hdr.mean(), hdr[15, 20]))
    e = exposures(b)
    print("exposures %.7f to %.7f, %d" % (e[0], e[-1], len(e)))


def compare(command):
    cases = [("formula",) + formula_pictures() + (67,), ("formula, 20 ppd",) + formula_pictures() + (20,),
             ("noise and highlights",) + smooth_pictures(90, 61, 1, 300) + (67,), ("one row",) + smooth_pictures(40, 1, 2, 0) + (67,),
             ("one column, 130 ppd",) + smooth_pictures(1, 33, 3, 5) + (130,), ("5 ppd",) + smooth_pictures(31, 40, 4, 9) + (5,)]
    failed = count = 0
    print("1..%d" % (2 * len(cases)))
    with tempfile.TemporaryDirectory() as folder:
        names = [os.path.join(folder, n) for n in ("a.pfm", "b.pfm")]
        for about, a, b, ppd in cases:
            write_pfm(names[0], a)
            write_pfm(names[1], b)
            out = subprocess.run([command, "compare", *names, "--json", "--ppd", str(ppd)], check=True, capture_output=True)
            said = json.loads(out.stdout)
            a, b = (p.astype(np.float64).clip(0) for p in (a, b))
            right = {"flip": ldr_flip(compact(a), compact(b), ppd).mean(), "flip_hdr": hdr_flip(a, b, ppd).mean()}
            for key, value in right.items():
                count += 1
                good = abs(said[key] - value) < 2e-5
                failed += not good
                print("%sok %d - %s: %s %.6f" % ("" if good else "not ", count, about, key, value))
                if not good:
                    print("#   the command says %.8f" % said[key])
    return failed


if __name__ == "__main__":
    sys.exit(compare(sys.argv[1]) > 0 if len(sys.argv) > 1 else figures())
