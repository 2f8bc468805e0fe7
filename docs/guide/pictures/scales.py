#!/usr/bin/env python3
"""Writes the fields of the pictures of modes, increments and slopes: waves.npz, shocks.npz, fput.npz."""

import numpy as np

rng = np.random.default_rng(1)

# A forward wave of slowly changing phase around 2 Hz that decays along x, a standing one at 5 Hz, and noise.
t, x = 0.02 * np.arange(8192), 0.05 * np.arange(64)
drift = np.cumsum(rng.normal(0, 0.06, (2, t.size)), axis=1)[:, :, None]
v = np.exp(-0.3 * x) * np.cos(4.0 * x - 4 * np.pi * t[:, None] + drift[0])
v = v + 0.5 * np.cos(6.0 * x) * np.cos(10 * np.pi * t[:, None] + drift[1])
np.savez("waves.npz", v=v + 0.3 * rng.normal(size=v.shape), t=t, x=x)

# Burgers turbulence: random waves, followed along characteristics, with the shocks of the maximum principle
# (Hopf and Cole without viscosity): u = (x - y) / t, y where phi(y) + (x - y)^2 / (2 t) is least.
n, length = 512, 32.0
x = length * np.arange(n) / n
y = length * (np.arange(12 * n) / 4 - n) / n
frames = []
for _ in range(24):
    k = 2 * np.pi / length * np.arange(1, 9)
    a, phase = rng.normal(size=(2, k.size))
    phi = (a / k * np.cos(k * y[:, None] + 3 * phase)).sum(axis=1) / 2
    for time in (3.0, 4.0):
        nearest = y[np.argmin(phi + (x[:, None] - y) ** 2 / (2 * time), axis=1)]
        frames.append((x - nearest) / time)
np.savez("shocks.npz", v=np.array(frames), t=np.arange(48.0), x=x)

# The alpha chain of Fermi, Pasta, Ulam and Tsingou: one wave around a ring of 512, up to two shock times.
n, alpha, speed, dt = 512, 1.0, 0.05, 0.1
k = 2 * np.pi / n
q = speed / (2 * np.sin(k / 2)) * np.cos(k * np.arange(n))
v = speed * np.sin(k * np.arange(n))
force = lambda q: (lambda f: f - np.roll(f, 1))((lambda r: r + alpha * r * r)(np.roll(q, -1) - q))
steps = int(2 / (alpha * speed * k) / dt)
kept, a = [v.copy()], force(q)
for step in range(1, steps + 1):
    v += 0.5 * dt * a
    q += dt * v
    a = force(q)
    v += 0.5 * dt * a
    if step % (steps // 80) == 0:
        kept.append(v.copy())
np.savez("fput.npz", v=np.array(kept), t=dt * (steps // 80) * np.arange(len(kept)), x=np.arange(n))
