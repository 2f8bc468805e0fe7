"""A sweep over stiffness ratios beside numba and diffrax: CPU time per chain and errors.

    python3 benches/peers/chain/sweeps.py PROGRAM [--members 64] [--rounds 3] [--out FILE]

PROGRAM is `cascade`. Struck dimers of 300 sites, ratios from 1 to 1585 (equal ratios), to time 250, final
velocities, one core:

- `cascade sweep` at tolerances 1e-6 and 1e-9: each member checked by a second run, its error stated;
- velocity Verlet compiled by numba, one chain after the other, without a check;
- diffrax's Dopri8 under `vmap`, all chains in one call, without a check.

Errors of the peers are differences from `cascade simulate` at a tolerance of 1e-10, over the members that
reach 1e-8 there: the others amplify rounding. The table has the median and the largest of them.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import peer

SITES, END = 300, 250.0


def ratios(members):
    return [1585.0 ** (i / (members - 1)) for i in range(members)]


def numba_sweep(members, settings, rounds):
    import numba
    import numpy

    @numba.njit(fastmath=True, error_model="numpy")
    def final(coefficient, steps, h):
        n = len(coefficient)
        x, v, a = numpy.zeros(n + 1), numpy.zeros(n), numpy.zeros(n)
        force = numpy.zeros(n + 1)
        v[0] = 1.0
        for j in range(n):
            v[j] += 0.5 * h * a[j]
        for step in range(steps):
            for j in range(n):
                x[j] += h * v[j]
            for j in range(n):
                overlap = max(x[j] - x[j + 1], 0.0)
                force[j + 1] = coefficient[j] * overlap * numpy.sqrt(overlap)
            kick = h if step + 1 < steps else 0.5 * h
            for j in range(n):
                v[j] += kick * (force[j] - force[j + 1])
        return v

    chains = [numpy.where(numpy.arange(SITES) % 2 == 0, 1.0, k) for k in ratios(members)]
    final(chains[0], 10, 0.01)
    for steps in settings:
        for _ in range(rounds):
            before = time.process_time()
            rows = [final(chain, steps, END / steps) for chain in chains]
            yield f"{steps} steps", time.process_time() - before, numpy.array(rows)


def diffrax_sweep(members, settings, rounds):
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false"
    os.environ["JAX_PLATFORMS"] = "cpu"
    import diffrax
    import jax
    import jax.numpy as jnp
    import numpy

    jax.config.update("jax_enable_x64", True)

    def final(kappa, tolerance):
        coefficient = jnp.where(jnp.arange(SITES) % 2 == 0, 1.0, kappa)

        def derivative(t, y, args):
            x, v = y
            overlap = jnp.maximum(x - jnp.append(x[1:], 0.0), 0.0)
            force = coefficient * overlap * jnp.sqrt(overlap)
            return v, jnp.append(0.0, force[:-1]) - force

        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(derivative),
            diffrax.Dopri8(),
            t0=0.0,
            t1=END,
            dt0=None,
            y0=(jnp.zeros(SITES), jnp.zeros(SITES).at[0].set(1.0)),
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
            max_steps=10_000_000,
            adjoint=diffrax.ForwardMode(),
        )
        return solution.ys[1][-1]

    every = jax.jit(jax.vmap(final, in_axes=(0, None)))
    kappas = jnp.asarray(ratios(members))
    every(kappas, 1e-2).block_until_ready()
    for tolerance in settings:
        for _ in range(rounds):
            before = time.process_time()
            rows = every(kappas, tolerance).block_until_ready()
            yield f"tolerance {tolerance:g}", time.process_time() - before, numpy.asarray(rows)


PEERS = {
    "numba": (["numpy==2.4.6", "numba==0.66.0"], numba_sweep, [8192, 65536, 524288]),
    "diffrax": (
        ["numpy==2.4.6", "jax==0.7.2", "jaxlib==0.7.2", "diffrax==0.7.2"],
        diffrax_sweep,
        [1e-6, 1e-8],
    ),
}


def child(name, members, rounds, file):
    """One peer, in its own environment: seconds and rows into a file."""
    import numpy

    _, sweep, settings = PEERS[name]
    found = {}
    for setting, seconds, rows in sweep(members, settings, rounds):
        found.setdefault(setting, ([], rows))[0].append(seconds)
    numpy.savez(
        file,
        settings=list(found),
        seconds=[seconds for seconds, _ in found.values()],
        rows=[rows for _, rows in found.values()],
    )


def run(command, core):
    """CPU seconds of a command on one core."""
    before = os.times()
    pinned = ["taskset", "-c", core, *command]
    done = subprocess.run([str(word) for word in pinned], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr}")
    after = os.times()
    return after.children_user - before.children_user


def own(program, members, tolerance, folder, core):
    out = folder / f"sweep-{tolerance:g}"
    subprocess.run(["rm", "-rf", out], check=True)
    seconds = run(
        [program, "sweep", "--sites", SITES, "--end-time", END, "--samples", 2, "--tolerance", tolerance]
        + ["--vary", f"stiffness_ratio=1:1585:{members}log", "--threads", 1, "--quiet", "--out", out],
        core,
    )
    lines = (out / "table.csv").read_text().splitlines()
    rows = [dict(zip(lines[0].split(","), line.split(","))) for line in lines[1:]]
    return seconds, rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=lambda path: str(pathlib.Path(path).resolve()))
    parser.add_argument("--members", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--peers", default=",".join(PEERS))
    parser.add_argument("--out", type=pathlib.Path)
    asked = parser.parse_args()
    core = max(os.sched_getaffinity(0))
    folder = pathlib.Path(tempfile.mkdtemp(prefix="sweeps-"))
    load = os.getloadavg()[0]
    lines = [f"# A sweep of {asked.members} chains, load before {load:.2f}", ""]
    lines += ["| program | setting | ms a chain | median error | largest | warned |", "|---" * 6 + "|"]

    def row(program, setting, seconds, errors, warned):
        errors = sorted(errors)
        middle, most = errors[len(errors) // 2], errors[-1]
        cells = [program, setting, f"{1e3 * min(seconds) / asked.members:.1f}"]
        lines.append("| " + " | ".join([*cells, f"{middle:.1e}", f"{most:.1e}", warned]) + " |")
        print(lines[-1], flush=True)

    for tolerance in (1e-6, 1e-9):
        runs = [own(asked.program, asked.members, tolerance, folder, core) for _ in range(asked.rounds)]
        members = runs[0][1]
        good = [float(m["error"]) for m in members if m["warned"] == "false"]
        warned = sum(m["warned"] == "true" for m in members)
        row("cascade, stated", f"tolerance {tolerance:g}", [s for s, _ in runs], good, str(warned))

    names = asked.peers.split(",")
    for name in names:
        requirements = PEERS[name][0]
        python = peer.installed(name, requirements)
        file = folder / f"{name}.npz"
        command = [python, __file__, "--child", name, asked.members, asked.rounds, file]
        run(command, core)
        # The peers' environments have NumPy; this one need not.
        reference = json.dumps(references(asked.program, asked.members, folder, core))
        script = (
            "import sys, json, numpy; found = numpy.load(sys.argv[1]); "
            "exact = [None if f is None else numpy.load(f)['velocity'][-1] for f in json.loads(sys.argv[2])]; "
            "print(json.dumps([[s, list(t), [float(abs(r[i] - e).max()) for i, e in enumerate(exact) "
            "if e is not None]] for s, t, r in zip(found['settings'].tolist(), found['seconds'].tolist(), "
            "found['rows'])]))"
        )
        said = subprocess.run([python, "-c", script, file, reference], capture_output=True, text=True, check=True)
        for setting, seconds, errors in json.loads(said.stdout):
            row(name, setting, seconds, errors, "not checked")
    text = "\n".join(lines) + "\n"
    print("\n" + text)
    if asked.out:
        asked.out.write_text(text)


KNOWN = {}


def references(program, members, folder, core):
    """A file for each member that reaches 1e-8, else nothing."""
    if members not in KNOWN:
        _, rows = own(program, members, 1e-10, folder, core)
        files = []
        for i, (kappa, row) in enumerate(zip(ratios(members), rows)):
            file = folder / f"member-{i}.npz"
            if float(row["error"]) > 1e-8:
                files.append(None)
                continue
            words = ["--sites", SITES, "--stiffness-ratio", repr(kappa), "--end-time", END, "--samples", 2]
            words += ["--tolerance", 1e-10, "--record", "displacement", "--quiet", "--out", file]
            run([program, "simulate", *words], core)
            files.append(str(file))
        KNOWN[members] = files
    return KNOWN[members]


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        child(sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), sys.argv[5])
    else:
        main()
