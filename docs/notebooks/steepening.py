# %% [markdown]
# # A wave that steepens, and its slope
#
# A sine in a medium whose speed of sound grows with the velocity steepens: v_t + v v_x = 0. Crests
# overtake troughs at the time 1 / max(-dv/dx), here 1. Energy goes to ever higher wavenumbers, and
# the spectrum becomes a power law: k^(-8/3) at that time, k^-2 once there is a shock.

# %%
import json

import matplotlib.pyplot as plt
import numpy as np

import wavecascade as wc

sites = 1024
x = 2 * np.pi * np.arange(sites) / sites
times = np.linspace(0, 0.995, 200)


def wave(t):
    """v = sin(x - v t), by Newton's method from v = sin(x)."""
    v = np.sin(x)
    for _ in range(200):
        step = (v - np.sin(x - v * t)) / (1 + t * np.cos(x - v * t))
        v = v - np.clip(step, -0.1, 0.1)
    return v


velocity = np.array([wave(t) for t in times])
fig, axes = plt.subplots(figsize=(7, 3.2))
for i in (0, 100, 199):
    axes.plot(x, velocity[i], label=f"t = {times[i]:.2f}")
axes.set(xlabel="position x", ylabel="velocity v")
axes.set_title("A sine that steepens", loc="left")
axes.legend()

# %% [markdown]
# `wc.slope` fits a power law to the spectrum over a band, and along x to that of frames of the
# record. The positions lie around a ring, so no window is wanted.

# %%
found = wc.slope(
    velocity,
    dt=times[1] - times[0],
    dx=x[1] - x[0],
    layout="time-site",
    band=(4, 40),
    breaks=0,
    frames=20,
    window="none",
)
slopes = found.frame_slope
for at in (0.6, 0.8, 1.0):
    one = slopes.sel(frame_time=at, method="nearest")
    print(f"slope at t = {float(one.frame_time):.2f}: {float(one):.1f}")

# %%
fig, axes = plt.subplots(figsize=(7, 3.2))
axes.errorbar(found.frame_time, slopes, found.frame_slope_half, fmt="o", ms=4, label="fitted")
axes.axhline(-8 / 3, color="k", ls="--", lw=1, label="-8/3, at the shock time")
axes.set(xlabel="time", ylabel="slope of ln S over ln k", xlim=(0.55, 1), ylim=(-14, 0))
axes.set_title("The spectrum becomes a power law", loc="left")
axes.legend()

# %% [markdown]
# The largest gradient tells when the shock comes, from data before it: its inverse falls to 0 there.

# %%
steepening = json.loads(found.attrs["steepening"])
print(f"shock time: {steepening['shock_time']:.3f}")
