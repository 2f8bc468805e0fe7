"""Writes point-by-point scans as UFF and as SEG-Y files, one record each, and the field that they are.

pyuff 2.5.8, segyio 1.9.14, numpy 2.4.6: `python make_scan_files.py` in this folder. The records begin at different
times and have different lengths; the names of the files are not in the order of the positions. The field holds
the times that all records have in common, as each library reads them from its files.
"""

import json
import pathlib
import shutil

import numpy as np
import pyuff
import segyio
from segyio import BinField, TraceField

here = pathlib.Path(__file__).resolve().parent
SITES, STEP_MS = 5, 0.5
FIRST = [4, 0, 6, 2, 8]  # steps after 0 at which each record begins
LENGTH = [30, 36, 33, 31, 28]
NAMES = [7, 3, 9, 1, 5]
expected = {}


def record(j):
    n = FIRST[j] + np.arange(LENGTH[j])
    return np.float32(np.sin(0.4 * n - 0.9 * j) * np.exp(-(((n - 18 - 2 * j) / 7) ** 2))).astype(float)


def keep(kind, records, step, unit, positions, space_unit):
    begin = max(FIRST)
    end = min(f + len(r) for f, r in zip(FIRST, records))
    common = [r[begin - f : end - f] for f, r in zip(FIRST, records)]
    expected[kind] = {
        "samples": np.array(common).T.tolist(), "t0": begin * step, "dt": step, "time_unit": unit,
        "positions": positions, "space_unit": space_unit,
    }


def folder(kind):
    path = here / f"scan_{kind}"
    shutil.rmtree(path, ignore_errors=True)
    path.mkdir()
    return path


place, records = folder("uff"), []
for j in range(SITES):
    path = place / f"point_{NAMES[j]}.uff"
    node = {"type": 15, "node_nums": [100 + j], "def_cs": [0], "disp_cs": [0], "color": [1],
            "x": [0.25 * j], "y": [2.0], "z": [0.0]}
    function = {
        "type": 58, "binary": j % 2, "func_type": 1, "rsp_node": 100 + j, "rsp_dir": 3, "ref_node": 1, "ref_dir": 3,
        "data": record(j), "x": 1e-3 * STEP_MS * (FIRST[j] + np.arange(LENGTH[j])), "id1": f"node {100 + j}",
        "abscissa_spacing": 1, "abscissa_spec_data_type": 17, "abscissa_axis_units_lab": "s",
        "ordinate_spec_data_type": 11, "ordinate_axis_lab": "velocity", "ordinate_axis_units_lab": "m/s",
        "ord_data_type": 4, "orddenom_spec_data_type": 0}
    file = pyuff.UFF(str(path))
    file._write_set(node, "add")
    file._write_set(function, "add")
    found = [s for s in pyuff.UFF(str(path)).read_sets() if s["type"] == 58]
    records.append(np.asarray(found[0]["data"], float))
keep("uff", records, 1e-3 * STEP_MS, "s", [0.25 * j for j in range(SITES)], None)

place, records = folder("segy"), []
for j in range(SITES):
    path = place / f"shot{NAMES[j]}.sgy"
    spec = segyio.spec()
    spec.format, spec.samples, spec.tracecount = 5, range(LENGTH[j]), 1
    with segyio.create(str(path), spec) as file:
        file.bin.update({BinField.Interval: int(1000 * STEP_MS), BinField.Samples: LENGTH[j]})
        file.header[0] = {
            TraceField.TRACE_SAMPLE_COUNT: LENGTH[j], TraceField.TRACE_SAMPLE_INTERVAL: int(1000 * STEP_MS),
            TraceField.DelayRecordingTime: int(STEP_MS * FIRST[j]), TraceField.GroupX: 1000 + 125 * j,
            TraceField.GroupY: 77, TraceField.SourceGroupScalar: -10}
        file.trace[0] = record(j).astype(np.float32)
    with segyio.open(str(path), ignore_geometry=True) as file:
        records.append(file.trace[0].astype(float))
keep("segy", records, 1e-3 * STEP_MS, "s", [100 + 12.5 * j for j in range(SITES)], "m")

with open(here / "scan_files.json", "w") as out:
    json.dump(expected, out)
