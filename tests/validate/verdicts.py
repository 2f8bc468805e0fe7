"""Verdicts in words against fields whose answer follows from how they are made."""

import numpy as np
from scipy.special import jv

REPORT = "guide/report.md, What moved"
STILL = ("unchanged",)


def hann(s, length):
    return np.where((s > 0) & (s < length), 0.5 - 0.5 * np.cos(2 * np.pi * s / length), 0.0)


def ricker(s, width):
    return (1 - (s / width) ** 2) * np.exp(-0.5 * (s / width) ** 2)


def noisy(rng, v, low=1e-4, high=1e-2):
    return v + np.abs(v).max() * 10 ** rng.uniform(np.log10(low), np.log10(high)) * rng.standard_normal(
        v.shape
    )


class Scan:
    """A scan of a burst that comes from the left."""

    def __init__(self, rng):
        self.times, self.sites = 4096, int(rng.integers(32, 72))
        self.dt, self.dx = 8e-6, 2.5e-3
        self.t = np.arange(self.times)[:, None] * self.dt
        self.x = np.arange(self.sites)[None] * self.dx
        self.speed = rng.uniform(80, 300)
        self.f = rng.uniform(2.5e3, 5e3)
        self.length = rng.uniform(8, 16) / self.f
        self.since = self.t - rng.uniform(4e-3, 8e-3) - self.x / self.speed

    def burst(self, times=1):
        return hann(self.since, self.length) * np.sin(2 * np.pi * times * self.f * self.since)

    def grown(self, rng):
        """The share of the energy in the harmonic, from the first site to the last."""
        share = rng.uniform(0.15, 0.5) * (self.x / self.x.max()) ** rng.uniform(0.7, 2)
        order = int(rng.integers(2, 4))
        return share, np.sqrt(1 - share) * self.burst() + np.sqrt(share) * self.burst(order)

    def through(self, gain):
        """Two bursts behind a medium that takes `gain(f, x)` of each frequency."""
        f = np.fft.rfftfreq(self.times, self.dt)[:, None]
        both = np.fft.rfft((self.burst() + 0.7 * self.burst(2))[:, :1], axis=0)
        return np.fft.irfft(
            both * np.exp(-2j * np.pi * f * self.x / self.speed) * gain(f), self.times, axis=0
        )


def growing(rng):
    scan = Scan(rng)
    share, v = scan.grown(rng)
    ends = float(share[0, -4:].mean() - share[0, :4].mean())
    return (
        noisy(rng, v),
        scan,
        {"frequency": ("up",), "transfer": (True,), "up": ends, "speed": scan.speed},
    )


def growing_dispersive(rng):
    """The same where the harmonic is faster or slower than the burst that feeds it, and both spread."""
    scan = Scan(rng)
    share = rng.uniform(0.2, 0.5) * (scan.x / scan.x.max())
    f = np.fft.rfftfreq(scan.times, scan.dt)[:, None]
    first, second = (np.fft.rfft(scan.burst(n)[:, :1], axis=0) for n in (1, 2))
    bend = rng.uniform(-0.02, 0.02)
    delay = np.exp(-2j * np.pi * f * scan.x / scan.speed * (1 + bend * (f / scan.f) ** 2))
    v = np.fft.irfft((np.sqrt(1 - share) * first + np.sqrt(share) * second) * delay, scan.times, axis=0)
    return noisy(rng, v), scan, {"frequency": ("up",), "transfer": (True,)}


def returning(rng):
    scan = Scan(rng)
    share = rng.uniform(0.2, 0.5) * (1 - scan.x / scan.x.max())
    v = np.sqrt(1 - share) * scan.burst() + np.sqrt(share) * scan.burst(2)
    return noisy(rng, v), scan, {"frequency": ("down",)}


def burst(rng):
    scan = Scan(rng)
    return noisy(rng, scan.burst()), scan, {"frequency": STILL, "wavenumber": STILL, "speed": scan.speed}


