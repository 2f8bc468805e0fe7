"""How often stated intervals hold the truth."""

import numpy as np
import scipy.signal
from documents import numbers

SPECTRA = "guide/spectra.md, What it was checked against"


def autoregressive(rng, times, sites, pole=0.6):
    """Noise with the density 2 / |1 - pole exp(-2 pi i f)|^2, and that density."""
    noise = rng.standard_normal((times + 200, sites))
    values = scipy.signal.lfilter([1], [1, -pole], noise, axis=0)[200:]
    return values, lambda f: 2 / np.abs(1 - pole * np.exp(-2j * np.pi * f)) ** 2


def of_spectra(part):
    """Coverage of intervals of spectra"""
    sites, times = (40, 2048) if part.quick else (160, 2048)
    # Bins between those that are judged, so that they are independent.
    methods = {
        "Welch, half overlap": (["--segment", 128], 3),
        "Welch, four fifths overlap": (["--segment", 128, "--overlap", 0.8], 3),
        "seven tapers": (["--multitaper", "4,7"], 17),
        "tapers in segments": (["--multitaper", "2.5,4", "--segment", 512, "--overlap", 0], 6),
        "periodogram": (["--periodogram"], 9),
    }
    sentence = "95 % intervals hold in # to # % of the cells, for tapers"
    stated = tuple(share / 100 for share in numbers(SPECTRA, sentence))
    for name, (words, every) in methods.items():
        values, density = autoregressive(part.rng, times, sites)
        _, found = part.estimate("spectrum", part.field(values), *words)
        f = found["frequency"]
        inside = slice(10, len(f) - 10, every)
        truth = density(f[inside])[:, None]
        held = (found["low"][inside] <= truth) & (truth <= found["high"][inside])
        what = f"95 % intervals of spectra: {name}"
        by = "density of the noise put in"
        part.covers(what, int(held.sum()), held.size, stated, where=SPECTRA, by=by)
        if "jackknife_low" in found and name != "periodogram":
            held = (found["jackknife_low"][inside] <= truth) & (truth <= found["jackknife_high"][inside])
            what = f"95 % intervals by the jackknife: {name}"
            part.covers(what, int(held.sum()), held.size, (0.936, 0.943), where=SPECTRA, by=by)
        if name == "seven tapers":
            level = scipy.stats.f.isf(0.05, 2, 12)
            above = found["f_statistic"][inside] > level
            what = "cells without a line whose F is above its level of 5 %"
            part.covers(
                what,
                int(above.sum()),
                above.size,
                (0.045, 0.052),
                where=SPECTRA,
                by="noise without lines",
            )
    white = part.rng.standard_normal((8192, 96))
    _, found = part.estimate("spectrum", part.field(white), "--along", "both", "--segment", 128)
    inside = np.s_[3:-3:3, 3:-3:4]
    truth = 2 / (2 * np.pi)
    held = (found["low"][inside] <= truth) & (truth <= found["high"][inside])
    what = "95 % intervals of S(k, f) of white noise"
    part.covers(
        what, int(held.sum()), held.size, (0.935, 0.965), where=SPECTRA, by="density of the noise put in"
    )


