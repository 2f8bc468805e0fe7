"""Driven chains integrated by DOP853 of SciPy, and splines of degree five: drives.json.

Run with Python 3.12, NumPy 2 and SciPy 1.17: `python make_drives.py > drives.json`.
"""

import json

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import make_interp_spline

from waveforms import burst, burst_rate, chirp, half_sine, noise


def law(kind, c, d, p):
    if kind == "hertz":
        d0 = (p / c) ** (2 / 3)
        return c * np.maximum(d + d0, 0.0) ** 1.5 - p
    alpha, beta = kind
    return c * (d - alpha * d**2 + beta * d**3)


def run(kind, c, left, end, force=None, wall=None, body=None, pressed=0.0, dashpot=0.0, drag=0.0, kinks=()):
    """Final velocities and the work of the drive. `c`: contacts, the last one with the wall behind. `force`: a
    site and its force; `wall`: displacement and velocity of the wall before site 0; `body`: a site, its displacement,
    velocity and acceleration."""
    c = np.asarray(c)
    n = len(c)

    def rhs(t, y):
        x, v = y[:n], y[n : 2 * n]
        xr, vr = np.append(x[1:], 0.0), np.append(v[1:], 0.0)
        f = law(kind, c, x - xr, pressed) + dashpot * (v - vr)
        xl, vl = (wall[0](t), wall[1](t)) if wall else (0.0, 0.0)
        first = law(kind, left, xl - x[0], pressed) + dashpot * (vl - v[0]) if left else 0.0
        push = np.append(first, f[:-1]) - f - drag * v
        work = first * vl
        if body:
            site, _, speed, rate = body
            work += (rate(t) - push[site]) * speed(t)
            push[site] = rate(t)
        if force:
            site, of = force
            push[site] += of(t)
            work += of(t) * v[site]
        return np.concatenate([v, push, [work]])

    y, t = np.zeros(2 * n + 1), 0.0
    if body:
        y[body[0]], y[n + body[0]] = body[1](0.0), body[2](0.0)
    for stop in [*sorted(k for k in kinks if 0 < k < end), end]:
        step = 1e-9 * stop
        y = solve_ivp(rhs, (t, stop - step * 1e-6), y, method="DOP853", rtol=3e-14, atol=1e-16, max_step=0.05).y[:, -1]
        t = stop
    return {"velocity": y[n : 2 * n].tolist(), "work": y[-1]}


def held(of, span):
    return lambda t: of(np.clip(t, *span))


def within(of, span):
    return lambda t: of(t) if span[0] <= t <= span[1] else 0.0


times = np.array([1.3, 1.7, 2.4, 2.9, 3.3, 4.1, 4.8, 5.2, 6.0, 6.6, 7.1, 8.0, 8.4, 9.3, 10.0])
values = 0.2 * np.sin(0.9 * times) * np.exp(-0.1 * times) + 0.05
spline = make_interp_spline(times, values, k=5)
span = (times[0], times[-1])
anti = spline.antiderivative()
table = f"drive_times = {times.tolist()}\ndrive_values = {values.tolist()}\n"
dimer = [1.0, 2.0] * 6
n_1 = [1.0] * 12
fpu = (0.25, 0.5)
head = "sites = 12\nsamples = 41\ntolerance = 1e-11\n"
spring = 'law = "spring"\nalpha = 0.25\nbeta = 0.5\n'
fixed = 'ends = "fixed"\n'
sweep = chirp(0.3, 0.05, 0.25, 20.0)
tone = burst(0.2, 0.15, 3.0)
grid = np.linspace(0, 20, 4001)
swept = make_interp_spline(grid, [sweep(t) for t in grid], k=9).antiderivative()
slow = 2 * np.pi * 0.11
swing = [lambda t: 0.3 * np.sin(slow * t), lambda t: 0.3 * slow * np.cos(slow * t), lambda t: -0.3 * slow**2 * np.sin(slow * t)]
arch = [
    lambda t: 0.25 * 4 / np.pi * (1 - np.cos(np.pi * min(t, 4.0) / 4)),
    half_sine(0.25, 4.0),
    lambda t: 0.25 * np.pi / 4 * np.cos(np.pi * t / 4) if t <= 4 else 0.0,
]
bump = (0, lambda t: 0.0, burst(0.02, 0.15, 3.0), burst_rate(0.02, 0.15, 3.0))
tone_integral = lambda t: quad(tone, 0, min(t, 20.0), epsabs=1e-15, epsrel=1e-14, limit=200)[0]
tone_table = make_interp_spline(grid, [tone(t) for t in grid], k=9).antiderivative()

