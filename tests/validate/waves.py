"""Localized waves and the paper's numbers."""

import itertools
import json
import pathlib

import numpy as np
from documents import number, numbers

ROOT = pathlib.Path(__file__).resolve().parents[2]
LOCALIZED = "accuracy.md, Localized waves"
FIGURES = "figures/README.md"
#: Table 1 of Chaunsali, Toles, Yang and Kim: order, by direct simulation, by their estimate.
TABLE = (
    (1, 1.0, 1.3542), (2, 4.9272, 6.9766), (3, 14.622, 15.533), (4, 31.275, 29.809), (5, 54.517, 50.130),
    (6, 82.990, 77.948), (7, 119.92, 114.31),
)  # fmt: skip


def collocated(soft, stiff, ratio, time, period, modes):
    """The ratio at which the equations of a localized wave have a solution: Newton's method on cosines.

    Unknown are the cosine series of S and P over a period, and eps = ratio^(-2/3). Means are free, so
    that both must vanish where the tails meet.
    """
    n = 2 * modes
    t = (np.arange(2 * n) - n) * period / (2 * n)
    k = np.arange(modes + 1)
    omega = 2 * np.pi * k / period
    basis = np.cos(np.outer(t, omega))
    # Projection on the cosines, and the shift by half a cell both ways.
    project = 2 * basis.T / (2 * n)
    project[0] /= 2
    shift = 2 * np.cos(omega / 2)
    unknown = np.concatenate(
        [project @ np.interp(t, time, soft), project @ np.interp(t, time, stiff), [ratio ** (-2 / 3)]]
    )
    end = np.cos(omega * period / 2)
    m = modes + 1
    for _ in range(60):
        s, p, eps = unknown[:m], unknown[m : 2 * m], unknown[-1]
        values = [basis @ c for c in (s, p)]
        powers = [project @ np.maximum(v, 0) ** 1.5 for v in values]
        slopes = [project @ (1.5 * np.sqrt(np.maximum(v, 0))[:, None] * basis) for v in values]
        equations = np.concatenate([
            -(omega**2 * s + shift * powers[1] - 2 * powers[0])[1:],
            -(eps * omega**2 * p + shift * powers[0] - 2 * powers[1])[1:],
            [powers[0][0] - powers[1][0], end @ s, end @ p],
        ])  # fmt: skip
        jacobian = np.zeros((2 * modes + 3, 2 * m + 1))
        jacobian[:modes, :m] = -(np.diag(omega**2) - 2 * slopes[0])[1:]
        jacobian[:modes, m : 2 * m] = -(shift[:, None] * slopes[1])[1:]
        jacobian[modes : 2 * modes, :m] = -(shift[:, None] * slopes[0])[1:]
        jacobian[modes : 2 * modes, m : 2 * m] = -(np.diag(eps * omega**2) - 2 * slopes[1])[1:]
        jacobian[modes : 2 * modes, -1] = -(omega**2 * p)[1:]
        jacobian[-3, :m], jacobian[-3, m : 2 * m] = slopes[0][0], -slopes[1][0]
        jacobian[-2, :m], jacobian[-1, m : 2 * m] = end, end
        step = np.linalg.solve(jacobian, -equations)
        unknown = unknown + step
        if np.abs(step).max() < 1e-13 * np.abs(unknown).max():
            break
    return unknown[-1] ** -1.5


