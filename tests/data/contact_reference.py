"""Hertz contacts of crossed cylinders and general surfaces to 30 digits, by the textbook formulas.

Writes contact_reference.csv beside this file. Needs mpmath (made with 1.3.0).
Exact ellipse: B/A = [(a/b)^2 E - K] / (K - E) solved for b/a (Johnson, Contact Mechanics, 4.2).
"""
import pathlib
from mpmath import mp, mpf, ellipk, ellipe, pi, sqrt, sin, cos, tan, radians, findroot, exp, log

mp.dps = 90


def parts(bya):
    m = 1 - bya**2
    return m, ellipk(m), ellipe(m)


def aspect(A, B, exact):
    ratio = A / B
    if ratio == 1:
        return mpf(1)
    guess = ratio ** (mpf(2) / 3)
    if not exact:
        return guess

    def residual(u):
        bya = exp(u)
        m, K, E = parts(bya)
        return log((E / bya**2 - K) / (K - E)) + log(ratio)

    lam = log(1 / ratio) / 2
    return exp(findroot(residual, (-lam * mpf("1.0001"), -lam * mpf("1.3333")), solver="anderson", tol=mpf(10) ** -100, verify=False))


def coefficient(A, B, modulus, exact):
    bya = aspect(A, B, exact)
    if bya == 1:
        return mpf(4) / 3 * modulus / sqrt(2 * A), bya
    m, K, E = parts(bya)
    b_part, d_part = (E / bya**2 - K) / m, (K - E) / m
    beta = 2 * pi / 3 * modulus * K ** mpf("-1.5") * (b_part * d_part / (A * B)) ** (mpf(1) / 4)
    return beta, bya


def curvatures(p1, q1, p2, q2, degrees):
    d1, d2 = p1 - q1, p2 - q2
    s = (p1 + q1 + p2 + q2) / 2
    d = sqrt(d1**2 + d2**2 + 2 * d1 * d2 * cos(2 * radians(degrees))) / 2
    return (s - d) / 2, (s + d) / 2


ANGLES = ["0.01", "0.1", "0.5", "1", "2", "5", "8", "18", "30", "44.9", "45", "60", "80", "89", "89.9", "89.999", "89.999999", "90", "1e-6", "1e-9"]
rows = ["kind,p1,q1,p2,q2,angle_deg,exact,coefficient,aspect"]
for exact in (0, 1):
    for angle in ANGLES:
        # the double nearest to the angle is what the program is given
        degrees = mpf(float(angle))
        A, B = curvatures(mpf(0), mpf(1), mpf(0), mpf(1), degrees) if degrees != 90 else (mpf(1) / 2, mpf(1) / 2)
        beta, bya = coefficient(A, B, mpf(1), exact)
        rows.append(f"cylinders,0,1,0,1,{angle},{exact},{mp.nstr(beta, 30)},{mp.nstr(bya, 30)}")
    for p1, q1, p2, q2, angle in [("1", "1", "0", "0", "0"), ("1", "1", "0", "2", "0"), ("0.5", "3", "0.25", "7", "33"), ("-0.5", "2", "1", "1", "10"), ("1e-3", "1", "1e-6", "1", "0"), ("0", "1", "0", "111", "90")]:
        v = [mpf(float(s)) for s in (p1, q1, p2, q2)]
        A, B = curvatures(*v, mpf(float(angle)))
        if abs(B / A - 1) < mpf(10) ** -60:
            B = A
        beta, bya = coefficient(A, B, mpf(1), exact)
        rows.append(f"general,{p1},{q1},{p2},{q2},{angle},{exact},{mp.nstr(beta, 30)},{mp.nstr(bya, 30)}")
pathlib.Path(__file__).with_name("contact_reference.csv").write_text("\n".join(rows) + "\n")
