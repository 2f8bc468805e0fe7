# %% [markdown]
# # A first field
#
# A chain of balls is struck at one end, and the velocity of every ball is recorded. Where does the
# energy go: to which frequencies, which wavenumbers, and in which direction?

# %%
import matplotlib.pyplot as plt
import numpy as np

import wavecascade as wc

velocity = np.load("examples/data/lattice_impact.npy")  # (time, site)
spectra = wc.analyze(velocity, dt="0.25 s", dx="1 m")
print(dict(spectra.sizes))

# %% [markdown]
# The result is an `xarray.Dataset` with dimensions, coordinates and units. Energy is conserved on the
# way: the sum over each spectrum is that of the samples, to rounding.

# %%
for axis in ("time", "space", "spacetime"):
    print(
        f"Parseval residual, {axis}: {abs(spectra.attrs[f'parseval_{axis}']) < 1e-13 and 'below 1e-13'}"
    )

# %% [markdown]
# S(k, f) separates waves by frequency and wavenumber; for f > 0, k > 0 travels towards +x. The curve
# is where balls that touch without friction can oscillate, f = (1/pi) sqrt(c/m) |sin(k/2)|, here with
# c = m = 1.

# %%
power = spectra.spacetime_spectrum
decibels = 10 * np.log10(power / power.max())
fig, axes = plt.subplots(figsize=(7, 4))
decibels.clip(min=-70).plot(ax=axes, cmap="viridis", cbar_kwargs={"label": "S(k, f), dB re largest"})
k = power.wavenumber_signed
axes.plot(k, abs(np.sin(k / 2)) / np.pi, "w--", lw=1)
axes.set_title("Space-time spectrum of the struck chain", loc="left")
axes.set_ylim(0, 0.5)

# %% [markdown]
# The energy travels away from the end that was struck, towards +x, at almost all frequencies:

# %%
share = spectra.toward_plus_x_share
inside = (spectra.frequency > 0.01) & (spectra.frequency < 0.3)
print(f"share that travels towards +x, median over frequencies: {float(share[inside].median()):.2f}")

# %% [markdown]
# `wc.report(spectra, "out.html")` writes the interactive page that the program makes.
