#!/usr/bin/env python3
"""Writes quantiles.json: quantiles of the chi-square, Student's and Fisher's distributions, by SciPy 1.17 and mpmath.

SciPy's values are polished by Newton's method with mpmath at 40 digits, so that its own errors do not count.
"""

import itertools
import json
import pathlib

import mpmath
from scipy import stats

mpmath.mp.dps = 40


def polished(start, tail, wanted):
    return float(mpmath.findroot(lambda x: tail(x) - wanted, mpmath.mpf(start)))


def chi_square(share, degrees):
    if share <= 0.5:
        tail = lambda x: mpmath.gammainc(mpmath.mpf(degrees) / 2, 0, x / 2, regularized=True)
        return polished(stats.chi2.ppf(share, degrees), tail, mpmath.mpf(share))
    tail = lambda x: mpmath.gammainc(mpmath.mpf(degrees) / 2, x / 2, mpmath.inf, regularized=True)
    return polished(stats.chi2.ppf(share, degrees), tail, 1 - mpmath.mpf(share))


def student(alpha, degrees):
    nu = mpmath.mpf(degrees)
    tail = lambda t: mpmath.betainc(nu / 2, 0.5, 0, nu / (nu + t * t), regularized=True)
    return polished(stats.t.isf(alpha / 2, degrees), tail, mpmath.mpf(alpha))


def fisher(alpha, above, below):
    a, b = mpmath.mpf(above), mpmath.mpf(below)
    tail = lambda f: mpmath.betainc(b / 2, a / 2, 0, b / (b + a * f), regularized=True)
    return polished(stats.f.isf(alpha, above, below), tail, mpmath.mpf(alpha))


degrees = [1, 2, 3.7, 14, 57.3, 240, 1999.5, 20000]
found = {
    "chi_square": [[p, d, chi_square(p, d)] for p, d in itertools.product([0.005, 0.025, 0.5, 0.95, 0.975, 0.9999], degrees)],
    "student": [[a, d, student(a, d)] for a, d in itertools.product([0.2, 0.05, 0.01, 1e-6], degrees)],
    "fisher": [
        [a, d, e, fisher(a, d, e)]
        for a, (d, e) in itertools.product([0.05, 0.01, 1e-8], [(2, 12), (2, 4), (31.3, 188), (6, 36), (100, 600)])
    ],
}
path = pathlib.Path(__file__).with_name("quantiles.json")
path.write_text(json.dumps(found) + "\n")
