# %% [markdown]
# # A field in Zarr, on Dask
#
# Fields larger than memory lie in chunked stores. Spectra along time need whole records of some
# sites, those along x whole snapshots of some times: both are made block by block, where Dask wants
# them.

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

import wavecascade as wc

rng = np.random.default_rng(4)
t, x = 0.01 * np.arange(2048), 0.5 * np.arange(256)
velocity = rng.standard_normal((t.size, x.size)) + 2 * np.cos(
    2 * np.pi * (8 + x / 32)[None, :] * t[:, None]
)
folder = tempfile.TemporaryDirectory()
store = Path(folder.name) / "field.zarr"
xr.Dataset(
    {"velocity": (("time", "x"), velocity, {"units": "m/s"})},
    {"time": ("time", t, {"units": "s"}), "x": ("x", x, {"units": "m"})},
).to_zarr(store, encoding={"velocity": {"chunks": (512, 64)}}, consolidated=False)

# %% [markdown]
# Opened with `chunks={}`, nothing is read. `wc.temporal_spectrum` of it is lazy: a block of the
# result is a block of sites with their whole records.

# %%
field = xr.open_zarr(store, consolidated=False).velocity
spectrum = wc.temporal_spectrum(field, scaling="density", segment=512, window_time="hann")
print("field:   ", field.shape, "chunks of", field.data.chunksize)
print("spectrum:", spectrum.shape, "chunks of", spectrum.data.chunksize)

# %% [markdown]
# Computed in blocks, it has the bits of the whole in memory. Here the line rises along x, as it was
# made:

# %%
blocks = spectrum.compute()
whole = wc.temporal_spectrum(field.compute(), scaling="density", segment=512, window_time="hann")
print("same bits:", blocks.values.tobytes() == whole.values.tobytes())
fig, axes = plt.subplots(figsize=(7, 3.6))
decibels = 10 * np.log10(blocks.sel(frequency=slice(0, 25)))
decibels.plot(
    ax=axes, cmap="viridis", vmin=-25, vmax=10, cbar_kwargs={"label": "S(f, x), dB re 1 (m/s)²/Hz"}
)
axes.set(xlabel="position (m)", ylabel="frequency (Hz)")
axes.set_title("Spectrum of a Zarr store, block by block", loc="left")

# %% [markdown]
# A terabyte in long records is another matter. A block of whole records would be of 64 GiB, and is
# refused:

# %%
import dask.array

big = xr.DataArray(
    dask.array.zeros((2**22, 2**15), chunks=(2**16, 2**11), dtype="f8"),
    {"time": ("time", 1e-3 * np.arange(2**22), {"units": "s"})},
    ("time", "x"),
    "velocity",
)
print(f"{big.nbytes / 2**40:.0f} TiB in {big.data.npartitions} chunks")
try:
    wc.temporal_spectrum(big, scaling="density", segment=2**16, window_time="hann")
except ValueError as error:
    print(error)

# %% [markdown]
# An average over segments needs no whole records: each chunk gives its sums, whatever its size; workers
# change no bit, chunks the last digits
# ([Fields larger than one machine](../guide/distributed.md)). Dask computes shapes without a sample:

# %%
lazy = wc.distributed.averaged(big, segment=2**16)
print(f"S(f, x): {lazy.spectrum.nbytes / 2**30:.0f} GiB in {lazy.spectrum.data.npartitions} blocks")
small = wc.distributed.averaged(field, segment=512, detrend="none").compute()
print("as above:", np.allclose(small.spectrum, blocks, rtol=1e-12, atol=0))
folder.cleanup()
