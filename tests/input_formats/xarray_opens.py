#!/usr/bin/env python3
"""Compares spectra.nc with spectra.npz, budgets, coherence and fields, as xarray opens them.

Usage: xarray_opens.py DIRECTORY | check

DIRECTORY holds zip/spectra.npz, nc/spectra.nc, field.npz, field.nc, run.npz and run.nc, and budgets of a run and
of a measured field: bzip/budget.npz, bnc/budget.nc, mzip/budget.npz, mnc/budget.nc. Prints the number of
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
    assert {"--dt", "--dx"} <= set(json.loads(spectra.command))
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
for [zipped, netcdf] in [("bzip", "bnc"), ("mzip", "mnc")]:
    archive = np.load(here / zipped / "budget.npz")
    for engine in ["netcdf4", "scipy"]:
        budget = xr.open_dataset(here / netcdf / "budget.nc", engine=engine)
        count += compare(archive, budget)
        assert budget.energy_flux.dims == ("time", "contact_position")
        assert budget.transfer.dims == ("time", "wavenumber")
        assert budget.power_flow.dims == ("frequency", "contact_position")
        assert budget.scale_flux_in_time.dims == ("time", "scale")
        assert budget.kinetic_energy.dims == ("time",)
        # Every axis has its coordinates, every array its name and, in SI, its unit.
        assert set(budget.dims) == set(budget.coords), set(budget.dims) ^ set(budget.coords)
        for name, variable in budget.variables.items():
            assert variable.attrs["long_name"], name
            assert variable.attrs["units"], name
        units = {name: budget[name].units for name in ["transfer", "energy_spectrum", "power_flow", "time", "position"]}
        assert units == {"transfer": "J/s", "energy_spectrum": "J", "power_flow": "J/Hz", "time": "s", "position": "m"}, units
        assert budget.program == "cascade" and budget.schema.startswith("cascade.budget/")
        assert 0 <= budget.closure_wavenumber < 1e-2
        # The balance over wavenumbers, by names: sums over k are the energy.
        total = budget.energy_spectrum.sum("wavenumber")
        energy = budget.kinetic_energy + budget.contact_energy
        assert float(abs(total - energy).max() / energy.max()) < 1e-2
        budget.close()
    if zipped == "mzip":
        assert "transfer_error" in archive.files and "force" in archive.files
print(count)
