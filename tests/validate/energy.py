"""Budgets, measured chains, fits and lengths against NumPy and what was put in."""

import json

import numpy as np
from documents import numbers
from frame import scene_text

BUDGETS = "accuracy.md, Budgets"


def hertz_energy(overlap, coefficient):
    return 0.4 * coefficient * np.maximum(overlap, 0) ** 2.5


def site_energies(run):
    """Kinetic energy and half of each contact; the wall's belongs to the last site."""
    x = run["displacement"]
    overlap = x - np.column_stack([x[:, 1:], np.zeros(len(x))])
    stored = hertz_energy(overlap, run["contact_coefficient"])
    e = 0.5 * run["mass"] * run["velocity"] ** 2
    share = stored / 2
    share[:, -1] *= 2
    e += share
    e[:, 1:] += share[:, :-1]
    return e, stored


def folded(series, nk):
    """Power over |k| of a series along its last axis, both signs together."""
    power = np.abs(np.fft.fft(series, axis=1)) ** 2 / series.shape[1]
    both = power[:, :nk].copy()
    last = (series.shape[1] + 1) // 2
    both[:, 1:last] += power[:, :-last:-1]
    return both


def balances(part):
    """Energy budgets of struck chains"""
    count = 3 if part.quick else 12
    real, spectrum, sums, passed, total = {"dimers": [], "random": []}, [], [], [], []
    for number in range(2 * count):
        kind = ("dimers", "random")[number % 2]
        sites = int(part.rng.integers(20, 60))
        keys = dict(sites=sites, striker_velocity=1.0, samples=int(part.rng.integers(9, 200)))
        keys["end_time"] = float(part.rng.uniform(0.7, 1.5)) * sites
        if kind == "dimers":
            keys["stiffness_ratio"] = float(np.exp(part.rng.uniform(0, 5)))
        else:
            keys["masses"] = part.rng.uniform(0.6, 1.6, sites).tolist()
            keys["coefficients"] = part.rng.uniform(0.5, 6, sites).tolist()
        run, _ = part.simulated(scene_text(**keys))
        e, stored = site_energies(run)
        w = run["energy_passed"]
        # Nothing passes the wall: the last contact is the last site's.
        nothing = np.zeros((len(w), 1))
        through = np.hstack([nothing, w[:, :-1], nothing])
        scale = 0.5 * run["mass"][0]
        real[kind].append(np.abs(e - e[0] + np.diff(through, axis=1)).max() / scale)
        if number >= count:
            continue
        summary, found = part.estimate("budget", part.folder / "run.npz")
        x = run["displacement"]
        overlap = x - np.column_stack([x[:, 1:], np.zeros(len(x))])
        nk = found["energy_spectrum"].shape[1]
        both = folded(np.sqrt(run["mass"]) * run["velocity"], nk) / 2
        both += folded(np.sign(overlap) * np.sqrt(stored), nk)
        spectrum.append(np.abs(found["energy_spectrum"] - both).max() / scale)
        total.append(np.abs(found["energy_spectrum"].sum(axis=1) - e.sum(axis=1)).max() / scale)
        t = found["transfer"]
        sums.append((np.abs(t.sum(axis=1)) / np.abs(t).max(axis=1).clip(1e-12)).max())
        change = np.cumsum(both[-1] - both[0])
        apart = np.abs(found["integrated_spectral_flux"][-1] + change).max() / scale
        # The motion is integrated again: velocities depart by so much, energies by twice.
        passed.append(apart / (1e-12 + 2 * summary["closure"]["departure"]))
    by = "energies by NumPy from the run's motion"
    what = "dimers, every site: change of energy less what passed, over the input"
    part.claim(what, 0.0, max(real["dimers"]), 7e-12, where="accuracy.md, Chains", by=by)
    what = "random masses and coefficients: the same"
    part.claim(what, 0.0, max(real["random"]), 2e-11, where="accuracy.md, Chains", by=by)
    part.claim(
        "E(k, t) over the input", 0.0, max(spectrum), 1e-12, where=BUDGETS, by="NumPy's transforms"
    )
    what = "its sum over k against the energy, over the input"
    part.claim(what, 0.0, max(total), 1e-12, where=BUDGETS, by=by)
    what = "sum of the transfers over k, of the largest transfer"
    part.claim(what, 0.0, max(sums), 3e-14, where=BUDGETS, by="it is 0")
    what = (
        "energy passed k: integrated flux against the change of E(k), over 1e-12 and twice the departure"
    )
    part.claim(
        what, 0.0, max(passed), 1.0, where=BUDGETS, by="NumPy's transforms of first and last sample"
    )


