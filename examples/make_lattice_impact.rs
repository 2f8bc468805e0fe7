//! Writes `examples/data/lattice_impact.npy` and its sidecar: a harmonic lattice struck at site 0.
//!
//! Run from the repository's root: `cargo run --release --example make_lattice_impact`.
//! The front passes one site a unit of time and reaches the last site as the record ends.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use wavecascade::Field;
use wavecascade::reference::LatticeImpact;

const SIDECAR: &str = "\
# A harmonic lattice whose site 0 starts with unit velocity: v_j(t) = J_2j(2 t).
# Time in sqrt(m/c), mass over spring constant; x in lattice spacings a; v in that of the impact.
layout = \"time-site\"
dt = 0.125
t0 = 0.0
time_unit = \"sqrt(m/c)\"
dx = 1.0
x0 = 0.0
space_unit = \"a\"
quantity = \"velocity\"
unit = \"v0\"
# Waves of the lattice, which figures draw over S(k, f).
dispersion = \"2*sqrt(c/m)*abs(sin(k*a/2)); c=1, m=1\"
";

fn main() -> io::Result<()> {
    let folder = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "examples/data".into());
    let folder = Path::new(&folder);
    let impact = LatticeImpact {
        n_times: 768,
        n_sites: 96,
        dt: 0.125,
    };
    write_npy(&folder.join("lattice_impact.npy"), &impact.field())?;
    fs::write(folder.join("lattice_impact.toml"), SIDECAR)
}

/// NumPy's format 1.0, little-endian f32, times by rows: a header padded to 64 bytes, the samples.
fn write_npy(path: &Path, field: &Field) -> io::Result<()> {
    let (times, sites) = (field.n_times(), field.n_sites());
    let mut samples = vec![0.0; times * sites];
    field.read_time_major(0..times, 0..sites, &mut samples);

    let dict = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({times}, {sites}), }}");
    let padding = 63 - (10 + dict.len()) % 64;
    let header = format!("{dict}{:padding$}\n", "");

    let mut file = io::BufWriter::new(fs::File::create(path)?);
    file.write_all(b"\x93NUMPY\x01\x00")?;
    file.write_all(&(header.len() as u16).to_le_bytes())?;
    file.write_all(header.as_bytes())?;
    for sample in samples {
        file.write_all(&(sample as f32).to_le_bytes())?;
    }
    file.flush()
}