def of_noise(part):
    """Coverage of intervals of the noise of sites, and of records with gaps"""
    sites, times = 200, 4096
    where = "guide/gaps-and-noise.md, What it was checked against"
    motion = part.rng.standard_normal((times + 400, sites))
    motion = scipy.signal.filtfilt(*scipy.signal.butter(4, 0.15), motion, axis=0)[200:-200]
    motion /= motion.std()
    level = 0.02 * (1 + np.arange(sites) / 50)
    field = motion + level * part.rng.standard_normal((times, sites))
    summary, _ = part.estimate("spectrum", part.field(field), "--segment", 256, "--no-jackknife")
    found = summary["noise"]["sites"]
    truth = 2 * level**2
    held = [one["low"] <= n <= one["high"] for one, n in zip(found, truth, strict=True) if one]
    by = "the noise put in"
    part.covers("95 % intervals of the noise: flat top", sum(held), len(held), where=where, by=by)
    t = np.arange(times)[:, None] - 1200 - 4 * np.arange(sites)[None]
    field = np.exp(-((t / 20) ** 2)) * np.cos(0.3 * t) + level * part.rng.standard_normal((times, sites))
    summary, _ = part.estimate("spectrum", part.field(field), "--segment", 256, "--no-jackknife")
    found = summary["noise"]["sites"]
    held = [one["low"] <= n <= one["high"] for one, n in zip(found, truth, strict=True) if one]
    part.covers(
        "95 % intervals of the noise: before the arrival", sum(held), len(held), where=where, by=by
    )

    sites = 64
    values, density = autoregressive(part.rng, times, sites)
    for site in range(sites):
        for _ in range(part.rng.integers(1, 9)):
            start, length = part.rng.integers(0, times - 300), part.rng.integers(1, 250)
            values[start : start + length, site] = np.nan
    _, found = part.estimate("spectrum", part.field(values), "--segment", 128, "--gaps", "leave-out")
    inside = slice(4, -4, 3)
    truth = density(found["frequency"][inside])[:, None]
    held = (found["low"][inside] <= truth) & (truth <= found["high"][inside])
    what = "95 % intervals of spectra of records with one to eight gaps"
    part.covers(what, int(held.sum()), held.size, where=where, by="density of the noise put in")