#: Kinds of chains, and to what their power flow by frequency closes.
KINDS = {
    "precompressed": (dict(precompression=0.05), 1e-9),
    "free ends": (dict(ends="free"), 1e-9),
    "springs of two powers": (dict(law="spring", alpha=0.2, beta=0.1, ends="fixed"), 1e-9),
    "Toda": (dict(law="toda", steepness=0.7, ends="free"), 1e-9),
    "weight": (dict(gravity=0.01), 1e-9),
    "drag": (dict(drag=0.02), 1e-9),
    "tangent damping": (dict(tangent=0.02), 5e-8),
    "dashpots": (dict(dashpot=0.03), 5e-6),
    "springs to the ground": (dict(ground_cell=[0.2], precompression=0.05), 1e-9),
    "resonators": (dict(resonator_mass=0.3, resonator_frequency=0.1, precompression=0.05), 1e-9),
    "a driven wall": (
        dict(ends="fixed", drive="wall", drive_waveform="sine", drive_amplitude=0.1, drive_frequency=0.1,
             precompression=0.05), 1e-9,
    ),
}  # fmt: skip


def closures(part):
    """Budgets of chains of many kinds close"""
    worst = {"real space": 0.0, "wavenumber": 0.0, "frequency": 0.0, "scale": 0.0}
    names = list(KINDS)[:5] if part.quick else list(KINDS)
    for name in names:
        kind, by_frequency = KINDS[name]
        keys = dict(sites=24, stiffness_ratio=float(part.rng.uniform(1, 6)), end_time=30.0, samples=65)
        keys |= {} if "drive" in kind else {"striker_velocity": 1.0}
        # Filters reach over forty sites.
        keys |= {"sites": 72} if name in ("free ends", "Toda") and not part.quick else {}
        part.simulated(scene_text(**(keys | kind)))
        closure = part.estimate("budget", part.folder / "run.npz")[0]["closure"]
        for view in worst:
            value = abs(closure[view.replace(" ", "_")] or 0.0)
            worst[view] = max(worst[view], value / (by_frequency if view == "frequency" else 1.0))
    by = "the balance that the program states, over the energy"
    sentence = "in real space (# where forces set in with a kink), # over wavenumbers and # over scales"
    allowed = dict(zip(("real space", "wavenumber", "scale"), numbers(BUDGETS, sentence), strict=True))
    what = f"{len(names)} kinds of chains close: "
    for view, most in allowed.items():
        if view != "scale" or not part.quick:
            part.claim(what + view, 0.0, worst[view], most, where=BUDGETS, by=by)
    what += "frequency, over 1e-9 (tangent damping 5e-8, dashpots 5e-6)"
    part.claim(what, 0.0, worst["frequency"], 1.0, where=BUDGETS, by=by)


def measured(part):
    """Budgets of measured velocities: stated errors against true ones"""
    count = 2 if part.quick else 10
    where = "accuracy.md, Measured chains"
    inside, cells, near = 0, 0, []
    for _ in range(count):
        ratio = float(part.rng.choice([4.9272, 2.398]))
        keys = dict(sites=40, stiffness_ratio=ratio, striker_velocity=1.0, end_time=60.0, samples=1201)
        run, _ = part.simulated(scene_text(**keys))
        noise = 10.0 ** part.rng.uniform(-4, -2)
        record = run["velocity"] + noise * part.rng.standard_normal(run["velocity"].shape)
        path = part.field(record, float(run["time"][1]), 1.0)
        chain = part.folder / "chain.toml"
        chain.write_text(scene_text(sites=40, stiffness_ratio=ratio))
        summary, found = part.estimate(
            "budget", path, "--scene", chain, "--drift", "none", "--noise", noise
        )
        for name in ("overlap", "force", "energy_passed"):
            if name == "overlap":
                x = run["displacement"]
                truth = x - np.column_stack([x[:, 1:], np.zeros(len(x))])
            else:
                truth = run[name]
            off = np.abs(found[name] - truth)
            held = off <= 3 * found[f"{name}_error"] + 1e-13 * np.abs(truth).max()
            inside += int(held.sum())
            cells += held.size
        energy = summary["measured"]["energy"]
        near.append(abs(energy["value"] - 0.5) <= 2 * energy["error"])
    what = "places within three stated errors, noise of 1e-4 to 1e-2"
    part.within(what, inside / cells, 0.99, None, where=where, by="the run behind the record")
    what = "energies given to the chain that are within two stated errors"
    part.covers(what, sum(near), len(near), 0.954, where=where, by="0.5, that of the striker", wide=True)


