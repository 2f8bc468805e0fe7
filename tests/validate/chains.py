"""Chains against closed forms, double-double arithmetic and SciPy's DOP853."""

import importlib.util
import pathlib

import mpmath
import numpy as np
from documents import number
from frame import scene_text
from scipy.integrate import solve_ivp
from scipy.special import jv

ROOT = pathlib.Path(__file__).resolve().parents[2]
CHAINS = "accuracy.md, Chains"


def script(path):
    """A script of the repository, as a module."""
    spec = importlib.util.spec_from_file_location(pathlib.Path(path).stem, ROOT / path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def closed_forms(part):
    """Chains with closed forms"""
    # A free end struck: of equal springs and masses, with the image of the end.
    tolerance = 1e-11
    keys = dict(sites=90, law="spring", ends="free", striker_velocity=1.0, end_time=35.0, samples=71)
    run, report = part.simulated(scene_text(**keys, tolerance=tolerance))
    n, t = np.arange(90)[None], run["time"][:, None]
    truth = jv(2 * n, 2 * t) + jv(2 * n + 2, 2 * t)
    by = "Bessel functions, J_2n(2t) + J_2n+2(2t)"
    part.claim(
        "velocities of a struck harmonic chain at tolerance 1e-11",
        truth,
        run["velocity"],
        1e-11,
        where=CHAINS,
        by=by,
    )
    what = "true error of this run over the error that it states"
    apart = np.abs(run["velocity"] - truth).max()
    part.within(what, float(apart / max(report["error"], 2e-16)), None, 1.0, where=CHAINS, by=by)

    text = part.run("scene", "--preset", "toda_soliton").stdout
    run, _ = part.simulated(text)
    j, t, s = np.arange(48)[None], run["time"][:, None], np.sinh(1)
    truth = s * (np.tanh(j - 11 - t * s) - np.tanh(j - 12 - t * s))
    by = "closed form (Toda 1967)"
    where = "guide/chains.md, Scenes that come with the program"
    part.claim(
        "Toda's soliton, of its largest velocity",
        truth,
        run["velocity"],
        1e-9,
        where=where,
        by=by,
        scale=truth.max(),
    )

    # Two equal Hertz bodies: t(delta) = delta 2F1(1/2, 2/5; 7/5; 8/5 delta^(5/2)).
    mpmath.mp.dps = 30
    deepest = mpmath.mpf(5) / 8
    deepest = deepest ** (mpmath.mpf(2) / 5)

    def when(overlap):
        return overlap * mpmath.hyp2f1(
            0.5, mpmath.mpf(2) / 5, mpmath.mpf(7) / 5, mpmath.mpf(8) / 5 * overlap**2.5
        )

    contact = 2 * when(deepest)
    keys = dict(sites=2, ends="free", striker_velocity=1.0, end_time=float(contact) * 1.17, samples=25)
    run, _ = part.simulated(scene_text(**keys, tolerance=1e-11))
    truth = []
    for t in run["time"]:
        at = min(mpmath.mpf(float(t)), contact)
        into = min(at, contact - at)
        if into <= 0:
            overlap = mpmath.mpf(0)
        else:
            bracket = mpmath.mpf(0), deepest * (1 - mpmath.mpf(10) ** -25)
            overlap = mpmath.findroot(
                lambda d, into=into: mpmath.re(when(d)) - into, bracket, solver="bisect", verify=False
            )
        closing = mpmath.sqrt(abs(1 - mpmath.mpf(8) / 5 * mpmath.re(overlap) ** 2.5))
        closing = closing if at <= contact / 2 else -closing
        truth.append([float((1 + closing) / 2), float((1 - closing) / 2)])
    by = "hypergeometric function, mpmath"
    what = "velocities in a collision of two spheres at tolerance 1e-11"
    part.claim(what, truth, run["velocity"], 1e-11, where=CHAINS, by=by)
    out = part.folder / "sweep"
    words = [
        "--sites",
        2,
        "--ends",
        "free",
        "--end-time",
        4,
        "--samples",
        512,
        "--vary",
        "striker_velocity=1:3:3",
    ]
    part.run("sweep", *words, "--out", out, "--quiet")
    table = np.genfromtxt(out / "table.csv", delimiter=",", names=True)
    force = float(deepest) ** 1.5 * table["striker_velocity"] ** 1.2
    apart = np.abs(table["peak_force_first"] - force)
    by = "closed form"
    what = "largest force of two spheres over three speeds: error over that stated"
    ratio = apart / np.maximum(table["peak_force_first_error"], 1e-15)
    part.within(what, float(ratio.max()), None, 1.0, where="reference.md, Tables", by=by)

    # A flight of 45 time units before the bodies meet.
    keys = dict(
        sites=2, ends="free", displacements=[-45.0, 0.0], striker_velocity=1.0, end_time=60.0, samples=7
    )
    run, _ = part.simulated(scene_text(**keys))
    energy = (run["velocity"][-1] ** 2).sum() / 2
    part.claim(
        "energy of two bodies that meet after 45 time units", 0.5, energy, 2e-13, where=CHAINS, by="exact"
    )
    part.claim(
        "and their velocities",
        [0.0, 1.0],
        run["velocity"][-1],
        1e-9,
        where=CHAINS,
        by="exact: they exchange them",
    )


def tolerances(part):
    """Tolerances of struck dimers"""
    ratios = [1.0, 4.9272, float(part.rng.uniform(1.5, 60))]
    ratios += [] if part.quick else [2.398, 1e4, 1e6]
    asked = [1e-4, 1e-6, 1e-9, 1e-11] if part.quick else [10.0**-e for e in range(4, 12)]
    sites, end, samples = 10, 12.0, 25
    reference = script("tests/data/chain_reference.py")
    points = []
    for ratio in ratios:
        truth, _ = reference.dimer(sites, ratio, np.linspace(0, end, samples))
        worst, beyond, warned = 0.0, 0.0, 0
        for tolerance in asked:
            keys = dict(
                sites=sites, stiffness_ratio=ratio, end_time=end, samples=samples, tolerance=tolerance
            )
            run, report = part.simulated(scene_text(**keys))
            error = float(np.abs(run["velocity"] - truth).max())
            points.append((ratio, tolerance, error, report["error"]))
            if report["warnings"]:
                warned += 1
                continue
            worst = max(worst, error / tolerance)
            beyond = max(beyond, error / report["error"])
        by = "extrapolation in double-double arithmetic, itself right to 1e-17"
        told = f", {warned} with a warning" if warned else ""
        asked_for = f"{asked[0]:.0e} to {asked[-1]:.0e}"
        what = f"ratio {ratio:.6g}: largest error over the tolerance, {asked_for}{told}"
        part.within(what, worst, None, 1.0, where=CHAINS, by=by)
        what = f"ratio {ratio:.6g}: true error over the error stated"
        part.within(what, beyond, None, 1.0, where=CHAINS, by=by)
    part.outcome.series["tolerances"] = points
    words = [
        "--sites",
        300,
        "--stiffness-ratio",
        9.112,
        "--end-time",
        295,
        "--tolerance",
        1e-8,
        "--samples",
        64,
    ]
    part.run("simulate", *words, "--out", "amplified.npz", "--force", "--quiet")
    with np.load(part.folder / "amplified.npz") as stored:
        warnings = str(stored["report"]).count("amplif")
    what = "a chain of 300 at ratio 9.112 says that it amplifies rounding errors"
    part.same(what, True, warnings > 0, where=CHAINS, by="the run's warnings")


def of_random_scenes(part, count):
    # They know their own right-hand side.
    scenes = script("benches/peers/chain/random_scenes.py")
    above, refused, ratios = [], 0, []
    for _ in range(count):
        seed = int(part.rng.integers(0, 2**31))
        text, *known = scenes.scene(seed)
        try:
            run, report = part.simulated(text)
        except RuntimeError:
            refused += 1
            continue
        names = [name for name in ("velocity", "resonator_velocity") if name in run]
        known += [run["time"], [run[name] for name in names]]
        error = scenes.departure(known, report["error"], report["velocity_scale"])
        ratios.append(error / max(report["error"], scenes.OWN))
        if error > max(report["error"], scenes.OWN):
            above.append(f"random scene {seed}: error {error:.2e}, stated {report['error']:.2e}")
    what = "random chains (laws, ends, losses, resonators, drives) with an error above the one stated"
    part.none_of(what, len(above), len(ratios), where=CHAINS, by="SciPy's DOP853, itself right to 2e-11")
    for text in above:
        part.note(text)
    if refused:
        part.note(f"{refused} of {count} random scenes ended with an error of the program")
    part.outcome.series["random_scenes"] = ratios


def random_chains(part):
    """Random chains: the error stated against the true one"""
    of_random_scenes(part, 2 if part.quick else 20)


def more_random_chains(part):
    """More random chains"""
    of_random_scenes(part, 2 if part.quick else 20)


def crossed(angle, young, poisson, radius):
    """The exact coefficient of equal cylinders crossed at an angle.

    With the eccentricity e of the contact and the curvatures A = (1 - cos) / 2R and B = (1 + cos) / 2R,
    B / A = (E / (1 - e^2) - K) / (K - E).
    """
    mpmath.mp.dps = 40
    radius, alpha = mpmath.mpf(radius), mpmath.mpf(angle) * mpmath.pi / 180
    modulus = mpmath.mpf(young) / (2 * (1 - mpmath.mpf(poisson) ** 2))
    if angle == 90:
        return 4 * modulus * mpmath.sqrt(radius) / 3
    a, b = (1 - mpmath.cos(alpha)) / (2 * radius), (1 + mpmath.cos(alpha)) / (2 * radius)

    def off(log_rest):
        m = 1 - mpmath.exp(log_rest)
        k, e = mpmath.ellipk(m), mpmath.ellipe(m)
        return mpmath.log((e / (1 - m) - k) / (k - e) * a / b)

    ends = mpmath.mpf(-80), mpmath.mpf("-1e-9")
    m = 1 - mpmath.exp(mpmath.findroot(off, ends, solver="anderson", tol=1e-30, maxsteps=400))
    k, e = mpmath.ellipk(m), mpmath.ellipe(m)
    return 2 * mpmath.pi * modulus / 3 * k**-1.5 * mpmath.sqrt((k - e) / (a * m))


def cylinders(part):
    """Contact coefficients"""
    young, poisson, radius = 72e9, 0.17, 9e-3
    worst = 0.0
    angles = [0.01, 90.0, *np.exp(part.rng.uniform(np.log(0.01), np.log(90), 8 if part.quick else 30))]
    for angle in map(float, angles):
        keys = dict(young=young, poisson=poisson, density=2200.0, radius=radius, length=2 * radius)
        keys |= dict(angle=angle, second_angle=angle, ellipse="exact", striker_velocity=1e-3)
        run, _ = part.simulated(scene_text(sites=3, **keys, end_time=1e-9, samples=2, tolerance=1e-4))
        found = mpmath.mpf(float(run["contact_coefficient"][1]))
        worst = max(worst, float(abs(found / crossed(angle, young, poisson, radius) - 1)))
    what = f"coefficient of crossed cylinders, {len(angles)} angles from 0.01 to 90 degrees, relative"
    stated = number(CHAINS, "crossed cylinders is accurate to # from 0.01 to 90 degrees")
    part.claim(what, 0.0, worst, stated, where=CHAINS, by="elliptic integrals, mpmath, 40 digits")


def recurrence(part):
    """The chain of Fermi, Pasta, Ulam and Tsingou"""
    # 32 springs.
    sites, alpha = 31, 0.25
    text = part.run("scene", "--preset", "fput").stdout
    run, _ = part.simulated(text, "--sites", sites)
    where = "methods.md, Energy by mode"
    modes = np.sqrt(2 / (sites + 1)) * np.sin(
        np.pi * np.outer(np.arange(1, sites + 1), np.arange(1, sites + 1)) / (sites + 1)
    )
    omega = 2 * np.sin(np.pi * np.arange(1, sites + 1) / (2 * (sites + 1)))

    def energies(x, v):
        return ((v @ modes) ** 2 + (omega * (x @ modes)) ** 2) / 2

    first = energies(run["displacement"], run["velocity"])[:, 0]
    period = 2 * np.pi / omega[0]
    again = np.interp(146.75 * period, run["time"], first) / first[0]
    by = "sine transform of the run"
    part.claim(
        "first mode after 146.75 of its periods, of its energy", 0.981, again, 5e-4, where=where, by=by
    )
    step = 0.125**0.5
    words = ["--scheme", "velocity-verlet", "--step", step, "--end-time", 180 * period, "--samples", 721]
    old, _ = part.simulated(text, "--sites", sites, *words)
    back = energies(old["displacement"], old["velocity"])
    share = np.where(old["time"] > 100 * period, back[:, 0] / back.sum(axis=1), 0)
    what = "with the step of the first computation: recurrence, in periods"
    by = "published by Fermi, Pasta and Ulam: 157"
    part.claim(what, 157, old["time"][np.argmax(share)] / period, 1.0, where=where, by=by)
    if part.quick:
        return

    def rates(t, state):
        x, v = state[:sites], state[sites:]
        # As a stretch, the opposite of an overlap d, whose force is d - alpha d^2.
        stretched = np.append(x, 0) - np.append(0, x)
        force = stretched + alpha * stretched**2
        return np.concatenate([v, force[1:] - force[:-1]])

    start = np.concatenate([run["displacement"][0], run["velocity"][0]])
    every = len(run["time"]) // 64
    times = run["time"][::every]
    found = solve_ivp(rates, (0, times[-1]), start, "DOP853", times, rtol=1e-13, atol=1e-15)
    mine = energies(run["displacement"], run["velocity"])[::every]
    apart = np.abs(energies(found.y[:sites].T, found.y[sites:].T) - mine).max() / first[0]
    what = "energies of its modes over 166 periods, of the energy"
    part.claim(what, 0.0, float(apart), 3e-9, where=where, by="SciPy's DOP853")


PARTS = [random_chains, more_random_chains, tolerances, closed_forms, cylinders, recurrence]