def decaying(rng):
    scan = Scan(rng)
    v = scan.burst() * np.exp(-scan.x / scan.x.max() * rng.uniform(0.5, 2))
    return noisy(rng, v, high=3e-3), scan, {"frequency": STILL, "wavenumber": STILL}


def lossy_high(rng):
    scan = Scan(rng)
    rate = rng.uniform(1, 2.5) / scan.x.max()
    v = scan.through(lambda f: np.exp(-rate * scan.x * f / 6e3))
    return noisy(rng, v, high=2e-3), scan, {"frequency": ("down",), "transfer": (False, None)}


def lossy_low(rng):
    scan = Scan(rng)
    rate = rng.uniform(1, 2) / scan.x.max()
    v = scan.through(lambda f: np.exp(-rate * scan.x * np.clip(2 - f / scan.f, 0, 2)))
    return noisy(rng, v, high=2e-3), scan, {"frequency": ("up",), "transfer": (False, None)}


class Array:
    """Sites that are half a metre or so in all, and steady or short motion."""

    def __init__(self, rng, times=2048):
        self.times, self.sites, self.dt, self.dx = times, int(rng.integers(40, 80)), 1e-3, 0.01
        self.t, self.x = np.arange(times)[:, None] * self.dt, np.arange(self.sites)[None] * self.dx
        self.sign = int(rng.choice([-1, 1]))

    def along(self):
        return self.x if self.sign > 0 else self.x.max() - self.x


def pulse(rng):
    array = Array(rng)
    speed = rng.uniform(0.5, 1.5)
    width = 0.02 * rng.uniform(0.8, 1.5)
    v = ricker(array.t - 0.3 - array.along() / speed, width)
    truth = {"frequency": STILL, "wavenumber": STILL, "towards": array.sign, "speed": array.sign * speed}
    return noisy(rng, v), array, truth


def two_pulses(rng):
    array = Array(rng)
    speed, size = rng.uniform(0.5, 0.9), rng.uniform(0.2, 0.7)
    v = ricker(array.t - 0.3 - array.along() / speed, 0.02)
    v = v + size * ricker(array.t - 0.3 - (array.x.max() - array.along()) / speed, 0.02)
    share = 1 / (1 + size**2)
    plus = share if array.sign > 0 else 1 - share
    return noisy(rng, v, high=1e-3), array, {"frequency": STILL, "wavenumber": STILL, "plus": plus}


def tone(rng):
    array = Array(rng)
    f, waves = rng.uniform(20, 200), rng.uniform(2.5, 8)
    k = 2 * np.pi * waves / array.x.max()
    v = np.cos(array.sign * k * array.x - 2 * np.pi * f * array.t + rng.uniform(0, 6))
    return (
        noisy(rng, v, high=3e-2),
        array,
        {"frequency": STILL, "wavenumber": STILL, "towards": array.sign},
    )


def standing(rng):
    array = Array(rng)
    f, waves = rng.uniform(20, 150), rng.uniform(2.5, 6)
    v = np.cos(2 * np.pi * f * array.t) * np.cos(
        2 * np.pi * waves * array.x / array.x.max() + rng.uniform(0, 6)
    )
    return noisy(rng, v), array, {"frequency": STILL, "wavenumber": STILL}


def random_wave(rng, array):
    """A steady random wave of one direction, of standard deviation 1."""
    length = array.times + 2048
    f = np.fft.rfftfreq(length, array.dt)
    band = np.fft.rfft(rng.standard_normal(length)) * np.exp(-0.5 * ((f - rng.uniform(20, 40)) / 6) ** 2)
    delay = array.along()[0] / rng.uniform(2.0, 3.0)
    v = np.stack([np.fft.irfft(band * np.exp(-2j * np.pi * f * d), length) for d in delay], axis=1)
    v = v[1024 : 1024 + array.times]
    return v / v.std()


def random_plane(rng):
    array = Array(rng)
    v = noisy(rng, random_wave(rng, array))
    return v, array, {"frequency": STILL, "wavenumber": STILL, "towards": array.sign}


