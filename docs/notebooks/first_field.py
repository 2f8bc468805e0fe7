# %% [markdown]
# # A first field
#
# A chain of bodies is struck at one end, and the velocity of every body is recorded. Where does the
# energy go: to which frequencies, which wavenumbers, and in which direction?

# %%
import matplotlib.pyplot as plt
import numpy as np

import wavecascade as wc

field = wc.open("examples/data/lattice_impact.npy")
print(field.dims, field.shape, field.attrs["quantity"])

# %% [markdown]
# `wc.open` reads whatever `cascade analyze` reads, with what stands beside the file: steps, units, and
# here the dispersion relation of the chain. Arrays of NumPy do as well:
# `wc.analyze(array, dt=0.125, dx=1.0)`.

# %%
spectra = wc.analyze("examples/data/lattice_impact.npy")
for name in ("temporal_spectrum", "spatial_spectrum", "spacetime_spectrum"):
    print(name, spectra[name].dims, spectra[name].shape)

# %% [markdown]
# The result is an `xarray.Dataset` with dimensions, coordinates and units. Energy is conserved on the
# way: the sum over each spectrum is that of the samples, to rounding.

# %%
for axis in ("time", "space", "spacetime"):
    print(axis, "closes to 1e-13:", abs(spectra.attrs[f"parseval_{axis}"]) < 1e-13)

# %% [markdown]
# S(k, f) separates waves by frequency and wavenumber; for f > 0, k > 0 travels towards +x. The dashed
# curve is the dispersion relation.

# %%
power = spectra.spacetime_spectrum
decibels = 10 * np.log10(power / power.max())
fig, axes = plt.subplots(figsize=(7, 4))
decibels.clip(min=-70).plot(ax=axes, cmap="viridis", cbar_kwargs={"label": "S(k, f), dB re largest"})
curve = spectra.dispersion_frequency[0]
axes.plot(curve.dispersion_wavenumber, curve, "w--", lw=1)
axes.set(xlabel="wavenumber (rad/m)", ylabel="frequency (Hz)", ylim=(0, 0.5))
axes.set_title("Space-time spectrum of the struck chain", loc="left")

# %% [markdown]
# The energy travels away from the end that was struck, towards +x:

# %%
share = spectra.toward_plus_x_share.sel(frequency=slice(0.01, 0.15))
print(f"share that travels towards +x, median over frequencies: {float(share.median()):.2f}")

# %% [markdown]
# `wc.report(spectra, "out.html")` writes the interactive page that the program makes.
