#!/usr/bin/env python3
"""Compares spectra.nc with spectra.npz, and fields, as xarray opens them.

Usage: xarray_opens.py DIRECTORY | check

DIRECTORY holds zip/spectra.npz, nc/spectra.nc, field.npz, field.nc, run.npz and run.nc. Prints the number of
arrays that are the same to the bit.
"""

import json
import pathlib
import sys

import netCDF4  # the engine that xarray prefers
import numpy as np
import scipy  # another one
import xarray as xr

if sys.argv[1] == "check":
    sys.exit()
here = pathlib.Path(sys.argv[1])


def same(a, b, name):
    assert a.shape == b.shape, (name, a.shape, b.shape)
    b = b.astype(b.dtype.newbyteorder("="))
    assert a.dtype == b.dtype, (name, a.dtype, b.dtype)
    assert a.tobytes() == b.tobytes(), name


def compare(archive, dataset):
    arrays = [name for name in archive.files if archive[name].dtype.kind == "f"]
    for name in arrays:
        same(archive[name], dataset[name].values, name)
    assert set(arrays) == set(dataset.variables), set(arrays) ^ set(dataset.variables)
    return len(arrays)


count = 0
archive = np.load(here / "zip/spectra.npz")
for engine in [None, "netcdf4", "scipy"]:
    spectra = xr.open_dataset(here / "nc/spectra.nc", **({"engine": engine} if engine else {}))
    count += compare(archive, spectra)
    assert spectra.spacetime_spectrum.dims == ("frequency", "wavenumber_signed")
    assert spectra.temporal_spectrum.dims == ("frequency", "position")
    assert spectra.spatial_spectrum.dims == ("time", "wavenumber")
    assert spectra.frequency_centroid.dims == ("position",)
    assert {"time", "position", "frequency", "wavenumber"} <= set(spectra.coords)
    assert spectra.time.dtype.kind == "f" and spectra.time.units == "s"
    assert spectra.program == "cascade"
    assert {option["option"] for option in json.loads(spectra.settings)} >= {"dt", "dx"}
    # Selection by coordinates works.
    part = spectra.spacetime_spectrum.sel(frequency=slice(0, 2e4))
    assert 1 < part.sizes["frequency"] < spectra.sizes["frequency"]
    spectra.close()
for name in ["field", "run"]:
    archive, dataset = np.load(here / f"{name}.npz"), xr.open_dataset(here / f"{name}.nc")
    count += compare(archive, dataset)
    assert dataset.velocity.dims == ("time", "position")
    assert dataset.velocity.units == str(archive["velocity_unit"])
    assert dataset.position.units == "m"
    if name == "run":
        assert dataset.attrs["scene"] == str(archive["scene"])
        assert dataset.force.dims == ("time", "contact_position")
print(count)
