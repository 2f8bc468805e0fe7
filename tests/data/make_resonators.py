"""Chains with resonators integrated by DOP853 of SciPy: resonators.json.

Run with Python 3.11, NumPy 2 and SciPy 1.17: `python make_resonators.py > resonators.json`.
"""

import json

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from waveforms import burst

N = 12
HERTZ = lambda d: np.maximum(d, 0.0) ** 1.5
FPU = lambda d: d - 0.25 * d**2 + 0.5 * d**3


def run(law, c, end, speed=0.0, left=0.0, pressed=0.0, gravity=0.0, dashpot=0.0, drag=0.0, ground=0.0, m=0.0, k=0.0, b=0.0,
        force=None, wall=None, start=None, kinks=()):
    """The last state, the work of the drive, and what dampers took. `m`, `k`, `b`: masses, springs and dashpots of
    resonators, repeated along the chain; `start`: their displacements and velocities."""
    c, m, k, b = (np.resize(np.asarray(values, float), N) for values in (c, m, k, b))
    there = m > 0
    over = np.where(there, 1.0 / np.where(there, m, 1.0), 0.0)
    k, b = k * there, b * there
    rest = pressed + gravity * np.cumsum(1.0 + m)
    overlap = lambda force, c: brentq(lambda d: c * law(d) - force, 0.0, 10.0, xtol=1e-16) if force else 0.0
    at_rest = np.array([overlap(force, c) for force, c in zip(rest, c)])
    first_rest = overlap(pressed, left) if left else 0.0

    def rhs(t, state):
        x, v, y, w = state[: 4 * N].reshape(4, N)
        closing = v - np.append(v[1:], 0.0)
        f = c * law(at_rest + x - np.append(x[1:], 0.0)) - rest
        # Springs pull, too; Hertz contacts damp while they touch.
        touches = np.ones(N) if law is FPU else (at_rest + x - np.append(x[1:], 0.0) > 0)
        damping = dashpot * closing * touches
        xl, vl = (wall[0](t), wall[1](t)) if wall else (0.0, 0.0)
        first = left * law(first_rest + xl - x[0]) - pressed if left else 0.0
        first_damping = dashpot * (vl - v[0]) if left else 0.0
        pull = k * (y - x) + b * (w - v)
        push = np.append(first + first_damping, (f + damping)[:-1]) - f - damping - drag * v + pull
        push -= ground * (x + 0.2 * x**3)
        work = (first + first_damping) * vl
        if force:
            push[force[0]] += force[1](t)
            work += force[1](t) * v[force[0]]
        lost = np.sum(damping * closing) + first_damping * (vl - v[0]) + drag * np.sum(v**2) + np.sum(b * (w - v) ** 2)
        return np.concatenate([v, push, w, -over * pull, [work, lost]])

    state, t = np.zeros(4 * N + 2), 0.0
    state[N] = speed
    state[3 * N] = speed * there[0]
    if start:
        state[2 * N : 4 * N] = np.concatenate(start) * np.tile(there, 2)
    for stop in [*kinks, end]:
        inside = stop * (1 - 1e-15)
        state = solve_ivp(rhs, (t, inside), state, "DOP853", rtol=3e-14, atol=1e-16, max_step=0.02).y[:, -1]
        t = stop
    names = "displacement", "velocity", "resonator_displacement", "resonator_velocity"
    rows = state[: 4 * N].reshape(4, N)
    return {**dict(zip(names, rows.tolist())), "work": state[-2], "lost": state[-1]}


