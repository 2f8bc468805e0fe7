"""Verdicts in words against fields whose answer follows from how they are made."""

import frame
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.signal import lfilter
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


def coloured(rng, shape):
    """Noise of standard deviation 1 whose power falls with frequency, at each site its own."""
    z = rng.standard_normal((shape[0] + 400, shape[1]))
    z = lfilter([1], [1, -rng.uniform(0.6, 0.9)], z, axis=0)[400:]
    return z / z.std()


class Scan:
    """A scan of a burst that comes from the left."""

    def __init__(self, rng):
        self.times, self.sites = 4096, int(rng.integers(32, 72))
        self.dt, self.dx = 8e-6, 2.5e-3
        self.t = np.arange(self.times)[:, None] * self.dt
        self.x = np.arange(self.sites)[None] * self.dx
        self.way = self.x / self.x.max()
        self.speed = rng.uniform(80, 300)
        self.f = rng.uniform(2.5e3, 5e3)
        self.length = rng.uniform(8, 16) / self.f
        self.since = self.t - rng.uniform(4e-3, 8e-3) - self.x / self.speed

    def burst(self, times=1):
        return hann(self.since, self.length) * np.sin(2 * np.pi * times * self.f * self.since)

    def two(self, *amplitudes, order=2):
        """A burst and its harmonic of these amplitudes along the sites, and the energies of both."""
        low, high = amplitudes = np.concatenate(np.broadcast_arrays(self.x, *amplitudes)[1:])
        return low * self.burst() + high * self.burst(order), amplitudes**2

    def through(self, gain):
        """Two bursts behind a medium that takes `gain(f, x)` of each frequency."""
        f = np.fft.rfftfreq(self.times, self.dt)[:, None]
        both = np.fft.rfft((self.burst() + 0.7 * self.burst(2))[:, :1], axis=0)
        return np.fft.irfft(
            both * np.exp(-2j * np.pi * f * self.x / self.speed) * gain(f), self.times, axis=0
        )


def growing(rng):
    scan = Scan(rng)
    share = rng.uniform(0.15, 0.5) * scan.way ** rng.uniform(0.7, 2)
    v, energies = scan.two(np.sqrt(1 - share), np.sqrt(share), order=int(rng.integers(2, 4)))
    truth = {"frequency": ("up",), "transfer": (True,), "energies": energies, "speed": scan.speed}
    return noisy(rng, v), scan, truth


def growing_dispersive(rng):
    """The same where the harmonic is faster or slower than the burst that feeds it, and both spread."""
    scan = Scan(rng)
    share = rng.uniform(0.2, 0.5) * scan.way
    f = np.fft.rfftfreq(scan.times, scan.dt)[:, None]
    first, second = (np.fft.rfft(scan.burst(n)[:, :1], axis=0) for n in (1, 2))
    bend = rng.uniform(-0.02, 0.02)
    delay = np.exp(-2j * np.pi * f * scan.x / scan.speed * (1 + bend * (f / scan.f) ** 2))
    v = np.fft.irfft((np.sqrt(1 - share) * first + np.sqrt(share) * second) * delay, scan.times, axis=0)
    return noisy(rng, v), scan, {"frequency": ("up",), "transfer": (True,)}


def returning(rng):
    scan = Scan(rng)
    share = rng.uniform(0.2, 0.5) * (1 - scan.way)
    v = np.sqrt(1 - share) * scan.burst() + np.sqrt(share) * scan.burst(2)
    return noisy(rng, v), scan, {"frequency": ("down",)}


def burst(rng):
    scan = Scan(rng)
    return noisy(rng, scan.burst()), scan, {"frequency": STILL, "wavenumber": STILL, "speed": scan.speed}


def decaying(rng):
    scan = Scan(rng)
    v = scan.burst() * np.exp(-scan.way * rng.uniform(0.5, 2))
    return noisy(rng, v, high=3e-3), scan, {"frequency": STILL, "wavenumber": STILL}


def beat(rng):
    """A harmonic out of step: it takes energy and gives it back."""
    scan = Scan(rng)
    angle = rng.uniform(0.5, 1) * np.sin(np.pi * rng.integers(1, 3) * scan.way)
    v, energies = scan.two(np.cos(angle), np.sin(angle))
    truth = {"frequency": ("up",), "transfer": (True, None), "energies": energies, "fate": "back"}
    return noisy(rng, v), scan, truth


def up_then_lost(rng):
    """A harmonic that grows up to a place, behind which it is absorbed."""
    scan = Scan(rng)
    place, length = rng.uniform(0.25, 0.5), rng.uniform(0.08, 0.15)
    angle = rng.uniform(0.6, 0.95) * np.minimum(scan.way / place, 1)
    loss = np.exp(-np.maximum(scan.way - place, 0) / length)
    v, energies = scan.two(np.cos(angle), np.sin(angle) * loss)
    truth = {"frequency": ("up",), "transfer": (True, None), "energies": energies, "fate": "lost"}
    return noisy(rng, v), scan, truth