cases = {
    "burst at the end": (
        head + "stiffness_ratio = 2.0\nprecompression = 0.05\nend_time = 30.0\n"
        'drive = "force"\ndrive_waveform = "tone-burst"\ndrive_amplitude = 0.02\ndrive_frequency = 0.15\ndrive_cycles = 3.0\n',
        run("hertz", dimer, 0.0, 30.0, force=(0, burst(0.02, 0.15, 3.0)), pressed=0.05, kinks=[20.0]),
    ),
    "chirp inside": (
        head + spring + fixed + "end_time = 30.0\n"
        'drive = "force"\ndrive_site = 5\ndrive_waveform = "chirp"\ndrive_amplitude = 0.3\ndrive_frequency = 0.05\n'
        "drive_end_frequency = 0.25\ndrive_duration = 20.0\n",
        run(fpu, n_1, 1.0, 30.0, force=(5, sweep), kinks=[20.0]),
    ),
    "noise with losses": (
        head + spring + "dashpot = 0.05\ndrag = 0.02\nend_time = 25.0\n"
        'drive = "force"\ndrive_site = 3\ndrive_waveform = "noise"\ndrive_amplitude = 0.1\ndrive_band = [0.02, 0.3]\ndrive_seed = 7\n',
        run(fpu, n_1, 0.0, 25.0, force=(3, noise(0.1, 0.02, 0.3, 7)), dashpot=0.05, drag=0.02),
    ),
    "push in an open chain": (
        head + "stiffness_ratio = 2.0\nend_time = 25.0\n"
        'drive = "force"\ndrive_site = 6\ndrive_waveform = "half-sine"\ndrive_amplitude = 0.5\ndrive_duration = 3.0\n',
        run("hertz", dimer, 0.0, 25.0, force=(6, half_sine(0.5, 3.0)), kinks=[3.0]),
    ),
    "values push the last body": (
        head + fixed + spring + "end_time = 16.0\n" + 'drive = "force"\ndrive_site = 11\n' + table,
        run(fpu, n_1, 1.0, 16.0, force=(11, within(spline, span)), kinks=span),
    ),
    "values move the wall": (
        head + fixed + spring + "end_time = 16.0\n" + 'drive = "wall"\n' + table,
        run(fpu, n_1, 1.0, 16.0, wall=(held(spline, span), within(spline.derivative(), span)), kinks=span),
    ),
    "values are the wall's velocity": (
        head + fixed + spring + "end_time = 16.0\n" + 'drive = "wall-velocity"\n' + table,
        run(fpu, n_1, 1.0, 16.0, wall=(held(lambda t: anti(t) - anti(span[0]), span), within(spline, span)), kinks=span),
    ),
    "chirp of the wall's velocity": (
        head + fixed + spring + "end_time = 30.0\n"
        'drive = "wall-velocity"\ndrive_waveform = "chirp"\ndrive_amplitude = 0.3\ndrive_frequency = 0.05\n'
        "drive_end_frequency = 0.25\ndrive_duration = 20.0\n",
        run(fpu, n_1, 1.0, 30.0, wall=(held(swept, (0.0, 20.0)), sweep), kinks=[20.0]),
    ),
    "burst of the wall's velocity": (
        head + fixed + spring + "end_time = 30.0\n"
        'drive = "wall-velocity"\ndrive_waveform = "tone-burst"\ndrive_amplitude = 0.2\ndrive_frequency = 0.15\ndrive_cycles = 3.0\n',
        run(fpu, n_1, 1.0, 30.0, wall=(held(tone_table, (0.0, 20.0)), tone), kinks=[20.0]),
    ),
    "a body swings in a fixed chain": (
        head + fixed + spring + "end_time = 20.0\n"
        'drive = "displacement"\ndrive_site = 4\ndrive_amplitude = 0.3\ndrive_frequency = 0.11\n',
        run(fpu, n_1, 1.0, 20.0, body=(4, *swing)),
    ),
    "velocity of a body in an open chain": (
        head + "stiffness_ratio = 2.0\nend_time = 25.0\n"
        'drive = "velocity"\ndrive_site = 6\ndrive_waveform = "half-sine"\ndrive_amplitude = 0.25\ndrive_duration = 4.0\n',
        run("hertz", dimer, 0.0, 25.0, body=(6, *arch), kinks=[4.0]),
    ),
    "burst of the first body's velocity with losses": (
        head + "stiffness_ratio = 2.0\nprecompression = 0.05\ndashpot = 0.05\ndrag = 0.02\nend_time = 30.0\n"
        'drive = "velocity"\ndrive_waveform = "tone-burst"\ndrive_amplitude = 0.02\ndrive_frequency = 0.15\ndrive_cycles = 3.0\n',
        run("hertz", dimer, 0.0, 30.0, body=bump, pressed=0.05, dashpot=0.05, drag=0.02, kinks=[20.0]),
    ),
}
assert abs(tone_integral(11.3) - tone_table(11.3)) < 1e-13
at = np.linspace(1.3, 10.0, 37)
print(
    json.dumps(
        {
            "times": times.tolist(),
            "values": values.tolist(),
            "at": at.tolist(),
            "spline": [spline(at).tolist(), spline.derivative(1)(at).tolist(), spline.derivative(2)(at).tolist()],
            "cases": {name: {"scene": scene, **found} for name, (scene, found) in cases.items()},
        },
        indent=1,
    )
)