def localized(part):
    """Ratios of localized waves"""
    orders = 4 if part.quick else 8
    found = json.loads(part.run("localize", "--order", f"1..{orders}", "--json").stdout)
    rows = {row["order"]: row for row in found["orders"]}
    worst = 0.0
    for order in range(2, orders + 1):
        _, wave = part.estimate("localize", "--profile", order)
        time = wave["time"]
        period = 2 * np.abs(time).max()
        kappa = rows[order]["exact"]["kappa"]
        ratio = collocated(*wave["psi"], kappa * 1.002, time, period, 224 + 16 * order)
        worst = max(worst, abs(kappa / ratio - 1))
    by = "collocation in NumPy, started 0.2 % off"
    stated = number(LOCALIZED, "Stiffness ratios are accurate to # up to order 8")
    part.claim(f"ratios of orders 2 to {orders}, relative", 0.0, worst, stated, where=LOCALIZED, by=by)
    for order, direct, _ in TABLE[: orders if part.quick else 7]:
        row = rows[order]
        what = f"order {order}: ratio against the paper's direct simulation, relative"
        kappa = row["exact"]["kappa"]
        part.claim(
            what, 0.0, kappa / direct - 1, 1e-4, where=f"{FIGURES}, Table 1", by=f"published: {direct}"
        )
    cells = 200 if part.quick else 1000
    shape = "over 1000 cells to # (order 2) to # (order 8)"
    for order, stated in zip((2, 8), numbers(LOCALIZED, shape), strict=True):
        if part.quick and order > 2:
            continue
        launch = part.estimate("localize", "--launch", order, "--cells", cells)[0]["launch"]
        change = launch["shape_change"]
        what = f"launched wave of order {order}: change over {cells} cells, of the largest velocity"
        part.claim(what, 0.0, change, stated, where=LOCALIZED, by="its shape at the start")