def gains_selective(rng):
    """The burst is absorbed and its harmonic is not, behind sensors of uneven gains."""
    scan = Scan(rng)
    gains = 1 + 0.2 * rng.standard_normal(scan.x.shape)
    fading = np.exp(-rng.uniform(0.8, 1.5) * scan.way)
    v, energies = scan.two(gains * fading, gains * rng.uniform(0.3, 0.6))
    truth = {"frequency": ("up",), "transfer": (False, None), "energies": energies}
    return noisy(rng, v), scan, truth


def decay_coloured(rng):
    scan = Scan(rng)
    v = scan.burst() * np.exp(-rng.uniform(0.8, 1.6) * scan.way)
    return v + rng.uniform(0.01, 0.05) * coloured(rng, v.shape), scan, {"frequency": STILL}


def coloured_grows(rng):
    scan = Scan(rng)
    v = scan.burst()
    noise = 0.01 * (1 + rng.uniform(2, 5) * scan.way) * coloured(rng, v.shape)
    return v + noise, scan, {"frequency": STILL, "wavenumber": STILL}


def hum_linear(rng):
    """A burst that leaves, over hum that stays."""
    scan = Scan(rng)
    hum = np.cos(2 * np.pi * scan.f * rng.uniform(0.5, 1.5) * scan.t + rng.uniform(0, 6))
    v = scan.burst() + rng.uniform(0.2, 0.6) * hum
    return noisy(rng, v), scan, {"frequency": STILL, "wavenumber": STILL}


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
    truth = {"frequency": STILL, "wavenumber": STILL, "towards": 1, "transfer": (None,), "lags": True}
    return noisy(rng, v, high=1e-3), array, truth


def two_modes(rng):
    """A slow wave falls behind a fast one, and all of it is recorded."""
    array = Array(rng, times=3600)
    v = np.zeros((array.times, array.sites))
    for size, whole, width, f in (
        (1, rng.uniform(0.2, 0.3), rng.uniform(8e-3, 0.012), rng.uniform(85, 100)),
        (rng.uniform(0.8, 1.3), rng.uniform(0.42, 0.57), rng.uniform(0.012, 0.018), rng.uniform(35, 45)),
    ):
        since = array.t - 0.25 - whole * array.x / array.x.max()
        v += size * np.exp(-0.5 * (since / width) ** 2) * np.cos(2 * np.pi * f * since)
    return noisy(rng, v), array, {"frequency": STILL, "transfer": (None,), "lags": True}


def fubini(sigma, count):
    """Amplitudes of harmonics of a wave that steepens, by order, before the shock at `sigma` = 1."""
    n = np.arange(1, count + 1)[:, None]
    return 2 * jv(n, n * sigma) / (n * sigma)


def steepening(rng):
    """Fubini's solution of Burgers' equation before the shock: harmonics grow, no energy is lost."""
    array = Array(rng, times=4096)
    f = rng.integers(8, 24) / (array.times * array.dt) * 8
    amplitudes = fubini(array.x[0] / array.x.max() * rng.uniform(0.75, 0.95) + 1e-9, 11)
    phase = 2 * np.pi * f * (array.t - array.x / rng.uniform(2.0, 5.0))
    v = sum(a * np.sin(n * phase) for n, a in enumerate(amplitudes, 1))
    truth = {"frequency": ("up",), "transfer": (True,), "energies": amplitudes**2}
    return noisy(rng, v, high=3e-3), array, truth


def steepening_box(rng):
    """The same in time, in a periodic box with a mean flow or none."""
    array = Array(rng, times=int(rng.integers(300, 600)))
    array.sites, waves = int(rng.integers(128, 300)), int(rng.integers(1, 7))
    array.dx, array.dt = 2 * np.pi / array.sites, rng.uniform(0.8, 0.95) / waves / array.times
    mean = float(rng.choice([0, rng.uniform(20, 80)]))
    t = np.arange(array.times) * array.dt
    amplitudes = fubini(waves * t + 1e-9, array.sites // 2 // waves)
    phase = waves * (np.arange(array.sites) * array.dx - mean * t[:, None])
    v = mean - sum((-1) ** n * a[:, None] * np.sin(n * phase) for n, a in enumerate(amplitudes, 1))
    truth = {"wavenumber": ("up",), "transfer": (True, None), "energies": amplitudes**2}
    return v, array, truth | {"options": ["--periodic"]}


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
    "harmonic grows and gives it back": beat,
    "harmonic grows and is absorbed": up_then_lost,
    "burst absorbed below its harmonic, uneven gains": gains_selective,
    "slow wave falls behind a fast one": two_modes,
    "wave steepens in a periodic box": steepening_box,
    "burst that decays in coloured noise": decay_coloured,
    "burst in coloured noise that grows": coloured_grows,
    "burst over hum": hum_linear,
}


def risen(energies, before, after):
    """The share that moved up from some rows to others, of energies by frequency and row."""
    shares = [energies[:, first : last + 1].sum(axis=1).cumsum() for first, last in (before, after)]
    return float(np.max(shares[0] / shares[0][-1] - shares[1] / shares[1][-1]))


