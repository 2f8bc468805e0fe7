"""Random chains over all laws, ends, losses, ground and weight: the error that a run states against SciPy's DOP853.

    python3 benches/peers/chain/random_scenes.py PROGRAM [FIRST_SEED [NUMBER]]

Needs numpy and scipy. Prints each run whose error is larger than stated, and the largest ratios. DOP853 makes
short steps, since it knows no kinks of forces; where an excess is near its own error, it runs again with steps
a tenth as long. Errors below 2e-11 are its own.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq


#: What DOP853 is off by itself.
OWN = 2e-11


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
    }
    if ends == "fixed":
        lines["left_wall_coefficient"] = left
    if ground is not None:
        lines["ground_cell"] = ground[:2].tolist()
        lines["ground_law"] = "d + 0.2*d^3"
    force = [cell[j % len(cell)][1] for j in range(m)]
    opens = [cell[j % len(cell)][2] for j in range(m)]
    rest = pressed + weight * np.cumsum(mass)[:m]
    at_rest = np.array([static(force[j], c[j], rest[j]) for j in range(m)])
    wall = static(cell[-1][1], left, pressed)

    def rates(_, y):
        x, v = y[:n], y[n:]
        overlap = at_rest + x[:m] - np.append(x[1:], 0.0)[:m]
        closing = v[:m] - np.append(v[1:], 0.0)[:m]
        push = np.array([c[j] * force[j](overlap[j]) for j in range(m)]) - rest
        push += np.array([dashpot * closing[j] * (overlap[j] > 0 or not opens[j]) for j in range(m)])
        pull = -drag * v
        pull[:m] -= push
        pull[1:] += push[: n - 1]
        if ends == "fixed":
            pull[0] += left * cell[-1][1](wall - x[0]) - pressed
            pull[0] -= dashpot * v[0] * (wall - x[0] > 0 or not cell[-1][2])
        if ground is not None:
            pull -= ground * (x + 0.2 * x**3)
        return np.concatenate([v, pull / mass])

    text = "".join(f"{key} = {json.dumps(value)}\n" for key, value in lines.items())
    return text, rates, n, speed, end


def off(rates, n, speed, end, time, velocity, longest):
    start = np.zeros(2 * n)
    start[n] = speed
    found = solve_ivp(rates, (0, end), start, "DOP853", time, rtol=3e-14, atol=1e-16, max_step=longest)
    return np.abs(found.y[n:].T - velocity).max() / speed


def main():
    program = sys.argv[1]
    first, number = map(int, (sys.argv[2:] + ["0", "300"][len(sys.argv) - 2 :])[:2])
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        path, run = pathlib.Path(folder, "scene.toml"), pathlib.Path(folder, "run.npz")
        for seed in range(first, first + number):
            text, rates, n, speed, end = scene(seed)
            path.write_text(text)
            said = subprocess.run(
                [program, "simulate", path, "--out", run, "--force", "--json"], capture_output=True, text=True
            )
            if said.returncode:
                print(f"seed {seed}: {said.stderr.strip()}")
                continue
            stated = json.loads(said.stdout)["report"]["error"]
            with np.load(run) as arrays:
                known = rates, n, speed, end, arrays["time"], arrays["velocity"]
            error = off(*known, 0.01)
            if error > stated:
                error = off(*known, 0.001)
            if error > max(stated, OWN):
                print(f"seed {seed}: {error:.2e}, stated {stated:.2e}")
            ratios.append(error / max(stated, OWN))
    ratios.sort()
    print(f"{len(ratios)} runs, largest errors over those stated: {[f'{ratio:.2f}' for ratio in ratios[-5:]]}")


if __name__ == "__main__":
    main()
