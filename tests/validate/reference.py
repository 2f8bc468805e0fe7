"""Independent reference: chains in 80-bit arithmetic, by extrapolation of the modified midpoint rule."""

import numpy as np

#: Substeps of the extrapolation: the harmonic sequence.
SUBSTEPS = (2, 4, 6, 8, 10, 12, 14, 16)
WIDE = np.longdouble


def hertz_chain(coefficient, mass, ends="wall"):
    """x'' of a chain of Hertz contacts; the last one is with a wall, or there is one contact less."""
    coefficient, mass = WIDE(coefficient), WIDE(mass)

    def acceleration(x):
        overlap = x - np.append(x[1:], WIDE(0)) if ends == "wall" else x[:-1] - x[1:]
        overlap = np.maximum(overlap, 0)
        force = coefficient * overlap * np.sqrt(overlap)
        pull = np.zeros_like(x)
        pull[: len(force)] -= force
        pull[1:] += force[: len(x) - 1]
        return pull / mass

    return acceleration


def followed(acceleration, v, times, tolerance=1e-18):
    """Velocities at `times` of bodies that start at x = 0 with `v`; x'' = a(x), steps of order 16."""
    x, v, t = np.zeros(len(v), WIDE), WIDE(v), WIDE(0)
    found, h = [v.copy()], WIDE(1e-3)
    for stop in map(WIDE, times[1:]):
        while t < stop:
            last = h >= stop - t
            step = stop - t if last else h
            table = []
            for j, n in enumerate(SUBSTEPS):
                # Stoermer's rule, whose error is a series in h^2.
                part = step / n
                place, push = x.copy(), acceleration(x)
                delta = part * (v + part * push / 2)
                for i in range(1, n + 1):
                    place = place + delta
                    push = acceleration(place)
                    delta = delta + part**2 * push if i < n else delta
                row = [(place, delta / part + part * push / 2)]
                for k in range(j):
                    ratio = (WIDE(n) / SUBSTEPS[j - 1 - k]) ** 2 - 1
                    row.append(
                        tuple(a + (a - b) / ratio for a, b in zip(row[k], table[-1][k], strict=True))
                    )
                table.append(row)
            apart = [np.abs(a - b).max() for a, b in zip(table[-1][-1], table[-1][-2], strict=True)]
            error = float(max(apart[0], apart[1]))
            if error <= tolerance * 50 or step < 1e-12:
                x, v = table[-1][-1]
                t = stop if last else t + step
            grow = 0.9 * (tolerance * 50 / max(error, 1e-30)) ** (1 / 14)
            h = step * WIDE(min(2.0, max(0.2, grow))) if not last or error > tolerance * 50 else h
        found.append(v.copy())
    return np.array(found)