def judged(part, name, make, count, tally):
    by = f"{count} fields: {name}"
    told = untold = false = 0
    wrong = []
    for number in range(count):
        values, axes, truth = make(part.rng)
        words = ["--only", "temporal,spatial,spacetime", *truth.get("options", [])]
        summary, _ = part.analyzed(values, *words, dt=axes.dt, dx=axes.dx)
        moved = summary["moved"]
        faults = []
        for axis in ("frequency", "wavenumber"):
            verdict = (moved[axis] or {}).get("verdict", "untold")
            if axis not in truth or verdict == "untold":
                untold += axis in truth
                continue
            told += 1
            late = truth.get("lags") and moved[axis]["lags"]
            if verdict not in truth[axis] and not late:
                faults.append(f"{axis} {verdict}")
        found = moved["frequency" if "frequency" in truth else "wavenumber"] or {}
        if found.get("verdict") in ("up", "down") and found["transfer"] not in truth.get(
            "transfer", (found["transfer"],)
        ):
            faults.append(f"transfer {found['transfer']}")
        if "fate" in truth and found.get("fate") not in (truth["fate"], None):
            faults.append(f"fate {found['fate']}")
        if "energies" in truth and found.get("verdict") == "up":
            rows = found["profile"]["rows"]
            profile = [risen(truth["energies"], rows[0], there) for there in rows]
            tally["shares"].append((max(profile), found["up"]))
            tally["shares"].append((profile[-1], found["at_end"]["up"]))
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
        by = "energies put in, of the same groups of sites or times: the most, and at the end"
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
    of_kinds(part, list(KINDS)[11:16])


def exceptions(part):
    """Verdicts of harmonics that come back, are lost, or only seem to grow"""
    of_kinds(part, list(KINDS)[16:])


#: Ratios of localized waves, and others whose front sheds energy and keeps its content.
LOCALIZED, SHEDDING = (1.0, 4.9272268, 14.6221002, 31.275671), (24.0, 20.0, 5.5, 10.0, 7.0)


def loss_of(run):
    """-100 d ln E / dj of 13 bodies about the largest velocity, over the second half of the bodies."""
    v, overlap = run["velocity"], -np.diff(run["displacement"], axis=1, append=0).clip(max=0)
    contact = 0.4 * run["contact_coefficient"] * overlap**2.5
    energy = 0.5 * (v**2 + contact)
    energy[:, 1:] += 0.5 * contact[:, :-1]
    body = np.abs(v).argmax(axis=1)
    kept = (body >= v.shape[1] // 2) & (body < v.shape[1] - 8)
    around = sliding_window_view(energy, 13, axis=1).sum(axis=-1)[kept, body[kept] - 6]
    return -100 * np.polyfit(body[kept], np.log(around), 1)[0]


def struck(part, ratio):
    """The run of a dimer of any length, and what is said of it."""
    sites, samples = part.rng.integers([150, 1024], [401, 4097]).tolist()
    scene = dict(sites=sites, stiffness_ratio=ratio, end_time="auto", samples=samples)
    run, _ = part.simulated(frame.scene_text(**scene))
    moved = part.estimate("analyze", part.folder / "run.npz")[0]["moved"]
    verdict = moved["frequency"]["verdict"]
    return run, moved["front"], verdict, f"{scene}: {verdict}, {moved['front']}"


def dimers(part):
    """Verdicts of localized, shedding and dispersive dimers"""
    where = "guide/report.md, What moved: struck chains"
    rounds, kept, shed, allowed, wrong = 1 if part.quick else 3, [], [], [], []
    for ratio in rounds * (LOCALIZED + SHEDDING):
        run, front, verdict, text = struck(part, ratio)
        if ratio in LOCALIZED:
            kept.append(front["loss_per_100_bodies"])
        else:
            shed.append((loss_of(run), front["loss_per_100_bodies"]))
            allowed.append(max(front["error"], 0.03 * shed[-1][0]))
        if verdict != "unchanged":
            wrong.append(text)
    what, by = "loss of localized dimers per 100 bodies", "ratios of localized waves"
    part.claim(what, np.zeros(len(kept)), kept, 2e-4, where=where, by=by)
    what = "loss of other dimers per 100 bodies, over its error or 3 %"
    by = "energy of 13 bodies about the largest velocity"
    part.claim(what, *np.transpose(shed), 1, where=where, by=by, scale=np.array(allowed))
    what = "dimers of 150 to 400 bodies whose front does not keep its content"
    by = "content that follows from the ratio alone"
    part.none_of(what, len(wrong), len(kept + shed), where=where, by=by)
    count, keeps = 4 * rounds, []
    for _ in range(count):
        _, _, verdict, text = struck(part, float(part.rng.uniform(2.0, 2.7)))
        if verdict == "unchanged":
            keeps.append(text)
    by = "ratios of 2 to 2.7, between localized waves"
    part.none_of("dispersive dimers whose front keeps its content", len(keeps), count, where=where, by=by)
    for text in wrong + keeps:
        part.note(text)


PARTS = [transfers, still, steady, exceptions, dimers]
