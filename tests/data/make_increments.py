#!/usr/bin/env python3
"""Writes increments.json: second and third orders of a record along x, by fluidsf 0.2.2.

    pip install numpy==2.4.6 fluidsf==0.2.2

Samples: integers of a linear congruential generator, summed, the same in tests/analysis/peers.rs.
"""

import json
import pathlib

import fluidsf
import numpy as np

COUNT, DX = 400, 0.5


def noise(seed, count):
    values, state = [], seed
    for _ in range(count):
        state = (1103515245 * state + 12345) % 2**31
        values.append(state / 2**30 - 1)
    return np.array(values)


v = np.cumsum(noise(1, COUNT))
x = DX * np.arange(COUNT)
found = fluidsf.generate_structure_functions_1d(v, x, ["LL", "LLL"], boundary=None)
keep = [i for i, r in enumerate(found["x-diffs"]) if 0 < r <= 50 * DX]
out = {
    "separation": [float(found["x-diffs"][i]) for i in keep],
    "second": [float(found["SF_LL"][i]) for i in keep],
    "third": [float(found["SF_LLL"][i]) for i in keep],
}
pathlib.Path(__file__).with_name("increments.json").write_text(json.dumps(out) + "\n")
print(out["separation"][:4], len(keep))
