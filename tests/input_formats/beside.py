"""Writes beside.h5, beside.mat and beside73.mat: rates, distances and units that stand beside the samples.

h5py 3.16.0 and SciPy 1.17.1; beside73.mat has the attributes that MATLAB gives a struct."""

import os
import sys

import h5py
import numpy as np
import scipy.io

folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
values = np.arange(12.0).reshape(6, 2)

with h5py.File(os.path.join(folder, "beside.h5"), "w") as f:
    group = f.create_group("run/scan")
    group.create_dataset("velocity", data=values)
    f.attrs["dx"] = 9.0
    f["run"].attrs["unit"] = "mm/s"
    group.attrs["fs"] = 1e5
    group.attrs["dx"] = np.float32(0.5)
    group.attrs["dx_unit"] = "mm"

data = {"v": values, "fs": 1e5, "dx": 0.5, "unit": "mm/s"}
scipy.io.savemat(os.path.join(folder, "beside.mat"), {"data": data})

with h5py.File(os.path.join(folder, "beside73.mat"), "w", userblock_size=512) as f:
    group = f.create_group("data")
    group.attrs["MATLAB_class"] = np.bytes_("struct")
    for name, value in data.items():
        if isinstance(value, str):
            value = np.frombuffer(value.encode("utf-16-le"), dtype="<u2").reshape(-1, 1)
            kind = "char"
        else:
            value, kind = np.atleast_2d(value).T, "double"
        group.create_dataset(name, data=value)
        group[name].attrs["MATLAB_class"] = np.bytes_(kind)
