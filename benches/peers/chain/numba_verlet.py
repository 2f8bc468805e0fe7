"""Velocity Verlet compiled by numba on the dimer chain: rows of time and error.

    python3 benches/peers/chain/numba_verlet.py --reference FILE.npz --kappa 4.9272
"""

import peer

peer.run_in("numba", ["numpy==2.4.6", "numba==0.66.0"])

import numba
import numpy

problem = peer.Problem(peer.asked(__doc__))


@numba.njit(fastmath=True, error_model="numpy")
def accelerate(x, coefficient, force, a):
    n = len(a)
    # x has a last place for the wall, force a first one that stays 0.
    for j in range(n):
        overlap = max(x[j] - x[j + 1], 0.0)
        force[j + 1] = coefficient[j] * overlap * numpy.sqrt(overlap)
    for j in range(n):
        a[j] = force[j] - force[j + 1]


@numba.njit(fastmath=True, error_model="numpy")
def verlet(times, steps, coefficient):
    n = len(coefficient)
    x, force = numpy.zeros(n + 1), numpy.zeros(n + 1)
    v, a = numpy.zeros(n), numpy.zeros(n)
    v[0] = 1.0
    kept = numpy.empty((len(times), n))
    kept[0] = v
    for sample in range(1, len(times)):
        h = (times[sample] - times[sample - 1]) / steps
        # The half kicks of neighbouring steps are one.
        for j in range(n):
            v[j] += 0.5 * h * a[j]
        for step in range(steps):
            for j in range(n):
                x[j] += h * v[j]
            accelerate(x, coefficient, force, a)
            kick = h if step + 1 < steps else 0.5 * h
            for j in range(n):
                v[j] += kick * a[j]
        kept[sample] = v
    return kept


for steps in [32, 128, 512, 2048, 8192, 32768]:
    solve = lambda: verlet(problem.times, steps, problem.coefficient)
    problem.measure("numba", "velocity Verlet", f"{steps} steps a sample", solve)
