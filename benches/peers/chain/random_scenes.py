"""Random chains over all laws, ends, losses, ground, weight, resonators and drives: the error that a run states against SciPy's DOP853.

    python3 benches/peers/chain/random_scenes.py PROGRAM [FIRST_SEED [NUMBER]]

Needs numpy and scipy. Prints each run whose error is larger than stated, and the largest ratios. DOP853 makes
short steps, since it knows no kinks of forces; where it departs by more than is stated, it runs again with shorter
ones. Errors below 2e-11 are its own.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

sys.path.insert(0, str(pathlib.Path(__file__).parents[3] / "tests" / "data"))
import waveforms

#: What DOP853 is off by itself.
OWN = 2e-11

#: Its longest steps. At single lengths it is off by 2e-10 where a contact opens, and by 2e-12 at the next.
STEPS = (0.01, 0.001, 0.0003)


def law(rng):
    """A law as text and as a function, and whether it only presses."""
    kind = rng.integers(9)
    a, b, p = rng.uniform(-0.4, 0.4), rng.uniform(0, 0.5), rng.uniform(1.0, 3.0)
    s = 0.3 + b
    return [
        ("hertz", lambda d: max(d, 0.0) ** 1.5, True),
        (f"power {p}", lambda d: max(d, 0.0) ** p, True),
        (f"spring alpha={a} beta={b}", lambda d: d - a * d**2 + b * d**3, False),
        (f"toda {s}", lambda d: np.expm1(s * d) / s, False),
        (f"morse {s}", lambda d: np.exp(s * d) * np.expm1(s * d) / s, False),
        (f"polynomial 1 {a} {b} 0.02 0.03", lambda d: d + a * d**2 + b * d**3 + 0.02 * d**4 + 0.03 * d**5, False),
        (f"k*d + a*sinh(d)^3; k=1, a={b}", lambda d: d + b * np.sinh(d) ** 3, False),
        (f"one-sided polynomial 1 {abs(a)}", lambda d: d + abs(a) * d**2 if d > 0 else 0.0, True),
        (f"two-sided power {p}", lambda d: np.sign(d) * abs(d) ** p, False),
    ][kind]


def static(f, coefficient, force):
    """The overlap at which a contact carries a force."""
    if force == 0:
        return 0.0
    high = 1e-6
    while coefficient * f(high) < force:
        high *= 1.5
    return brentq(lambda d: coefficient * f(d) - force, 0, high, xtol=1e-16)


def drive(rng, ends, n):
    """The keys of a drive, its function of time, when it has kinks, and what it drives."""
    bodies = ["force", "displacement", "velocity"]
    kind = str(rng.choice(bodies + ["wall", "wall-velocity"] if ends == "fixed" else bodies))
    a, f, f1, cycles = rng.uniform(0.05, 0.3), rng.uniform(0.05, 0.2), rng.uniform(0.1, 0.4), float(rng.integers(1, 5))
    length, seed, site = rng.uniform(2, 8), int(rng.integers(1000)), int(rng.integers(n))
    rate = lambda t: 2 * np.pi * f * a * np.cos(2 * np.pi * f * t)
    # The displacement of a wall neither jumps nor is held apart from 0; the velocity of a body does not jump.
    which = {"wall": [0, 1, 2], "displacement": [0, 2], "velocity": [0, 1, 2, 4]}.get(kind, range(5))
    name, keys, of, kinks = [
        ("sine", {"frequency": f}, lambda t: a * np.sin(2 * np.pi * f * t), []),
        ("half-sine", {"duration": length}, waveforms.half_sine(a, length), [length]),
        ("tone-burst", {"frequency": f, "cycles": cycles}, waveforms.burst(a, f, cycles), [cycles / f]),
        ("chirp", {"frequency": f, "end_frequency": f1, "duration": length}, waveforms.chirp(a, f, f1, length), [length]),
        ("noise", {"band": [f, f + f1], "seed": seed}, waveforms.noise(a, f, f + f1, seed), []),
    ][rng.choice(which)]
    keys = {"drive_waveform": name, "drive_amplitude": a, **{f"drive_{key}": value for key, value in keys.items()}}
    if kind in bodies:
        keys["drive_site"] = site
    if kind == "displacement" and name == "tone-burst":
        rate = waveforms.burst_rate(a, f, cycles)
    return {"drive": kind, **keys}, [of, rate], kinks, kind, site


def scene(seed):
    """A scene as lines, and its right-hand side."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 13))
    cell = [law(rng) for _ in range(rng.integers(1, 4))]
    ends = str(rng.choice(["free", "wall", "fixed"]))
    m = n - 1 if ends == "free" else n
    c, mass = rng.uniform(0.5, 4, m), rng.uniform(0.5, 2, n)
    pressed = 0.0 if rng.random() < 0.6 else rng.uniform(0.01, 0.1)
    speed, end = rng.uniform(0.1, 1), rng.uniform(5, 25)
    tolerance = float(rng.choice([1e-6, 1e-9]))
    ground = None if rng.random() < 0.5 else np.resize(rng.uniform(0, 1, 2), n)
    weight = 0.0 if ends == "free" or rng.random() < 0.6 else rng.uniform(0.005, 0.05)
    drag = 0.0 if rng.random() < 0.7 else 0.05
    dashpot = 0.0 if rng.random() < 0.7 else 0.1
    left = rng.uniform(0.5, 4)
    own = rng.uniform(0.1, 1, 3) * (rng.random(3) < 0.7) * (rng.random() < 0.6)
    spring, damper = rng.uniform(0.2, 3, 2), rng.uniform(0, 0.2, 1) * (rng.random() < 0.5)
    driven, of, kinks, kind, site = drive(rng, ends, n) if rng.random() < 0.5 else ({}, [None] * 2, [], "", 0)
    of, rate = of
    is_moved = kind in ("displacement", "velocity")
    told = {"velocity": of, "displacement": rate}.get(kind)
    if is_moved and site == 0:
        speed = told(0.0)
    if kind == "wall":
        dashpot = 0.0
    lines = {
        "sites": n,
        "ends": ends,
        "laws": [text for text, _, _ in cell],
        "coefficients": c.tolist(),
        "masses": mass.tolist(),
        "striker_velocity": speed,
        "end_time": end,
        "samples": 41,
        "tolerance": tolerance,
        "precompression": pressed,
        "gravity": weight,
        "drag": drag,
        "dashpot": dashpot,
        **driven,
    }
    if own.any():
        lines["resonator_mass"] = own.tolist()
        lines["resonator_stiffness"] = spring.tolist()
        lines["resonator_damping"] = damper.tolist()
    m_r, k_r, c_r = (np.resize(values, n) * (np.resize(own, n) > 0) for values in (own, spring, damper))
    free = np.where(m_r > 0, 1 / np.where(m_r > 0, m_r, 1.0), 0.0)
    if ends == "fixed":
        lines["left_wall_coefficient"] = left
    if ground is not None:
        lines["ground_cell"] = ground[:2].tolist()
        lines["ground_law"] = "d + 0.2*d^3"
    force = [cell[j % len(cell)][1] for j in range(m)]
    opens = [cell[j % len(cell)][2] for j in range(m)]
    rest = pressed + weight * np.cumsum(mass + m_r)[:m]
    at_rest = np.array([static(force[j], c[j], rest[j]) for j in range(m)])
    wall = static(cell[-1][1], left, pressed)

    def rates(t, state):
        x, v, y, w = state[: 4 * n].reshape(4, n)
        # The last value is the displacement of a wall or a body of a given velocity.
        moved = {"wall": lambda: (of(t), 0.0), "wall-velocity": lambda: (state[-1], of(t))}
        at, speed = moved.get(kind, lambda: (0.0, 0.0))()
        grows = speed
        if is_moved:
            x, v, grows = x.copy(), v.copy(), told(t)
            x[site], v[site] = state[-1] if kind == "velocity" else of(t), grows
        overlap = at_rest + x[:m] - np.append(x[1:], 0.0)[:m]
        closing = v[:m] - np.append(v[1:], 0.0)[:m]
        push = np.array([c[j] * force[j](overlap[j]) for j in range(m)]) - rest
        push += np.array([dashpot * closing[j] * (overlap[j] > 0 or not opens[j]) for j in range(m)])
        tied = k_r * (y - x) + c_r * (w - v)
        pull = tied - drag * v
        pull[:m] -= push
        pull[1:] += push[: n - 1]
        if ends == "fixed":
            first = wall + at - x[0]
            pull[0] += left * cell[-1][1](first) - pressed
            pull[0] += dashpot * (speed - v[0]) * (first > 0 or not cell[-1][2])
        if ground is not None:
            pull -= ground * (x + 0.2 * x**3)
        if kind == "force":
            pull[site] += of(t)
        if is_moved:
            # Its velocity is compared with that of the drive elsewhere.
            pull[site] = 0.0
        return np.concatenate([v, pull / mass, w, -tied * free, [grows]])

    start = np.zeros(4 * n + 1)
    start[n] = speed
    start[3 * n] = speed * (m_r[0] > 0)
    if is_moved:
        start[3 * n + site] = told(0.0) * (m_r[site] > 0)
    text = "".join(f"{key} = {json.dumps(value)}\n" for key, value in lines.items())
    others = [j for j in range(n) if not (is_moved and j == site)]
    return text, others, rates, start, [*(k for k in kinks if k < end), end]


