"""diffrax's Dopri8 on the dimer chain, compiled by XLA for one core: rows of time and error.

    python3 benches/peers/chain/diffrax_dopri8.py --reference FILE.npz --kappa 4.9272
"""

import os

import peer

peer.run_in("diffrax", ["numpy==2.4.6", "jax==0.7.2", "jaxlib==0.7.2", "diffrax==0.7.2"])
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false"
os.environ["JAX_PLATFORMS"] = "cpu"

import diffrax
import jax
import jax.numpy as jnp
import numpy

jax.config.update("jax_enable_x64", True)
problem = peer.Problem(peer.asked(__doc__))
coefficient = jnp.asarray(problem.coefficient)
times = jnp.asarray(problem.times)


def derivative(t, y, args):
    x, v = y
    overlap = jnp.maximum(x - jnp.append(x[1:], 0.0), 0.0)
    force = coefficient * overlap * jnp.sqrt(overlap)
    return v, jnp.append(0.0, force[:-1]) - force


@jax.jit
def velocities(tolerance):
    n = problem.n
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(derivative),
        diffrax.Dopri8(),
        t0=0.0,
        t1=times[-1],
        dt0=None,
        y0=(jnp.zeros(n), jnp.zeros(n).at[0].set(1.0)),
        saveat=diffrax.SaveAt(ts=times),
        stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
        max_steps=10_000_000,
        adjoint=diffrax.ForwardMode(),
    )
    return solution.ys[1]


for exponent in range(4, 14):
    tolerance = 10.0**-exponent
    solve = lambda: numpy.asarray(velocities(tolerance))
    problem.measure("diffrax", "Dopri8", f"tolerance {tolerance:.0e}", solve)
