"""Ratios of localized waves of the stiffness dimer, for tests/localized/waves.rs.

    S'' = P(t+h)^p + P(t-h)^p - 2 S^p,  eps P'' = S(t+h)^p + S(t-h)^p - 2 P^p,  h = 1/2,

on cosines, S and P at N + 1 times of half a period L, eps unknown, with S and P zero at L / 2 and
sum S^p = sum P^p; steps of least squares at the paper's ratio, then Newton's. NumPy only.
"""

import numpy as np

N, L, h, p = 192, 10.0, 0.5, 1.5
PAPER = [4.9272, 14.622, 31.275, 54.517, 82.990, 119.92, 169.0]

j = np.arange(N + 1)
t, w, n = j * L / (2 * N), 2 * np.pi * j / L, N + 1
ends = np.where((j == 0) | (j == N), 1.0, 2.0)
C = np.cos(np.outer(t, w))  # coefficients -> values
A = (C * ends[:, None]).T / (2 * N) * ends[:, None]  # values -> coefficients
with np.errstate(divide="ignore"):
    green = np.where(j == 0, 0.0, 2 / w**2)
K0, K1, mean = C @ np.diag(green) @ A, C @ np.diag(green * np.cos(w * h)) @ A, A[0]


def system(S, P, a, b, eps):
    FS, FP = np.maximum(S, 0) ** p, np.maximum(P, 0) ** p
    dS, dP = p * np.maximum(S, 0) ** (p - 1), p * np.maximum(P, 0) ** (p - 1)
    R = np.concatenate(
        [S - a - K0 @ FS + K1 @ FP, eps * (P - b) - K0 @ FP + K1 @ FS, [S[-1], P[-1], mean @ (FS - FP)]]
    )
    J = np.zeros((2 * n + 3, 2 * n + 3))
    J[:n, :n], J[:n, n : 2 * n], J[:n, 2 * n] = np.eye(n) - K0 * dS, K1 * dP, -1
    J[n : 2 * n, :n], J[n : 2 * n, n : 2 * n] = K1 * dS, eps * np.eye(n) - K0 * dP
    J[n : 2 * n, 2 * n + 1], J[n : 2 * n, 2 * n + 2] = -eps, P - b
    J[2 * n, n - 1] = J[2 * n + 1, 2 * n - 1] = 1
    J[2 * n + 2, :n], J[2 * n + 2, n : 2 * n] = mean * dS, -mean * dP
    return R, J


def add(state, dx):
    S, P, a, b, eps = state
    return S + dx[:n], P + dx[n : 2 * n], a + dx[2 * n], b + dx[2 * n + 1], eps + dx[2 * n + 2]


# The slow wave: psi'' = (F(t+1) + F(t-1) - 2 F) / 2, as a convolution.
with np.errstate(divide="ignore", invalid="ignore"):
    K = C @ np.diag(np.where(j == 0, 0.5, (1 - np.cos(w)) / w**2)) @ A
x = np.sqrt(10) / 5 * t
slow = 6.25 * np.where(x < np.pi / 2, np.cos(x) ** 4, 0)
for _ in range(12):
    J = np.eye(n) - K * (p * np.maximum(slow, 0) ** (p - 1))
    slow = slow - np.linalg.solve(J, slow - K @ np.maximum(slow, 0) ** p)
stiff = np.maximum((C * np.cos(w * h)) @ (A @ np.maximum(slow, 0) ** p), 0) ** (1 / p)

for order, paper in enumerate(PAPER, 2):
    state = slow, stiff, mean @ slow, mean @ stiff, paper ** (-1 / p)
    for _ in range(5):
        R, J = system(*state)
        state = add(state, np.append(np.linalg.lstsq(J[:, :-1], -R, rcond=None)[0], 0.0))
    for _ in range(10):
        R, J = system(*state)
        state = add(state, np.linalg.solve(J, -R))
    print(order, f"{state[-1] ** -p:.15g}")
