"""SciPy's DOP853 on the dimer chain, the forces by NumPy: rows of time and error.

    python3 benches/peers/chain/scipy_dop853.py --reference FILE.npz --kappa 4.9272
"""

import peer

peer.run_in("scipy", ["numpy==2.4.6", "scipy==1.17.1"])

import numpy
import scipy.integrate

problem = peer.Problem(peer.asked(__doc__))
n, coefficient = problem.n, problem.coefficient
overlap, force, out = numpy.empty(n), numpy.empty(n), numpy.empty(2 * n)


def derivative(t, y):
    numpy.subtract(y[: n - 1], y[1:n], out=overlap[:-1])
    overlap[-1] = y[n - 1]
    numpy.maximum(overlap, 0, out=overlap)
    numpy.sqrt(overlap, out=force)
    numpy.multiply(force, overlap, out=force)
    numpy.multiply(force, coefficient, out=force)
    out[:n] = y[n:]
    out[n] = -force[0]
    numpy.subtract(force[:-1], force[1:], out=out[n + 1 :])
    return out.copy()


start = numpy.zeros(2 * n)
start[n] = 1
for exponent in range(4, 14):
    tolerance = 10.0**-exponent

    def solve():
        end = problem.times[-1]
        solution = scipy.integrate.solve_ivp(
            derivative, (0, end), start, "DOP853", problem.times, rtol=tolerance, atol=tolerance
        )
        return solution.y[n:].T

    problem.measure("SciPy", "DOP853", f"tolerance {tolerance:.0e}", solve)