def off(others, rates, start, stops, time, velocities, longest):
    """The largest difference of a velocity, of these bodies or of a resonator."""
    n, t, worst = len(start) // 4, 0.0, 0.0
    for stop in stops:
        inside = (time >= t) & (time <= stop)
        # Sides of a kink are apart.
        last = stop * (1 - 1e-15)
        at = np.unique(np.append(np.minimum(time[inside], last), last))
        found = solve_ivp(rates, (t, last), start, "DOP853", at, rtol=3e-14, atol=1e-16, max_step=longest)
        for velocity, row in zip(velocities, (found.y[n : 2 * n], found.y[3 * n : 4 * n])):
            samples = velocity[inside]
            apart = np.abs(row[:, : len(samples)].T - samples)
            which = others if velocity is velocities[0] else slice(None)
            worst = max(worst, apart[:, which].max(initial=0.0))
        start, t = found.y[:, -1], stop
    return worst


def departure(known, stated, scale):
    """The error of a run, by the reference of longest steps that does not exceed what is stated; of the shortest otherwise."""
    for longest in STEPS:
        error = off(*known, longest) / scale
        if error <= max(stated, OWN):
            break
    return error


def main():
    program = sys.argv[1]
    first, number = map(int, (sys.argv[2:] + ["0", "300"][len(sys.argv) - 2 :])[:2])
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        path, run = pathlib.Path(folder, "scene.toml"), pathlib.Path(folder, "run.npz")
        for seed in range(first, first + number):
            text, *known = scene(seed)
            path.write_text(text)
            said = subprocess.run(
                [program, "simulate", path, "--out", run, "--force", "--json"], capture_output=True, text=True
            )
            if said.returncode:
                print(f"seed {seed}: {said.stderr.strip()}")
                continue
            report = json.loads(said.stdout)["report"]
            stated, scale = report["error"], report["velocity_scale"]
            with np.load(run) as arrays:
                names = [name for name in ("velocity", "resonator_velocity") if name in arrays]
                known += [arrays["time"], [arrays[name] for name in names]]
            error = departure(known, stated, scale)
            if error > max(stated, OWN):
                print(f"seed {seed}: {error:.2e}, stated {stated:.2e}")
            ratios.append(error / max(stated, OWN))
    ratios.sort()
    print(f"{len(ratios)} runs, largest errors over those stated: {[f'{ratio:.2f}' for ratio in ratios[-5:]]}")


if __name__ == "__main__":
    main()