def delayed(rng, times, delays, noise, width=0.15):
    """A broad-band source that each site repeats later, with noise of its own."""
    length = 2 * times
    f = np.fft.rfftfreq(length)
    source = np.fft.rfft(rng.standard_normal(length)) * np.exp(-0.5 * (f / width) ** 2)
    rows = [
        np.fft.irfft(source * np.exp(-2j * np.pi * f * d), length)[times // 2 : times // 2 + times]
        for d in delays
    ]
    values = np.stack(rows, axis=1)
    values /= values.std()
    return values + noise * rng.standard_normal(values.shape)


def between_sites(part):
    """Coverage of delays, velocities and levels between sites"""
    count = 20 if part.quick else 100
    where = "guide/coherence.md, What it was checked against"
    delays, velocities = [], []
    for _ in range(count):
        step = part.rng.uniform(0.5, 3)
        field = delayed(part.rng, 4096, step * np.arange(8), part.rng.uniform(0.3, 1.5))
        summary, found = part.estimate("coherence", part.field(field), "--segment", 256)
        delays.append(abs(found["delay"][3] - 3 * step) <= found["delay_interval"][3])
        velocity = summary["velocity"]
        if velocity is not None and not velocity["is_dispersive"]:
            velocities.append(
                min(velocity["low"], velocity["high"])
                <= 1 / step
                <= max(velocity["low"], velocity["high"])
            )
    by = "the delay put in"
    part.covers("95 % intervals of delays", sum(delays), len(delays), (0.91, 0.99), where=where, by=by)
    what = "95 % intervals of velocities"
    part.covers(what, sum(velocities), len(velocities), (0.91, 0.99), where=where, by=by)

    noise = part.rng.standard_normal((8192, 60))
    summary, found = part.estimate("coherence", part.field(noise), "--segment", 256)
    above = found["coherence"][4:-4:4, 1:] > summary["level"]
    what = "cells without a common part above the level of coherence of 5 %"
    part.covers(what, int(above.sum()), above.size, 0.05, where=where, by="independent noise")
    # One pair of sites is coherent by chance in one of twenty records.
    coherent = summary["is_coherent"]
    what = "sites of noise that are said to follow the reference"
    part.within(what, sum(coherent) - 1, 0, 4, where=where, by="independent noise, 5 % of fields")

    where = "guide/bicoherence.md, What it was checked against"
    records, cells, maps = (40 if part.quick else 200), [0, 0], 0
    for number in range(records):
        # 96 segments, as in the guide.
        noise = part.rng.standard_normal((32 * 97, 2))
        words = ["--site", number % 2, "--segment", 64, "--every", 0]
        summary, found = part.estimate("bicoherence", part.field(noise), *words)
        maps += bool((found["bicoherence"] > summary["map_level"]).any())
        # One cell of each, since cells share frequencies.
        one = found["bicoherence"][part.rng.integers(0, len(found["bicoherence"]), 3)]
        cells[0] += int((one > summary["cell_level"]).sum())
        cells[1] += len(one)
    what = "cells without coupling above the level of bicoherence of 5 %"
    sentence = "above the level of 5 %, three overlaps | # to # % |"
    stated = tuple(share / 100 for share in numbers("accuracy.md", sentence))
    part.covers(what, *cells, stated, where=where, by="Gaussian noise")
    what = "fields without coupling with any cell above the level of the map"
    part.covers(what, maps, records, (0.048, 0.06), where=where, by="Gaussian noise")


def of_modes(part):
    """Coverage of eigenvalues of modes"""
    times, sites = (8192, 24) if part.quick else (32768, 24)
    x = np.arange(sites)
    shapes = [np.sin(np.pi * (n + 1) * (x + 0.5) / sites) for n in range(2)]
    powers = [9.0, 0.5]
    field = sum(
        np.sqrt(p) * part.rng.standard_normal((times, 1)) * s for p, s in zip(powers, shapes, strict=True)
    )
    _, found = part.estimate("modes", part.field(field), "--segment", 64)
    inside = slice(2, 30, 3)
    for n, (power, shape) in enumerate(zip(powers, shapes, strict=True)):
        truth = 2 * power * (shape**2).sum()
        low, high = (found["eigenvalues"][inside, n] * found["interval"][inside, end] for end in (0, 1))
        if n == 0:
            held = (low <= truth) & (truth <= high)
        else:
            held = np.append(held, (low <= truth) & (truth <= high))
    where = "guide/modes.md, What it was checked against"
    part.covers(
        "95 % intervals of eigenvalues",
        int(held.sum()),
        held.size,
        where=where,
        by="powers of two sources",
    )


def of_dispersion(part):
    """Coverage of fitted velocities and slopes"""
    count = 15 if part.quick else 60
    held = []
    for _ in range(count):
        c = part.rng.uniform(0.2, 0.35)
        field = delayed(part.rng, 4096, np.arange(32) / c, 1 / 3, 0.03)
        summary, _ = part.estimate("ridges", part.field(field), "--fit", f"c*abs(k); c={0.9 * c}")
        if summary["fits"]:
            one = summary["fits"][0]["parameters"][0]
            held.append(abs(one["value"] - c * 1.0) <= 1.96 * one["error"])
    where = "guide/ridges.md, When it lies"
    what = "95 % intervals of fitted velocities, a wave three times the noise"
    part.covers(what, sum(held), len(held), (0.93, 1.0), where=where, by="the velocity put in")

    held = []
    for _ in range(count):
        power = part.rng.uniform(-3, 0)
        paths = []
        for shot in range(8):
            f = np.fft.rfftfreq(4096)
            f[0] = f[1]
            shape = np.fft.rfft(part.rng.standard_normal((4096, 4)), axis=0) * f[:, None] ** (power / 2)
            paths.append(part.field(np.fft.irfft(shape, 4096, axis=0), name=f"shot{shot}"))
        words = ["--along", "time", "--band", "0.02:0.3", "--segment", 512]
        summary, _ = part.estimate("slope", *paths, *words)
        law = summary["law"]
        held.append(abs(law["slope"] - power) <= law["half"])
    what = "95 % intervals of slopes over eight shots"
    part.covers(what, sum(held), len(held), where="guide/slopes.md", by="the power put in")


def of_increments(part):
    """Coverage of structure functions"""
    count = 25 if part.quick else 100
    held = []
    for _ in range(count):
        # Along time a walk, of which all sites are independent.
        field = np.cumsum(part.rng.standard_normal((4096, 4)), axis=0)
        _, found = part.estimate("increments", part.field(field), "--lags", "1,4")
        for row, lag in enumerate((1, 4)):
            for order, moment in ((2, 1.0), (4, 3.0)):
                truth = moment * lag ** (order / 2)
                held.append(
                    abs(found["time_structure"][row, order - 1] - truth)
                    <= found["time_structure_half"][row, order - 1]
                )
    where = "guide/increments.md, What it was checked against"
    # The four of a record are of the same samples: their number counts once.
    total, number = sum(held), count
    what = "95 % intervals of structure functions of random walks"
    part.covers(what, round(total / 4), number, where=where, by="moments of the normal distribution")


PARTS = [of_spectra, of_noise, between_sites, of_modes, of_dispersion, of_increments]
