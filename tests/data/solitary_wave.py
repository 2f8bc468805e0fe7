"""The solitary wave of the homogeneous Hertz chain, from its travelling-wave equation.

x_j'' = F(x_{j-1} - x_j) - F(x_j - x_{j+1}), F(d) = max(d, 0)^{3/2}, has a wave whose overlaps are
x_j - x_{j+1} = psi(j - t), of speed 1, with

    psi'' = psi(xi - 1)^{3/2} - 2 psi^{3/2} + psi(xi + 1)^{3/2},

which is the convolution psi = tent * psi^{3/2} with max(1 - |xi|, 0) (J. M. English, R. L. Pego,
Proc. AMS 133 (2005) 1763); it falls off as exp(-a (3/2)^|xi|). Solved by Petviashvili's iteration
on Fourier modes of a period of 16, where it is below the rounding at the ends. A wave of speed c
has overlaps c^4 psi and velocities c^5 v, v(xi) = integral of psi^{3/2} over xi - 1 to xi.

The speed of the wave that an impact at speed 1 makes comes from the momentum of its first pulse in
double-double arithmetic (chain_reference.py).

Run: python solitary_wave.py > solitary_wave.json   (NumPy, g++)
"""

import datetime
import json
import sys

import numpy

from chain_reference import trajectory

PERIOD, POINTS, MODES = 16, 1024, 36


def main():
    step = PERIOD / POINTS
    # Starts at 0, where psi is largest.
    xi = numpy.fft.fftfreq(POINTS, 1 / PERIOD)
    k = 2 * numpy.pi * numpy.fft.rfftfreq(POINTS, step)
    tent = numpy.sinc(k / (2 * numpy.pi)) ** 2
    psi = numpy.where(abs(xi) < 2.5, numpy.cos(numpy.pi * xi / 5) ** 4, 0)
    for _ in range(150):
        force = numpy.fft.rfft(psi**1.5)
        new = numpy.maximum(numpy.fft.irfft(force * tent, POINTS), 0)
        new *= ((psi @ psi) / (psi @ new)) ** 3
        change, psi = abs(new - psi).max(), new
    assert change < 3e-15, change
    modes = numpy.fft.rfft(psi).real / POINTS
    modes[1:] *= 2

    # The equation itself, its second derivative taken of the modes.
    series = lambda a, x: numpy.cos(numpy.outer(x, k[:MODES])) @ a[:MODES]
    at = numpy.linspace(-3, 3, 61)
    force_at = lambda x: numpy.maximum(series(modes, x), 0) ** 1.5
    second = series(-modes[:MODES] * k[:MODES] ** 2, at)
    residual = abs(second - force_at(at - 1) + 2 * force_at(at) - force_at(at + 1)).max()

    # v(xi) = integral over xi - 1 to xi: its largest value is at xi = 1/2.
    force = numpy.fft.rfft(psi**1.5).real / POINTS
    force[1:] *= 2
    speed = (force[:MODES] * numpy.sinc(k[:MODES] / (2 * numpy.pi))).sum()
    momentum = modes[0] * PERIOD

    # At time 170 the pulse is at site 142, and nothing else has come as far as site 120.
    sites = 160
    rest = numpy.zeros(sites - 1)
    v, _ = trajectory(numpy.ones(sites), numpy.ones(sites), [1.0, *rest], [0.0, 170.0])
    assert abs(v[1, 120:130]).max() < 1e-20 and v[1].argmax() == 142
    record = {
        "made_by": f"solitary_wave.py, {datetime.date.today()}, NumPy {numpy.__version__}",
        "what": "psi(xi) = sum_m modes[m] cos(2 pi m xi / period) for |xi| < period / 2, speed 1",
        "residual": residual,
        "largest_overlap": psi[0],
        "largest_velocity": speed,
        "momentum": momentum,
        "speed_after_impact": (v[1, 120:].sum() / momentum) ** 0.2,
        "period": PERIOD,
        "modes": modes[:MODES].tolist(),
    }
    json.dump(record, sys.stdout, indent=1)
    print()


main()
