"""The FPUT alpha chain by DOP853 of SciPy: energies by mode, their entropy, and the recurrence: fput.json.

31 bodies between fixed ends (32 springs), alpha = 1/4, mode 1 with amplitude 1: E. Fermi, J. Pasta, S. Ulam, Los
Alamos report LA-1940 (1955), figure 1. Run with Python 3.12, NumPy 2 and SciPy 1.17: `python make_fput.py > fput.json`.
"""

import json

import numpy as np
from scipy.integrate import solve_ivp

N, ALPHA = 31, 0.25
j = np.arange(1, N + 1)
k = np.arange(1, N + 1)
shapes = np.sqrt(2 / (N + 1)) * np.sin(np.pi * np.outer(k, j) / (N + 1))
w = 2 * np.sin(np.pi * k / (2 * (N + 1)))
period = 2 * np.pi / w[0]


def rhs(_, y):
    x = np.concatenate([[0.0], y[:N], [0.0]])
    e = np.diff(x)
    f = e + ALPHA * e**2
    return np.concatenate([y[N:], np.diff(f)])


start = np.concatenate([np.sin(np.pi * j / (N + 1)), np.zeros(N)])
times = period * np.arange(0, 721) / 4
y = solve_ivp(rhs, (0, times[-1]), start, method="DOP853", rtol=1e-13, atol=1e-15, t_eval=times).y
q, p = shapes @ y[:N], shapes @ y[N:]
energy = 0.5 * (p**2 + (w[:, None] * q) ** 2)
share = energy / energy.sum(axis=0)
entropy = -np.sum(np.where(share > 0, share * np.log(np.maximum(share, 1e-300)), 0), axis=0)
late = times > 100 * period
at = int(np.argmax(np.where(late, share[0], 0)))
shown = [0, 40, 160, 300, 440, 628, at, 720]
print(
    json.dumps(
        {
            "period": period,
            "recurrence": times[at] / period,
            "samples": shown,
            "energies": [energy[:6, i].tolist() for i in shown],
            "entropy": [entropy[i] for i in shown],
            "energy": [energy[:, i].sum() for i in shown],
        },
        indent=1,
    )
)