def drift(rng):
    array = Array(rng)
    v = random_wave(rng, array) + 0.02 * rng.standard_normal((array.times, array.sites))
    offsets, slopes = rng.standard_normal((2, 1, array.sites)) * rng.uniform(0.2, 3)
    return (
        v + offsets + slopes * array.t / array.t.max(),
        array,
        {"frequency": STILL, "wavenumber": STILL},
    )


def white(rng):
    array = Array(rng, times=4096)
    return (
        rng.standard_normal((array.times, array.sites)),
        array,
        {"frequency": STILL, "wavenumber": STILL},
    )


def dispersive(rng):
    array = Array(rng, times=1024)
    array.sites = 220
    array.x = np.arange(220)[None] * array.dx
    k = np.linspace(-280, 280, 4001)
    speed, bend = rng.uniform(1.2, 2.0), rng.uniform(1e-6, 4e-6)
    a, w = np.exp(-0.5 * (k / rng.uniform(40, 60)) ** 2), speed * k * (1 - bend * k**2)
    v = np.real((a * np.exp(-1j * np.outer(array.t, w))) @ np.exp(1j * np.outer(k, array.x - 0.35)))
    return noisy(rng, v, high=1e-3), array, {"frequency": STILL, "wavenumber": STILL, "towards": 1}


def steepening(rng):
    """Fubini's solution of Burgers' equation before the shock: harmonics grow, no energy is lost."""
    array = Array(rng, times=4096)
    f = rng.integers(8, 24) / (array.times * array.dt) * 8
    sigma = array.x / array.x.max() * rng.uniform(0.75, 0.95) + 1e-9
    phase = 2 * np.pi * f * (array.t - array.x / rng.uniform(2.0, 5.0))
    v = sum(2 * jv(n, n * sigma) / (n * sigma) * np.sin(n * phase) for n in range(1, 12))
    return noisy(rng, v, high=3e-3), array, {"frequency": ("up",), "transfer": (True,)}


KINDS = {
    "second or third harmonic grows": growing,
    "harmonic grows in a dispersive medium": growing_dispersive,
    "wave steepens (Fubini)": steepening,
    "harmonic returns to its fundamental": returning,
    "high frequencies absorbed": lossy_high,
    "low frequencies absorbed": lossy_low,
    "burst of constant shape": burst,
    "burst that decays": decaying,
    "pulse of constant shape": pulse,
    "dispersive pulse": dispersive,
    "two pulses that meet": two_pulses,
    "plane wave in noise": tone,
    "standing wave in noise": standing,
    "random plane wave": random_plane,
    "random plane wave with drift": drift,
    "white noise": white,
}


def judged(part, name, make, count, tally):
    by = f"{count} fields: {name}"
    told = untold = false = 0
    wrong = []
    for number in range(count):
        values, axes, truth = make(part.rng)
        summary, _ = part.analyzed(values, "--only", "temporal,spatial,spacetime", dt=axes.dt, dx=axes.dx)
        moved = summary["moved"]
        faults = []
        for axis in ("frequency", "wavenumber"):
            verdict = (moved[axis] or {}).get("verdict", "untold")
            if axis not in truth or verdict == "untold":
                untold += axis in truth
                continue
            told += 1
            if verdict not in truth[axis]:
                faults.append(f"{axis} {verdict}")
        found = moved["frequency"] or {}
        if found.get("verdict") in ("up", "down") and found["transfer"] not in truth.get(
            "transfer", (found["transfer"],)
        ):
            faults.append(f"transfer {found['transfer']}")
        if "up" in truth and found.get("verdict") == "up":
            tally["shares"].append((truth["up"], found["up"]))
        direction = moved.get("direction") or {}
        plus = direction.get("toward_plus_x")
        if "towards" in truth and plus is not None:
            told += 1
            minus = direction["toward_minus_x"]
            if (plus - minus) * truth["towards"] < 0:
                faults.append(f"direction {plus}")
        if "plus" in truth and plus is not None:
            tally["plus"].append(abs(plus / (plus + direction["toward_minus_x"]) - truth["plus"]))
        speed = direction.get("speed")
        if "speed" in truth and speed is not None and speed["error"] is not None:
            tally["speeds"].append(abs(speed["value"] - truth["speed"]) <= speed["error"])
        if faults:
            false += len(faults)
            wrong.append(f"{name} {number}: {', '.join(faults)}; said: {summary['answer']}")
    tally["table"].append((name, told - false, untold, false))
    part.none_of(f"false statements: {name}", false, told, where=REPORT, by=by) if told else part.note(
        f"{name}: nothing was told of {count} fields"
    )
    for text in wrong:
        part.note(text)