head = f"sites = {N}\nsamples = 21\ntolerance = 1e-11\n"
spring = 'law = "spring"\nalpha = 0.25\nbeta = 0.5\nends = "fixed"\n'
ramp = (0.1 * np.cos(np.arange(N))).tolist(), (0.2 * np.sin(np.arange(N))).tolist()
dimer = [1.0, 2.0]
tau = 2 * np.pi
cases = {
    "pressed dimer, one in two": (
        head + "stiffness_ratio = 2.0\nprecompression = 0.05\nend_time = 25.0\nstriker_velocity = 0.05\n"
        "resonator_mass = [0.5, 0.0]\nresonator_stiffness = 0.4\n",
        run(HERTZ, dimer, 25.0, speed=0.05, pressed=0.05, m=[0.5, 0.0], k=0.4),
    ),
    "springs with dashpots and ground": (
        head + spring + "end_time = 25.0\nstriker_velocity = 0.5\nground_cell = [0.3]\nground_law = \"d + 0.2*d^3\"\n"
        "resonator_mass = [0.3, 0.8, 0.0]\nresonator_frequency = [0.1, 0.2, 0.3]\nresonator_damping = 0.05\n",
        run(FPU, 1.0, 25.0, speed=0.5, left=1.0, ground=0.3, m=[0.3, 0.8, 0.0], b=0.05,
            k=[0.3 * (tau * 0.1) ** 2, 0.8 * (tau * 0.2) ** 2, 0.0]),
    ),
    "open chain with all losses": (
        head + "end_time = 20.0\nstriker_velocity = 1.0\ndrag = 0.03\n"
        "resonator_mass = 0.4\nresonator_stiffness = [0.5, 2.0]\nresonator_damping = [0.1, 0.0]\n",
        run(HERTZ, 1.0, 20.0, speed=1.0, drag=0.03, m=0.4, k=[0.5, 2.0], b=[0.1, 0.0]),
    ),
    "weight": (
        head + "end_time = 20.0\nstriker_velocity = 0.1\ngravity = 0.05\nprecompression = 0.02\n"
        "resonator_mass = [1.0, 0.2]\nresonator_stiffness = 0.6\n",
        run(HERTZ, 1.0, 20.0, speed=0.1, gravity=0.05, pressed=0.02, m=[1.0, 0.2], k=0.6),
    ),
    "sine of the wall": (
        head + spring + "end_time = 25.0\ndashpot = 0.05\ndrag = 0.02\n"
        'drive = "wall"\ndrive_amplitude = 0.3\ndrive_frequency = 0.15\n'
        "resonator_mass = 0.5\nresonator_frequency = 0.15\nresonator_damping = 0.02\n",
        run(FPU, 1.0, 25.0, left=1.0, dashpot=0.05, drag=0.02, m=0.5, k=0.5 * (tau * 0.15) ** 2, b=0.02,
            wall=(lambda t: 0.3 * np.sin(tau * 0.15 * t), lambda t: 0.3 * tau * 0.15 * np.cos(tau * 0.15 * t))),
    ),
    "push of a body": (
        head + spring + "end_time = 30.0\ndashpot = 0.05\ndrag = 0.02\n"
        'drive = "force"\ndrive_site = 5\ndrive_waveform = "tone-burst"\ndrive_amplitude = 0.3\ndrive_frequency = 0.15\n'
        "drive_cycles = 3.0\nresonator_mass = 0.5\nresonator_frequency = 0.15\nresonator_damping = 0.02\n",
        run(FPU, 1.0, 30.0, left=1.0, dashpot=0.05, drag=0.02, m=0.5, k=0.5 * (tau * 0.15) ** 2, b=0.02, kinks=[20.0],
            force=(5, burst(0.3, 0.15, 3.0))),
    ),
    "resonators that start apart": (
        head + spring + "end_time = 20.0\nresonator_mass = [0.6, 0.0, 0.2]\nresonator_stiffness = 1.5\n"
        f"resonator_displacements = {ramp[0]}\nresonator_velocities = {ramp[1]}\n",
        run(FPU, 1.0, 20.0, left=1.0, m=[0.6, 0.0, 0.2], k=1.5, start=ramp),
    ),
}
print(json.dumps({name: {"scene": scene, **found} for name, (scene, found) in cases.items()}, indent=1))
