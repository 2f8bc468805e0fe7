"""Trajectories of impacted Hertz chains in double-double arithmetic, to the last digit of f64.

Compiles chain_reference.cpp beside this file (g++) into a temporary directory and runs it.
Needs NumPy.

    python chain_reference.py shipped            # dimer_14.622.npz and collisions.json, here
    python chain_reference.py flights            # expected velocities of flights.json, here
    python chain_reference.py check REFERENCES   # against N100_kappa*.npz made by another program
    python chain_reference.py dimer SITES KAPPA END SAMPLES OUT.npz
"""

import datetime
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy

HERE = pathlib.Path(__file__).resolve().parent
TOLERANCE = 1e-24


def compiled(folder):
    program = pathlib.Path(folder) / "chain_reference"
    # Double-double sums need every rounding as written.
    flags = ["-O3", "-march=native", "-ffp-contract=off"]
    subprocess.run(["g++", *flags, "-o", program, HERE / "chain_reference.cpp"], check=True)
    return program


def trajectory(mass, coefficient, velocity, times, tolerance=TOLERANCE):
    """Velocities and displacements, (time, site)."""
    with tempfile.TemporaryDirectory() as folder:
        program = compiled(folder)
        work = pathlib.Path(folder)
        numpy.asarray(times, float).tofile(work / "times")
        chain = zip(map(float, mass), map(float, coefficient), map(float, velocity))
        lines = "".join(f"{m!r} {c!r} {v!r}\n" for m, c, v in chain)
        command = [program, repr(tolerance), work / "times", work / "out"]
        subprocess.run(command, input=lines, text=True, check=True)
        return numpy.fromfile(work / "out").reshape(2, len(times), len(mass))


def dimer(sites, kappa, times, tolerance=TOLERANCE):
    coefficient = [1.0, kappa] * (sites // 2) + [1.0] * (sites % 2)
    return trajectory([1.0] * sites, coefficient, [1.0] + [0.0] * (sites - 1), times, tolerance)


def uniform(end, samples):
    return numpy.array([end * (i / (samples - 1)) for i in range(samples)])


def largest(a, b):
    return float(abs(a - b).max())


def shipped():
    times = uniform(90.0, 64)
    v, x = dimer(100, 14.622, times)
    looser, _ = dimer(100, 14.622, times, 1e-22)
    print(f"dimer 14.622: tolerance 1e-22 against {TOLERANCE}: {largest(v, looser):.1e}")
    numpy.savez(HERE / "dimer_14.622.npz", t=times, v=v)

    cases = []
    for mass, coefficient in [
        ([1.0, 1.0, 1.0], [1.0, 1.0]),
        ([1.0, 2.5, 0.7], [1.0, 3.0]),
        ([1.0, 0.1, 1.0], [2.0, 2.0]),
    ]:
        # A last contact of coefficient 0 leaves the end free.
        v, x = trajectory(mass, [*coefficient, 0.0], [1.0, 0.0, 0.0], [0.0, 30.0, 60.0])
        assert (numpy.diff(x[1]) > 0).all() and largest(v[1], v[2]) == 0, "still in contact"
        cases.append({"mass": mass, "coefficient": coefficient, "velocity": v[2].tolist()})
        print(mass, coefficient, v[2].tolist())
    record = {
        "made_by": f"chain_reference.py, {datetime.date.today()}",
        "impact": "first body at speed 1, the others at rest and touching; velocities at 30",
        "cases": cases,
    }
    (HERE / "collisions.json").write_text(json.dumps(record, indent=1) + "\n")


def flights():
    """Of each case the velocities at one of its samples."""
    path = HERE / "flights.json"
    record = json.loads(path.read_text())
    for case in record["cases"]:
        times = uniform(case["end_time"], case["samples"])[[0, case["sample"]]]
        # A last contact of coefficient 0 leaves the end free.
        v, _ = trajectory(case["mass"], [*case["coefficient"], 0.0], case["velocity"], times)
        case["expected"] = v[1].tolist()
    record["made_by"] = f"chain_reference.py flights, {datetime.date.today()}"
    path.write_text(json.dumps(record, indent=1) + "\n")


def check(folder):
    for path in sorted(pathlib.Path(folder).glob("N100_kappa*.npz")):
        kappa = float(path.stem.removeprefix("N100_kappa"))
        with numpy.load(path) as other:
            v, x = dimer(100, kappa, other["t"])
            print(f"{path.name}: velocities {largest(v, other['v']):.1e},",
                  f"displacements {largest(x, other['x']):.1e}")


def main():
    match sys.argv[1:]:
        case ["shipped"]:
            shipped()
        case ["flights"]:
            flights()
        case ["check", folder]:
            check(folder)
        case ["dimer", sites, kappa, end, samples, out]:
            times = uniform(float(end), int(samples))
            v, x = dimer(int(sites), float(kappa), times)
            numpy.savez(out, t=times, v=v, x=x)
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main()