def fits(part):
    """Coverage of intervals of fitted chains"""
    count = 6 if part.quick else 36
    held, total, misfits = 0, 0, 0
    for _ in range(count):
        truth = dict(
            stiffness_ratio=float(part.rng.uniform(2, 6)),
            striker_velocity=float(part.rng.uniform(0.7, 1.4)),
        )
        keys = dict(sites=7, end_time=14.0, samples=281)
        run, _ = part.simulated(scene_text(**keys, **truth))
        noise = part.rng.uniform(0.005, 0.05)
        record = run["velocity"] + noise * part.rng.standard_normal(run["velocity"].shape)
        chain = part.folder / "chain.toml"
        start = {key: value * part.rng.uniform(0.93, 1.07) for key, value in truth.items()}
        chain.write_text(scene_text(**keys, **start))
        path = part.field(record, float(run["time"][1]), 1.0)
        summary, _ = part.estimate(
            "fit", path, chain, "--free", ",".join(truth), "--starts", 2, "--bodies", "0,1,2,3,4,5,6"
        )
        misfits += summary["misfit"] is not None
        for value in summary["values"]:
            total += 1
            held += value["low"] <= truth[value["name"]] <= value["high"]
    where = "guide/fit.md, What it says"
    part.covers(
        "95 % intervals of fitted keys", held, total, where=where, by="keys of the run behind the records"
    )
    what = "fits of the right chain that noise alone makes a misfit (4 % or less)"
    part.covers(what, count - misfits, count, 0.96, where=where, by="noise alone", wide=True)


def lengths(part):
    """Lengths that reach a target, extrapolated"""
    count = 2 if part.quick else 8
    told = held = 0
    for _ in range(count):
        ratio = float(part.rng.uniform(2.1, 2.8))
        long = part.estimate("attenuate", "--ratios", f"1,{ratio}", "--bodies", 90, "--sense", "chain")[0]
        curve = next(c for c in long["curves"] if abs(c["stiffness_ratio"] - ratio) < 1e-6)
        soft = [
            (r["bodies"], r["relative_force"])
            for r in curve["rows"]
            if r["kind"] == "soft" and r["relative_force"]
        ]
        bodies = 40
        # A level that the chain reaches between 42 and 58 bodies.
        level = next(force for n, force in soft if n >= int(part.rng.integers(44, 56)))
        words = ["--ratios", f"1,{ratio}", "--bodies", bodies, "--sense", "chain", "--target", level]
        short = part.estimate("attenuate", *words)[0]
        curve = next(c for c in short["curves"] if abs(c["stiffness_ratio"] - ratio) < 1e-6)
        reach = curve["reach"]
        length = reach.get("length") if reach else None
        if not length:
            part.note(f"ratio {ratio:.3f}, target {level:.3f}: {json.dumps(reach)}")
            continue
        above = [n for n, force in soft if force > level * (1 + 1e-12)]
        truth = next((n for n, _ in soft if n > max(above)), None)
        if truth is None:
            continue
        told += 1
        # Soft contacts are two bodies apart: the curve crosses the level behind the one before.
        held += length["low"] <= truth and truth - 2 <= length["high"]
    where = "guide/attenuation.md, Against length"
    if told:
        by = "chains of 90 bodies"
        part.covers("95 % intervals of extrapolated lengths", held, told, where=where, by=by, wide=True)
    else:
        part.note("no length was extrapolated")


PARTS = [balances, closures, measured, fits, lengths]