def experiment(part):
    """The paper's experiment"""
    scene = ROOT / "examples/scenes/quartz_experiment.toml"

    def run(angle, *words, name="experiment"):
        out = part.folder / f"{name}.npz"
        part.run("simulate", scene, "--angle", f"{angle} deg", *words, "--out", out, "--force", "--quiet")
        with np.load(out) as stored:
            return {key: stored[key] for key in stored}

    seven, eight, nine, ten, eleven = (f"{FIGURES}, Figure {n}" for n in (7, 8, 9, 10, 11))
    found = {}
    for angle in (90, 18, 8):
        at = run(angle, "--samples", 10001)
        c = at["contact_coefficient"]
        force = at["force"][:, 25]
        end = np.searchsorted(at["time"], 1.2e-3, side="right")
        peak = np.argmax(force[:end])
        after = force[:end]
        last = next(
            n for n in range(peak, end - 1) if after[n] < 0.5 * after[peak] and after[n + 1] >= after[n]
        )
        passed = at["energy_passed"][:, 25]
        found[angle] = c[26] / c[25], 1 - passed[last] / passed[end - 1]
    kappa = max(found[8][0], 1 / found[8][0])
    part.claim(
        "stiffness ratio of 8 and 90 degrees", 4.507, kappa, 5e-4, where=seven, by="published: 4.507"
    )
    by = "published: a localized wave"
    part.within(
        "90 degrees: share of the energy behind the first pulse",
        abs(found[90][1]),
        None,
        1e-9,
        where=seven,
        by=by,
    )
    by = "published: trailing waves, without a number; docs: a fifth"
    part.claim(
        "18 degrees: share of the energy behind the first pulse",
        0.211,
        found[18][1],
        2e-3,
        where=seven,
        by=by,
    )
    by = "published: localized again, without a number; docs: 4 %"
    part.claim(
        "8 degrees: share of the energy behind the first pulse",
        0.0418,
        found[8][1],
        1e-3,
        where=seven,
        by=by,
    )

    angles = (
        "angle=6,8,12,14,16,18,20,30,90"
        if part.quick
        else "angle=5,6,7,8,9,10,12,14,16,18,20,23,26,30,40,60,90"
    )
    curve = part.estimate("attenuate", scene, "--against", angles, threads=2)[0]["curves"][0]
    force = {point["value"]: point["relative_force"] for point in curve["points"]}
    minima = [e["point"] for e in curve["extremes"] if not e["is_maximum"]]
    least = max(minima, key=lambda point: point["value"])
    part.claim(
        "force at 90 degrees, over itself",
        1.0,
        force[90],
        1e-12,
        where=eight,
        by="published: complete transmission",
    )
    what = "loss of force at the first minimum"
    part.within(what, 1 - least["relative_force"], 0.4, None, where=eight, by="published: more than 40 %")
    what = "and its angle (degrees); the paper says about 18, where 51 % are lost"
    part.claim(
        what, 16.27, least["value"], 0.02, where=eight, by="docs: 16.3; the paper leaves the sensor open"
    )
    what = "force behind 40 cylinders at 16.3 degrees: share lost"
    part.claim(
        what,
        number("guide/attenuation.md", "without losses, # % of the force is lost behind the 40 cylinders")
        / 100,
        1 - least["relative_force"],
        0.005,
        where="guide/attenuation.md, Against a parameter",
        by="docs",
    )
    part.within(
        "loss at 18 degrees", 1 - force[18], 0.4, None, where=eight, by="published: more than 40 %"
    )
    low, high = (share / 100 for share in numbers(FIGURES, "less than half at 16°, and # to # % at 8°"))
    by = "published: a local rise near 8; docs: the same"
    part.within("force at 8 degrees", force[8], low, high, where=eight, by=by)
    part.outcome.series["transmitted"] = sorted(force.items()), (least["value"], least["relative_force"])

    angles = "angle=2:90:12" if part.quick else "angle=2:90:45"
    words = [scene, "--against", angles, "--no-extremes"]
    points = part.estimate("attenuate", *words, threads=2)[0]["curves"][0]["points"]
    times = [point["time_of_flight"]["value"] for point in points]
    falls = all(a < b for a, b in itertools.pairwise(times))
    part.same(
        "the time of flight falls with the angle at every step",
        True,
        falls,
        where=nine,
        by="published: monotone",
    )
    what = "mean speed at 90 degrees (m/s)"
    part.claim(what, 665.0, points[-1]["mean_speed"], 0.1, where=nine, by="docs; no number published")

    # Means over an even and an odd site, at the start and forty sites on.
    centroids = {}
    for angle, end in ((18, "5.7 ms"), (8, "4.6 ms")):
        at = run(angle, "--sites", 201, "--samples", 8193, "--end-time", end)
        power = np.abs(np.fft.rfft(at["velocity"], axis=0)) ** 2
        f = np.fft.rfftfreq(len(at["velocity"]), at["time"][1]) / 1e3
        above = f > 0.5
        each = (power[above] * f[above, None]).sum(axis=0) / power[above].sum(axis=0)
        centroids[angle] = [(each[n] + each[n + 1]) / 2 for n in (2, 40)]
    what = "18 degrees: centroid without drift (kHz), first bodies and forty on"
    stated = numbers(FIGURES, "centroid without drift rises from # to # kHz")
    by = "published: energy moves to high frequency at the start of the chain; docs: the same"
    part.claim(what, stated, centroids[18], 0.1, where=ten, by=by)
    change = centroids[8][1] / centroids[8][0]
    what = "8 degrees: the second over the first"
    part.within(
        what, float(change), 0.9, 1.1, where=ten, by="published: no redistribution; docs: it stays"
    )

    words = [
        "--angles",
        "90,8,18",
        "--bodies",
        60 if part.quick else 100,
        "--sense",
        "chain",
        "--target",
        0.4,
    ]
    curves = part.estimate("attenuate", scene, *words, threads=2)[0]["curves"]
    soft = {}
    for angle, curve in zip((90, 8, 18), curves, strict=True):
        soft[angle] = {r["bodies"]: r["relative_force"] for r in curve["rows"] if r["kind"] == "soft"}
    late = [force for n, force in soft[8].items() if n >= 20]
    by = "published: settles quickly to a saturated value"
    part.within(
        "8 degrees: spread of the force from 20 cylinders on",
        max(late) / min(late) - 1,
        None,
        0.01,
        where=eleven,
        by=by,
    )
    for n, docs in ((20, 0.76), (40, 0.52), (60, 0.36)):
        near = min(soft[18], key=lambda m, n=n: abs(m - n))
        by = "published: drastic attenuation, drawn without numbers; docs"
        part.claim(
            f"18 degrees: force after {n} cylinders", docs, soft[18][near], 0.006, where=eleven, by=by
        )
    part.outcome.series["lengths"] = {angle: sorted(curve.items()) for angle, curve in soft.items()}


PARTS = [localized, experiment]
