//! Units of the styles of LAMMPS.

/// Units of length, time, velocity and force in a style; none in reduced units (`lj`) and unknown styles.
pub(super) fn of_style(style: &str) -> [&'static str; 4] {
    match style {
        "si" => ["m", "s", "m/s", "N"],
        "cgs" => ["cm", "s", "cm/s", "dyn"],
        "micro" => ["um", "us", "um/us", "nN"],
        "nano" => ["nm", "ns", "nm/ns", "pN"],
        "metal" => ["Angstrom", "ps", "Angstrom/ps", "eV/Angstrom"],
        "real" => ["Angstrom", "fs", "Angstrom/fs", "kcal/(mol Angstrom)"],
        "electron" => ["Bohr", "fs", "Bohr/(1.03275 fs)", "Hartree/Bohr"],
        _ => [""; 4],
    }
}

/// The unit of a column, and the quantity that it holds.
pub(super) fn of_column(
    [length, _, velocity, force]: [&'static str; 4],
    column: &str,
) -> [&'static str; 2] {
    match column {
        "vx" | "vy" | "vz" => [velocity, "velocity"],
        "x" | "y" | "z" | "xu" | "yu" | "zu" => [length, "displacement"],
        "fx" | "fy" | "fz" => [force, "force"],
        "radius" | "diameter" => [length, ""],
        _ => ["", ""],
    }
}
