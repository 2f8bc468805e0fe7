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
# The plan of a terabyte is the same. Dask computes shapes and chunks without a sample:

# %%
import dask.array

big = xr.DataArray(
    dask.array.zeros((2**22, 2**15), chunks=(2**16, 2**11), dtype="f8"),
    {"time": ("time", 1e-3 * np.arange(2**22), {"units": "s"})},
    ("time", "x"),
    "velocity",
)
lazy = wc.temporal_spectrum(big, scaling="density", segment=2**16, window_time="hann")
whole_records = big.data.rechunk({0: -1}).chunksize
print(f"field:    {big.nbytes / 2**40:.0f} TiB in {big.data.npartitions} chunks")
print(f"spectrum: {lazy.nbytes / 2**30:.0f} GiB in {lazy.data.npartitions} blocks, one task each")
print(f"a task reads {np.prod(whole_records) * 8 / 2**30:.0f} GiB: records of {whole_records[1]} sites")

# %% [markdown]
# A task of this size is too large for most workers: smaller chunks along x, not along time, make it
# smaller.

# %%
finer = big.chunk({"x": 64})
lazy = wc.temporal_spectrum(finer, scaling="density", segment=2**16, window_time="hann")
print(f"{lazy.data.npartitions} tasks of {2**22 * 64 * 8 / 2**30:.0f} GiB")
folder.cleanup()
