"""Writes the fixtures of universal files, and what pyuff reads from them.

pyuff 2.5.8, numpy 2.4.6: `python make_uff.py` in this folder.
"""
import json, os, sys
import numpy as np, pyuff

here = os.path.join(os.path.dirname(os.path.abspath(__file__)), "files", "uff")
os.makedirs(here, exist_ok=True)
random = np.random.default_rng(11)
expected = {}

def function(node, x, data, spacing=1, binary=0, func_type=1, precision=4, **more):
    time = func_type == 1
    return {
        "type": 58, "binary": binary, "func_type": func_type, "rsp_node": node, "rsp_dir": 3,
        "ref_node": 1, "ref_dir": 3, "data": data, "x": x, "id1": f"hit at 1, node {node}",
        "abscissa_spacing": spacing, "abscissa_spec_data_type": 17 if time else 18,
        "abscissa_axis_units_lab": "s" if time else "NONE",
        "ordinate_spec_data_type": 11, "ordinate_axis_lab": "velocity",
        "ordinate_axis_units_lab": "m/s", "ord_data_type": precision, "orddenom_spec_data_type": 0, **more}

def write(name, sets, order="little", double=True):
    path = os.path.join(here, name)
    if os.path.exists(path):
        os.remove(path)
    sys.byteorder, kept = order, sys.byteorder
    uff = pyuff.UFF(path)
    for s in sets:
        uff._write_set(s, "add", force_double=double)
    sys.byteorder = kept
    found = pyuff.UFF(path).read_sets()
    alike = {}
    for s in found if isinstance(found, list) else [found]:
        if s["type"] == 58 and not np.iscomplexobj(s["data"]):
            alike.setdefault((s["abscissa_spacing"], len(s["data"])), []).append(s)
    array = lambda values: {"type": "f8", "shape": list(values.shape), "hex": values.astype("<f8").tobytes().hex()}
    expected[name] = {}
    for i, (key, records) in enumerate(alike.items(), 1):
        place = f"/{i}" if len(alike) > 1 else ""
        one = array(np.array([s["data"] for s in records]))
        one["attributes"] = {"units": records[0]["ordinate_axis_units_lab"].strip()}
        assert all((s["x"] == records[0]["x"]).all() for s in records)
        if key[0]:
            one["even"] = [0.5, 0.01]
            assert np.abs(records[0]["x"] - 0.5 - 0.01 * np.arange(key[1])).max() < 1e-15
        else:
            expected[name]["abscissa" + place] = array(np.asarray(records[0]["x"]))
        expected[name]["records" + place] = one

n = 13
t = 0.5 + 0.01 * np.arange(n)
uneven = np.sort(random.random(n))
v = lambda: random.standard_normal(n)
nodes = {"type": 15, "node_nums": [3, 4, 5], "def_cs": [0] * 3, "disp_cs": [0] * 3, "color": [1] * 3,
         "x": [0.25, 0.5, 1.25], "y": [2.0] * 3, "z": [0.0] * 3}
header = {"type": 151, "model_name": "m", "description": "d", "db_app": "a", "program": "p"}
write("ascii.uff", [nodes] + [function(k, t, v()) for k in (3, 4, 5)])
write("single.uff", [function(k, t, v(), precision=2) for k in (3, 4)], double=False)
write("uneven.uff", [function(k, uneven, v(), 0) for k in (3, 4)])
write("little.uff", [nodes] + [function(k, t, v(), binary=1) for k in (3, 4, 5)])
write("big.uff", [function(k, t, v(), binary=1) for k in (3, 4, 5)], order="big")
write("uneven_binary.uff", [function(k, uneven, v(), 0, 1) for k in (3, 4)])
mixed = [header, function(3, t, v(), binary=1), nodes, function(4, t, v(), binary=1), function(5, t, v(), binary=1),
         function(5, t[:7], v()[:7]), function(3, t, v() + 1j * v(), func_type=4, binary=1),
         function(3, t, v() + 1j * v(), func_type=4)]
write("mixed.uff", mixed)
with open(os.path.join(here, "expected.json"), "w") as f:
    json.dump(expected, f)
