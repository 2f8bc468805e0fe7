"""What drives chains, as functions of time: as `drive_waveform` defines them."""

import numpy as np

MASK = (1 << 64) - 1
LINES = 128


def uniform(seed):
    """Numbers in 0..1 by SplitMix64."""
    state = seed
    while True:
        state = (state + 0x9E3779B97F4A7C15) & MASK
        z = state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
        yield ((z ^ (z >> 31)) >> 11) * 2.0**-53


def burst(a, f, n):
    t_end = n / f
    return lambda t: a * np.sin(2 * np.pi * f * t) * np.sin(np.pi * f * t / n) ** 2 if t <= t_end else 0.0


def burst_rate(a, f, n):
    """Its derivative."""
    w, b, t_end = 2 * np.pi * f, 2 * np.pi * f / n, n / f
    parts = [(0.5 * a, w), (-0.25 * a, w + b), (-0.25 * a, w - b)]
    return lambda t: sum(c * w * np.cos(w * t) for c, w in parts) if t <= t_end else 0.0


def chirp(a, f0, f1, duration):
    return lambda t: a * np.sin(2 * np.pi * (f0 * t + (f1 - f0) * t * t / (2 * duration))) if t <= duration else 0.0


def noise(rms, low, high, seed):
    random = uniform(seed)
    pairs = [(next(random), next(random)) for _ in range(LINES)]
    f = np.array([low + (high - low) / LINES * (i + u) for i, (u, _) in enumerate(pairs)])
    phase = 2 * np.pi * np.array([p for _, p in pairs])
    return lambda t: rms * np.sqrt(2 / LINES) * np.sum(np.sin(2 * np.pi * f * t + phase))


def half_sine(a, duration):
    return lambda t: a * np.sin(np.pi * t / duration) if t <= duration else 0.0
