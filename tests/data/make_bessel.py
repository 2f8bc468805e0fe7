"""Writes bessel.json: Bessel functions J_n(x) from mpmath with 40 digits.

SciPy's jv is off by 1e-14 at J_100(750).

Run: python make_bessel.py > bessel.json
"""

import datetime
import json
import sys

import mpmath

mpmath.mp.dps = 40
ORDERS = [0, 1, 2, 3, 10, 40, 100, 190, 200, 400]
POINTS = [0.0, 1e-9, 0.25, 1.0, 2.404825557695773, 10.0, 40.0, 192.0, 200.0, 750.0]

json.dump(
    {
        "made": {
            "by": "make_bessel.py",
            "date": datetime.date.today().isoformat(),
            "mpmath": mpmath.__version__,
        },
        "orders": ORDERS,
        "points": [{"x": x, "values": [float(mpmath.besselj(n, x)) for n in ORDERS]} for x in POINTS],
    },
    sys.stdout,
    separators=(",", ":"),
)
print()
