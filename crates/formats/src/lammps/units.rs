//! Units of the styles of LAMMPS.

/// Units of a style, by what is measured.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Units {
    pub length: &'static str,
    pub time: &'static str,
    pub velocity: &'static str,
    pub force: &'static str,
}

impl Units {
    /// Those of a style; empty for reduced units (`lj`) and unknown styles.
    pub fn of(style: &str) -> Units {
        let [length, time, velocity, force] = match style {
            "si" => ["m", "s", "m/s", "N"],
            "cgs" => ["cm", "s", "cm/s", "dyn"],
            "micro" => ["um", "us", "um/us", "nN"],
            "nano" => ["nm", "ns", "nm/ns", "pN"],
            "metal" => ["Angstrom", "ps", "Angstrom/ps", "eV/Angstrom"],
            "real" => ["Angstrom", "fs", "Angstrom/fs", "kcal/(mol Angstrom)"],
            "electron" => ["Bohr", "fs", "Bohr/(1.03275 fs)", "Hartree/Bohr"],
            _ => return Units::default(),
        };
        Units {
            length,
            time,
            velocity,
            force,
        }
    }

    /// The unit of a column, and the quantity that it holds.
    pub fn of_column(self, column: &str) -> (&'static str, &'static str) {
        match column {
            "vx" | "vy" | "vz" => (self.velocity, "velocity"),
            "x" | "y" | "z" | "xu" | "yu" | "zu" => (self.length, "displacement"),
            "fx" | "fy" | "fz" => (self.force, "force"),
            "radius" | "diameter" => (self.length, ""),
            _ => ("", ""),
        }
    }
}
