"""Spectra and estimates against NumPy, SciPy and 80-bit arithmetic, on random fields."""

import math

import mpmath
import numpy as np
import scipy.fft
import scipy.interpolate
import scipy.signal
from documents import number
from scipy.signal.windows import dpss

ACCURACY = "accuracy.md, Spectra"
ROBUST = "robustness.md, What the tests do"
GUIDE = "guide/spectra.md"


def of_the_peak():
    return number(ACCURACY, "three independent fields, `f64` | # of the peak |")


def random_field(rng, times, sites):
    """A wave, a resonance and noise, of random sizes."""
    noise = rng.standard_normal((times, sites))
    pole = rng.uniform(0.8, 0.97) * np.exp(2j * np.pi * rng.uniform(0.05, 0.3))
    field = scipy.signal.lfilter([1], [1, -2 * pole.real, abs(pole) ** 2], noise, axis=0)
    t, x = np.arange(times)[:, None], np.arange(sites)[None]
    wave = np.cos(2 * np.pi * (rng.uniform(-0.4, 0.4) * x - rng.uniform(0.05, 0.4) * t))
    return field * rng.uniform(0.1, 10) + wave * rng.uniform(0.1, 10)


def folded(length):
    """Weights of one-sided bins."""
    weight = np.full(length // 2 + 1, 2.0)
    weight[0] = 1
    if length % 2 == 0:
        weight[-1] = 1
    return weight


def spectra_of(field, dt, dx):
    """S(f, x), S(k, t), S(k, f) as densities, in 80-bit arithmetic; k ascending, positive towards +x."""
    wide = field.astype(np.longdouble)
    times, sites = field.shape
    along_t, along_x = scipy.fft.rfft(wide, axis=0), scipy.fft.rfft(wide, axis=1)
    temporal = np.abs(along_t) ** 2 * folded(times)[:, None] * dt / times
    spatial = np.abs(along_x) ** 2 * folded(sites)[None] * dx / (2 * np.pi * sites)
    # exp(+ikx): the conjugate of the usual kernel.
    both = np.conj(scipy.fft.fft(np.conj(along_t), axis=1))
    both = np.abs(both) ** 2 * folded(times)[:, None] * dt * dx / (2 * np.pi * times * sites)
    # From -Nyquist up; of an even number, Nyquist is on the side that `fftshift` does not put it.
    return temporal, spatial, np.fft.fftshift(both, axes=1)


def whole_fields(part):
    """Spectra of whole fields"""
    shapes = (
        [(768, 40), (625, 33), (1001, 24)]
        if part.quick
        else [(4096, 60), (3125, 47), (2003, 32), (1155, 96)]
    )
    worst, single, parseval, sums = [0.0] * 3, 0.0, [], 0.0
    for times, sites in shapes:
        field = random_field(part.rng, times, sites)
        dt, dx = part.rng.uniform(1e-5, 1e-2), part.rng.uniform(1e-3, 1)
        path = part.field(field, dt, dx)
        truths = spectra_of(field, dt, dx)
        summary, found = part.estimate("analyze", path, "--scaling", "density")
        for i, name in enumerate(("temporal_spectrum", "spatial_spectrum", "spacetime_spectrum")):
            apart = np.abs(found[name] - truths[i]).max() / truths[i].max()
            if name == "spacetime_spectrum" and sites % 2 == 0:
                # Nyquist's wavenumber may stand at either end.
                rolled = np.roll(truths[i], -1, axis=1)
                apart = min(apart, np.abs(found[name] - rolled).max() / truths[i].max())
            worst[i] = max(worst[i], float(apart))
        parseval += [abs(value) for value in summary["parseval"].values() if value is not None]
        df = 1 / (times * dt)
        mean_square = math.fsum((field**2).mean(axis=1)) / times
        total = math.fsum(found["temporal_spectrum"].mean(axis=1)) * df
        sums = max(sums, abs(total / mean_square - 1))
        _, rough = part.estimate("analyze", path, "--scaling", "density", "--precision", "f32")
        apart = np.abs(rough["temporal_spectrum"] - truths[0]).max() / truths[0].max()
        single = max(single, float(apart))
    by = "SciPy's transforms in 80-bit arithmetic"
    for name, apart in zip(("S(f, x)", "S(k, t)", "S(k, f)"), worst, strict=True):
        what = f"{name} of {len(shapes)} random fields, of the peak"
        part.claim(what, 0.0, apart, of_the_peak(), where=ACCURACY, by=by)
    stated = number(ACCURACY, "the same in `f32` | # of the peak |")
    part.claim("S(f, x) with --precision f32, of the peak", 0.0, single, stated, where=ACCURACY, by=by)
    stated = number(ACCURACY, "Parseval's identity, all lengths tested | # |")
    what = "Parseval's identity: what the program states"
    part.claim(what, 0.0, max(parseval), stated, where=ACCURACY, by="mean square of the samples")
    what = "Parseval's identity: the sum over S(f, x) of its arrays"
    part.claim(what, 0.0, sums, stated, where=ACCURACY, by="mean square of the samples, exactly summed")


def small_fields(part):
    """Spectra of small random fields by direct sums"""
    count, worst = 6 if part.quick else 30, 0.0
    for _ in range(count):
        times, sites = part.rng.integers(8, 400), part.rng.integers(2, 9)
        field = part.rng.standard_normal((times, sites)) * 10.0 ** part.rng.uniform(-3, 3)
        bins = np.arange(times // 2 + 1)
        turn = np.longdouble(2) * np.arctan2(np.longdouble(0), np.longdouble(-1))
        angle = turn * (bins[:, None] * np.arange(times)[None] % times).astype(np.longdouble) / times
        sums = (np.cos(angle) - 1j * np.sin(angle)) @ field.astype(np.longdouble)
        truth = np.abs(sums) ** 2 * folded(times)[:, None] / times
        _, found = part.analyzed(field, "--scaling", "density", "--only", "temporal")
        worst = max(worst, float(np.abs(found["temporal_spectrum"] - truth).max() / truth.max()))
    by = "direct sums in 80-bit arithmetic"
    part.claim(f"spectra of {count} random fields, of the peak", 0.0, worst, 2e-15, where=ROBUST, by=by)


def range_of_numbers(part):
    """Large means and extreme amplitudes"""
    field = part.rng.standard_normal((1500, 8))
    stored = field + 1e9
    wide = stored.astype(np.longdouble)
    line = np.abs(scipy.fft.rfft(wide - wide.mean(axis=0), axis=0)) ** 2 * folded(1500)[:, None] / 1500
    _, found = part.analyzed(stored, "--scaling", "density", "--only", "temporal")
    apart = np.abs(found["temporal_spectrum"] - line)[1:].max() / line[1:].max()
    what = "an offset of a billion times the signal costs no digits (f > 0, of the peak)"
    part.claim(
        what,
        0.0,
        float(apart),
        of_the_peak(),
        where=ACCURACY,
        by="80-bit arithmetic on the stored samples",
    )
    for power in (-1040, 1020):
        scaled = np.ldexp(field / np.abs(field).max(), power)
        exact = np.ldexp(scaled.astype(np.longdouble), -power)
        truth = np.abs(scipy.fft.rfft(exact, axis=0)) ** 2 * folded(1500)[:, None]
        summary, found = part.analyzed(scaled, "--scaling", "density", "--only", "temporal")
        shape = found["temporal_spectrum"].astype(np.longdouble)
        apart = np.abs(shape / shape.max() - truth / truth.max()).max()
        what = f"spectra of amplitudes near 2^{power}, of the peak"
        part.claim(what, 0.0, float(apart), of_the_peak(), where=ACCURACY, by="80-bit arithmetic")
        states = any(warning["code"] == "unrepresentable" for warning in summary["warnings"])
        part.same("their unit is stated by a warning", True, states, where=ACCURACY, by="the summary")


def resampled(part):
    """Resampled, filtered and converted fields"""
    times, sites = 1000, 12
    t = np.arange(times) + part.rng.uniform(-0.4, 0.4, times)
    values = part.rng.standard_normal((times, sites))
    source = part.folder / "uneven.npz"
    np.savez(source, time=t, position=np.arange(sites, dtype=float), velocity=values)
    even = t[0] + np.arange(times) * (t[-1] - t[0]) / (times - 1)
    cubic = scipy.interpolate.CubicSpline(t, values, axis=0)
    truths = {
        "linear": scipy.interpolate.interp1d(t, values, axis=0, fill_value="extrapolate")(even),
        "cubic": cubic(even),
    }
    # What one rounding of a time changes.
    steepest = np.maximum(
        np.abs(cubic(even, 1)).max(), np.abs(np.diff(values, axis=0) / np.diff(t)[:, None]).max()
    )
    rounding = np.maximum(3e-15, np.finfo(float).eps * np.abs(even)[:, None] * steepest)
    for method, truth in truths.items():
        out = part.folder / f"{method}.npz"
        part.run(
            "convert", source, out, "--resample", f"time={method}", "--variable", "velocity", "--force"
        )
        with np.load(out) as stored:
            found = stored["velocity"]
        by = "SciPy's CubicSpline" if method == "cubic" else "SciPy's interp1d"
        what = f"{method} resampling of {times} samples, over 3e-15 or one rounding of the time"
        part.claim(what, truth, found, 1.0, where=ACCURACY, by=by, scale=rounding)

    field = random_field(part.rng, 1024, 64)
    path = part.field(field)
    edge = part.rng.uniform(0.1, 0.4)
    total = np.zeros_like(field)
    for band in (f"0:{edge}", f"{edge}:"):
        out = part.folder / "band.npz"
        part.run("filter", path, "--frequency", band, "--out", out, "--force", "--quiet")
        with np.load(out) as stored:
            total += next(stored[name] for name in stored if stored[name].shape == field.shape)
    what = "sum of complementary filtered parts, of the largest sample"
    stated = number(
        ACCURACY, "sum of complementary filtered parts against the field | # of its largest sample"
    )
    part.claim(what, field, total, stated, where=ACCURACY, by="the field", scale=np.abs(field).max())

    out = part.folder / "round.nc"
    part.run("convert", path, out, "--force")
    part.run("convert", out, part.folder / "back.npz", "--force")
    with np.load(part.folder / "back.npz") as stored:
        back = next(stored[name] for name in stored if stored[name].shape == field.shape)
    what = "a field through NetCDF and back has the same bits"
    part.same(what, True, bool(np.array_equal(back, field)), where="guide/formats.md", by="the field")


def segments_of(records, length, hop):
    """(segment, time, site), means removed."""
    starts = range(0, len(records) - length + 1, hop)
    parts = np.stack([records[start : start + length] for start in starts])
    return parts - parts.mean(axis=1, keepdims=True)


def adaptive(eigenspectra, ratios, variance, dt):
    """Thomson's adaptive weights, iterated to their end. `variance`: mean square of the tapered samples,
    tapers weighted by the squares of their concentrations."""
    ratios = ratios[:, None, None]
    spectrum = eigenspectra[:2].mean(axis=0)
    floor = 2 * dt * variance
    for _ in range(2000):
        weight = ratios / (ratios * spectrum + (1 - ratios) * floor) ** 2
        new = (weight * eigenspectra).sum(axis=0) / weight.sum(axis=0)
        done = np.abs(new / spectrum - 1).max() < 1e-14
        spectrum = new
        if done:
            break
    return spectrum, weight


def averages(part):
    """Averaged spectra with intervals"""
    times, sites = 2048, 5
    field = random_field(part.rng, times, sites)
    dt = 1e-3
    path = part.field(field, dt, 0.01)
    segment = 256
    _, found = part.estimate("spectrum", path, "--segment", segment)
    _, truth = scipy.signal.welch(field, 1 / dt, "hann", segment, detrend="constant", axis=0)
    what = "Welch's method, of the peak"
    part.claim(
        what, truth, found["spectrum"], 1e-13, where=GUIDE, by="scipy.signal.welch", scale=truth.max()
    )
    _, plain = part.estimate("spectrum", path, "--periodogram")
    _, truth = scipy.signal.periodogram(field, 1 / dt, detrend="constant", axis=0)
    what = "periodogram, of the peak"
    by = "scipy.signal.periodogram"
    part.claim(what, truth, plain["spectrum"], 1e-13, where=GUIDE, by=by, scale=truth.max())

    # Quantiles by the incomplete gamma function at 40 digits.
    mpmath.mp.dps = 40
    worst = 0.0
    for column, row in ((1, 40), (3, 90)):
        nu = mpmath.mpf(float(found["degrees_of_freedom"][row, column]))
        for name, level in (("low", 0.975), ("high", 0.025)):
            guess = float(scipy.stats.chi2.ppf(level, float(nu)))
            quantile = mpmath.findroot(
                lambda q, nu=nu, level=level: (
                    mpmath.gammainc(nu / 2, 0, q / 2, regularized=True) - mpmath.mpf(str(level))
                ),
                guess,
            )
            exact = mpmath.mpf(float(found["spectrum"][row, column])) * nu / quantile
            worst = max(worst, float(abs(mpmath.mpf(float(found[name][row, column])) / exact - 1)))
    what = "ends of chi-square intervals, relative"
    stated = number(ACCURACY, "Fisher's distributions against mpmath | # |")
    part.claim(what, 0.0, worst, stated, where=ACCURACY, by="mpmath, 40 digits")

    nw, k = 4, 7
    centred = field - field.mean(axis=0)
    tapers, ratios = dpss(times, nw, k, return_ratios=True)
    transforms = scipy.fft.rfft(tapers[:, :, None] * centred[None], axis=1)
    each = np.abs(transforms) ** 2 * folded(times)[None, :, None] * dt
    squares = ((tapers[:, :, None] * centred[None]) ** 2).sum(axis=1)
    variance = (ratios[:, None] ** 2 * squares).sum(axis=0)[None] / (ratios**2).sum()
    truth, weight = adaptive(2 * dt * np.abs(transforms) ** 2, ratios, variance, dt)
    degrees = 2 * weight.sum(axis=0) ** 2 / (weight**2).sum(axis=0)
    _, found = part.estimate("spectrum", path, "--multitaper", f"{nw},{k}")
    inner = slice(1, -1)
    apart = np.abs(found["spectrum"][inner] / truth[inner] - 1).max()
    by = "the same equations in NumPy, tapers of SciPy"
    part.claim(
        "multitaper spectra with adaptive weights, relative", 0.0, apart, 1e-10, where=ACCURACY, by=by
    )
    apart = np.abs(found["degrees_of_freedom"][inner] / degrees[inner] - 1).max()
    part.claim("their degrees of freedom, relative", 0.0, apart, 1e-10, where=ACCURACY, by=by)
    dc = tapers.sum(axis=1)[:, None, None]
    mean = (dc * transforms).sum(axis=0) / (dc**2).sum()
    rest = (np.abs(transforms - mean * dc) ** 2).sum(axis=0)
    f_values = (k - 1) * np.abs(mean) ** 2 * (dc**2).sum() / rest
    apart = np.abs(found["f_statistic"][inner] / f_values[inner] - 1).max()
    part.claim("F of the test for lines, relative", 0.0, apart, 1e-10, where=ACCURACY, by=by)
    _, found = part.estimate("spectrum", path, "--multitaper", f"{nw},{k}", "--equal-weights")
    truth = each.mean(axis=0)
    what = "multitaper spectra with equal weights, of the peak"
    by = "tapers of SciPy"
    part.claim(what, truth, found["spectrum"], 1e-10, where=ACCURACY, by=by, scale=truth.max())


def both_axes(part):
    """Averaged S(k, f)"""
    times, sites, segment = 1024, 32, 128
    field = random_field(part.rng, times, sites)
    dt, dx = 1e-3, 0.01
    path = part.field(field, dt, dx)
    _, found = part.estimate("spectrum", path, "--along", "both", "--segment", segment)
    windows = scipy.signal.get_window("hann", segment), scipy.signal.get_window("hann", sites)
    taper = np.multiply.outer(*(w / np.sqrt((w**2).sum()) for w in windows))
    pieces = segments_of(field, segment, segment // 2) * taper
    transform = np.conj(scipy.fft.fft(np.conj(scipy.fft.rfft(pieces, axis=1)), axis=2))
    power = (np.abs(transform) ** 2).mean(axis=0) * dt * dx / (2 * np.pi) * folded(segment)[:, None]
    k = 2 * np.pi * np.fft.fftfreq(sites, dx)
    # exp(+ikx) puts +k where the usual kernel has -k.
    where = {round(float(value), 6): i for i, value in enumerate(k)}
    order = [
        where.get(round(float(value), 6), where.get(round(-float(value), 6)))
        for value in found["wavenumber"]
    ]
    truth = power[:, order]
    what = "S(k, f) in segments under Hann's windows, of the peak"
    by = "NumPy's transforms, SciPy's windows"
    part.claim(what, truth, found["spectrum"], 2e-13, where=ACCURACY, by=by, scale=truth.max())


def between_sites(part):
    """Coherence, bicoherence and modes"""
    times, sites, segment = 4096, 6, 256
    field = random_field(part.rng, times, sites)
    dt, dx = 1e-3, 0.01
    path = part.field(field, dt, dx)
    options = dict(fs=1 / dt, window="hann", nperseg=segment, detrend="constant", axis=0)
    _, truth = scipy.signal.coherence(field[:, :1], field, **options)
    _, found = part.estimate("coherence", path, "--reference", 0, "--segment", segment)
    where = "guide/coherence.md"
    inner = slice(1, -1)
    what = "coherence with a reference"
    part.claim(
        what, truth[inner], found["coherence"][inner], 2e-14, where=where, by="scipy.signal.coherence"
    )
    _, cross = scipy.signal.csd(field[:, :1], field, **options)
    # Phases matter where there is something to have one.
    strong = np.where(truth > 0.05, np.angle(np.exp(1j * (np.angle(cross) - found["phase"]))), 0)[inner]
    part.claim(
        "its phase (rad), where γ² > 0.05",
        0.0,
        np.abs(strong).max(),
        2e-13,
        where=where,
        by="scipy.signal.csd",
    )

    _, found = part.estimate("bicoherence", path, "--site", 2, "--segment", segment, "--every", 0)
    window = scipy.signal.get_window("hann", segment)
    pieces = segments_of(field[:, 2:3], segment, segment // 2)[:, :, 0] * window
    x = scipy.fft.rfft(pieces, axis=1)
    bins = [np.rint(found[name] * segment * dt).astype(int) for name in ("first", "second", "third")]
    a, b, c = (x[:, index] for index in bins)
    triple = (a * b * c.conj()).mean(axis=0)
    truth = np.abs(triple) ** 2 / ((np.abs(a * b) ** 2).mean(axis=0) * (np.abs(c) ** 2).mean(axis=0))
    by, where = "direct products in NumPy", ACCURACY
    part.claim(
        f"bicoherence of {len(truth)} triples", truth, found["bicoherence"], 1e-14, where=where, by=by
    )
    what = "largest bicoherence is at most 1"
    part.within(
        what,
        float(found["bicoherence"].max()),
        0,
        1 + 1e-15,
        where="guide/bicoherence.md",
        by="Cauchy and Schwarz",
    )

    _, found = part.estimate("modes", path, "--segment", segment)
    pieces = segments_of(field, segment, segment // 2) * window[None, :, None]
    scale = np.sqrt(2 * dt / (window**2).sum() * dx / len(pieces))
    x = scipy.fft.rfft(pieces, axis=1) * scale
    truth = np.stack([np.linalg.svd(x[:, i], compute_uv=False) ** 2 for i in range(x.shape[1])])
    inner = slice(1, segment // 2)
    found, truth = found["eigenvalues"][inner, : truth.shape[1]], truth[inner]
    what = "eigenvalues of modes, of the largest"
    part.claim(
        what, truth, found, 2e-15, where="guide/modes.md", by="numpy.linalg.svd", scale=truth.max()
    )


def of_gaps(part):
    """Gaps and increments"""
    times, sites, segment, dt = 4096, 4, 256, 1e-3
    field = random_field(part.rng, times, sites)
    for site in range(1, sites):
        start, length = part.rng.integers(0, times - 800), part.rng.integers(1, 700)
        field[start : start + length, site] = np.nan
    path = part.field(field, dt, 0.01)
    _, found = part.estimate("spectrum", path, "--segment", segment, "--gaps", "leave-out")
    window = scipy.signal.get_window("hann", segment)
    window /= np.sqrt((window**2).sum())
    starts = np.arange(0, times - segment + 1, segment // 2)
    worst = effective = 0.0
    for site in range(sites):
        record = field[:, site]
        left = [start for start in starts if np.isfinite(record[start : start + segment]).all()]
        pieces = np.stack([record[start : start + segment] for start in left])
        pieces = (pieces - pieces.mean(axis=1, keepdims=True)) * window
        power = (np.abs(scipy.fft.rfft(pieces, axis=1)) ** 2).mean(axis=0) * dt * folded(segment)
        worst = max(worst, np.abs(found["spectrum"][:, site] - power).max() / power.max())
        placed = np.zeros((len(left), times))
        for row, start in zip(placed, left, strict=True):
            row[start : start + segment] = window
        number = len(left) ** 2 / ((placed @ placed.T) ** 2).sum()
        effective = max(effective, abs(found["effective_realisations"][site] / number - 1))
    by = "SciPy on segments picked by hand"
    part.claim("spectra of records with gaps, of the peak", 0.0, worst, 1e-9, where=ACCURACY, by=by)
    what = "their effective number of segments, relative"
    part.claim(
        what, 0.0, effective, 1e-9, where="guide/gaps-and-noise.md", by="Welch's sum over all pairs"
    )

    walk = np.cumsum(part.rng.standard_normal((3000, 10)), axis=0)
    lags = [1, 3, 10, 40]
    words = ["--lags", ",".join(map(str, lags))]
    _, found = part.estimate("increments", part.field(walk, 1.0, 1.0), *words)
    worst = 0.0
    for row, lag in enumerate(lags):
        d = (walk[lag:] - walk[:-lag]).astype(np.longdouble)
        truth = [np.mean(np.abs(d) ** p) for p in range(1, 7)]
        worst = max(worst, float(np.abs(found["time_structure"][row] / truth - 1).max()))
    what = "structure functions of orders 1 to 6, relative"
    part.claim(what, 0.0, worst, 3e-15, where="guide/increments.md", by="means in 80-bit arithmetic")


def same_bits(part):
    """The same bits by any division of the work"""
    field = random_field(part.rng, 3000 if part.quick else 20000, 64)
    path = part.field(field)
    where = "accuracy.md, Reproducibility"
    base = None
    for words in (
        ["--threads", 1],
        ["--threads", 2],
        ["--threads", 3],
        ["--threads", 2, "--memory", "64MB"],
    ):
        _, found = part.estimate("analyze", path, *words, threads=None)
        if base is None:
            base = found
            continue
        equal = all(np.array_equal(base[name], found[name], equal_nan=True) for name in base)
        words = " ".join(map(str, words))
        part.same(
            f"analyze {words}: bits of all arrays", True, equal, where=where, by="analyze --threads 1"
        )
    whole = part.estimate("spectrum", path, "--segment", 256, "--no-jackknife")[1]
    count = int(part.rng.integers(2, 6))
    pieces = []
    for i in range(1, count + 1):
        out = part.folder / f"part-{i}"
        part.run(
            "spectrum",
            path,
            "--segment",
            256,
            "--no-jackknife",
            "--part",
            f"{i}/{count}",
            "--out",
            out,
            "--force",
        )
        pieces.append(out)
    words = ["spectrum", "--merge", *pieces]
    out = part.folder / "merged"
    part.run(*words, "--out", out, "--figures", "none", "--force", "--quiet")
    with np.load(out / "spectrum.npz") as stored:
        equal = np.allclose(stored["spectrum"], whole["spectrum"], rtol=1e-12, atol=0)
    what = f"spectra in {count} parts, merged, to 1e-12"
    part.same(what, True, bool(equal), where="accuracy.md, Spectra", by="the whole run")


PARTS = [
    whole_fields,
    small_fields,
    range_of_numbers,
    resampled,
    averages,
    both_axes,
    between_sites,
    of_gaps,
    same_bits,
]