def of_kinds(part, kinds):
    count = 4 if part.quick else 24
    tally = {"shares": [], "plus": [], "speeds": [], "table": []}
    for name in kinds:
        judged(part, name, KINDS[name], count, tally)
    part.outcome.series["verdicts"] = tally["table"]
    if tally["shares"]:
        truth, found = np.array(tally["shares"]).T
        what = "share that moved up, where it is told"
        by = "growth of the harmonic's share from the first four sites to the last"
        part.claim(what, truth, found, 0.05, where=REPORT, by=by)
        part.outcome.series["shares"] = (truth.tolist(), found.tolist())
    if tally["plus"]:
        what = "share of the energy towards +x of two pulses"
        part.claim(
            what,
            0.0,
            max(tally["plus"]),
            0.02,
            where="guide/report.md, Direction",
            by="squares of amplitudes",
        )
    if tally["speeds"]:
        held = tally["speeds"]
        part.covers(
            "95 % intervals of speeds",
            sum(held),
            len(held),
            where=REPORT,
            by="the speed put in",
            wide=True,
        )


def transfers(part):
    """Verdicts of fields whose energy moves"""
    of_kinds(part, list(KINDS)[:6])


def still(part):
    """Verdicts of bursts and pulses whose content stays"""
    of_kinds(part, list(KINDS)[6:11])


def steady(part):
    """Verdicts of steady fields"""
    of_kinds(part, list(KINDS)[11:])


def dimers(part):
    """Verdicts of localized and dispersive dimers"""
    count = 3 if part.quick else 12
    published = [1.0, 4.9272, 14.622, 31.275]
    wrong, unsettled = [], []
    for number in range(count):
        ratio = float(published[number % 4] * (1 + part.rng.uniform(-2e-3, 2e-3))) if number % 4 else 1.0
        words = [
            "--sites",
            int(part.rng.integers(160, 260)),
            "--stiffness-ratio",
            ratio,
            "--end-time",
            "auto",
        ]
        part.run("simulate", *words, "--samples", 2048, "--out", "run.npz", "--force", "--quiet")
        moved = part.estimate("analyze", part.folder / "run.npz")[0]["moved"]["frequency"]
        if moved["verdict"] not in ("unchanged", "untold") or moved["settled_at"] is None:
            wrong.append(f"ratio {ratio}: {moved['verdict']}, settled at {moved['settled_at']}")
        ratio = float(part.rng.uniform(2.0, 2.9))
        words[3] = ratio
        part.run("simulate", *words, "--samples", 2048, "--out", "run.npz", "--force", "--quiet")
        moved = part.estimate("analyze", part.folder / "run.npz")[0]["moved"]["frequency"]
        if moved["verdict"] not in ("up", "spreads", "untold") or moved["settled_at"] is not None:
            unsettled.append(f"ratio {ratio}: {moved['verdict']}, settled at {moved['settled_at']}")
    where = "guide/report.md, What moved: struck chains"
    by = "published ratios of localized waves"
    part.none_of("localized dimers whose front does not settle", len(wrong), count, where=where, by=by)
    by = "ratios of 2 to 2.9, between localized waves"
    part.none_of("dispersive dimers whose front settles", len(unsettled), count, where=where, by=by)
    for text in wrong + unsettled:
        part.note(text)


PARTS = [transfers, still, steady, dimers]
