# %% [markdown]
# # A record of a fibre, by f-k
#
# A fibre along a road records strain rate at a channel every 2 m (distributed acoustic sensing).
# Surface waves of a passing train travel towards +x, those of a quarry towards -x, and a hum is
# everywhere at once. They overlap in time; in frequency and wavenumber they are apart.

# %%
import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

import wavecascade as wc

rng = np.random.default_rng(7)
t, x = 0.002 * np.arange(2000), 2.0 * np.arange(240)


def ricker(s, f):
    return (1 - 2 * (np.pi * f * s) ** 2) * np.exp(-((np.pi * f * s) ** 2))


strain_rate = 0.3 * rng.standard_normal((t.size, x.size))
strain_rate += ricker(t[:, None] - 0.4 - x / 450, 12)  # towards +x at 450 m/s
strain_rate += 0.8 * ricker(t[:, None] - 1.2 - (x[-1] - x) / 300, 9)  # towards -x at 300 m/s
strain_rate += 0.5 * np.sin(2 * np.pi * 50 * t)[:, None]  # the hum
record = xr.DataArray(
    strain_rate,
    {"time": ("time", t, {"units": "s"}), "distance": ("distance", x, {"units": "m"})},
    ("time", "distance"),
    "strain_rate",
    {"units": "1/s"},
)

# %% [markdown]
# A file of an interrogator opens the same way: `wc.open("record.h5")`, or SEG-Y. S(k, f) shows the
# three:

# %%
spectra = record.cascade.analyze(window_time="hann", window_space="hann", only="spacetime", maps=False)
power = spectra.spacetime_spectrum
fig, axes = plt.subplots(figsize=(7, 4))
decibels = (10 * np.log10(power / power.max())).clip(min=-50).sel(frequency=slice(0, 70))
decibels.sel(wavenumber_signed=slice(-0.6, 0.6)).plot(
    ax=axes, cmap="viridis", cbar_kwargs={"label": "S(k, f), dB re largest"}
)
axes.set(xlabel="wavenumber (rad/m)", ylabel="frequency (Hz)")
axes.set_title("Three sources, apart in (k, f)", loc="left")

# %% [markdown]
# The filter keeps what travels towards +x between 350 and 600 m/s:

# %%
train = wc.filter(record, towards="plus-x", speed=(350, 600), frequency=(2, 40), pad=True)
share = train.attrs["energy_after"] / train.attrs["energy_before"]
print(f"{100 * share:.1f} % of the energy pass; most is hum and noise")
fig, axes = plt.subplots(1, 2, figsize=(8, 3.6), sharey=True, layout="constrained")
for ax, (name, field) in zip(axes, {"recorded": record, "towards +x": train}.items(), strict=True):
    # Means of 8 x 3 samples, fine enough for a picture.
    shown = ax.imshow(
        field.coarsen({"time": 8, field.dims[1]: 3}).mean(),
        origin="lower",
        aspect="auto",
        cmap="RdBu_r",
        vmin=-1,
        vmax=1,
        extent=(0, float(x[-1]), 0, float(t[-1])),
        interpolation="none",
    )
    ax.set(xlabel="distance (m)")
    ax.set_title(name, loc="left")
axes[0].set_ylabel("time (s)")
fig.colorbar(shown, ax=axes, label="strain rate (1/s)", extend="both")

# %% [markdown]
# How fast? Ridges of S(k, f) above the noise have a phase velocity at each point, here of both sources at
# once: positive towards +x.

# %%
found = wc.ridges(record, segment=1000, cut="frequency")
for name, of in {"+x": found.phase_velocity > 0, "-x": found.phase_velocity < 0}.items():
    speed = found.phase_velocity.where(of & (abs(found.wavenumber) > 0.05)).median()
    print(f"towards {name}: {float(speed):.0f} m/s")
