//! Dumps of LAMMPS against LAMMPS itself (`make_lammps.py`).

use std::fmt::Write;
use std::sync::Arc;
use wavecascade_formats::{Container, Format, Options, Result, open};

use super::common::{self, values};

fn open_bytes(bytes: Vec<u8>) -> Result<Container> {
    assert_eq!(Format::detect("data", &bytes), Some(Format::Lammps));
    open(Format::Lammps, Arc::new(bytes), &Options::default())
}

/// The kinetic energy, of which LAMMPS writes as many digits as of velocities, is of the same atom in every frame, whatever its row.
#[test]
fn val_lammps_atoms_that_change_their_rows() {
    let text = String::from_utf8(common::file("lammps", "gas.dump")).unwrap();
    let frames = text.split("ITEM: ATOMS").skip(1);
    let first = |frame: &str| {
        frame
            .lines()
            .nth(1)
            .unwrap()
            .split(' ')
            .next()
            .unwrap()
            .to_owned()
    };
    let first: Vec<String> = frames.map(first).collect();
    assert!(first.iter().any(|id| *id != first[0]));
    let container = common::opened("lammps", "gas.dump");
    let [vx, vy, energy] = ["vx", "vy", "c_energy"].map(|path| values(&container, path));
    for (i, energy) in energy.iter().enumerate() {
        let mass = if i % 16 < 8 { 2.0 } else { 1.0 };
        let wanted = 0.5 * mass * (vx[i] * vx[i] + vy[i] * vy[i]);
        assert!((energy - wanted).abs() <= 1e-14 * wanted);
    }
}

/// Atoms in `n` of one frame each, whose rows are in a different order in each frame.
fn large(frames: usize, atoms: usize) -> (String, impl Fn(usize, usize) -> f64) {
    let value = move |frame: usize, atom: usize| (frame * atoms + atom) as f64 * 0.37 - 5.0;
    let mut text = String::new();
    for frame in 0..frames {
        write!(
            text,
            "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n{atoms}\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\n\
             ITEM: ATOMS id x vx\n",
            100 * frame
        )
        .unwrap();
        for row in 0..atoms {
            let atom = (row + 7 * frame) % atoms;
            // Ids with gaps.
            writeln!(
                text,
                "{} {} {} ",
                3 * atom + 5,
                atom as f64 / 8.0,
                value(frame, atom)
            )
            .unwrap();
        }
    }
    (text, value)
}

#[test]
fn regress_a_large_dump_and_parts_of_it() {
    let (n_frames, n_atoms) = (37, 3001);
    let (text, value) = large(n_frames, n_atoms);
    assert!(text.len() > 2 << 20);
    let container = open_bytes(text.into_bytes()).unwrap();
    let vx = container.find("vx").unwrap();
    assert_eq!(container.variables[vx].shape(), [37, 3001]);
    let all = container.numbers(vx).unwrap();
    let wanted = (0..n_frames).flat_map(|f| (0..n_atoms).map(move |a| (f, a)));
    assert!(
        wanted
            .zip(&all)
            .all(|((f, a), found)| value(f, a) == *found)
    );
    let mut out = [0; 8 * 6];
    container
        .read(vx, &[20..23, 3000..3001], &mut out[..24])
        .unwrap();
    let part = [20, 21, 22].map(|f| value(f, 3000).to_ne_bytes());
    assert_eq!(out[..24], part.concat()[..]);
    container.read(vx, &[36..37, 11..17], &mut out).unwrap();
    let part = [11, 12, 13, 14, 15, 16].map(|a| value(36, a).to_ne_bytes());
    assert_eq!(out, part.concat()[..]);
    let mut out = [0; 16];
    let step = container.find("step").unwrap();
    let part = std::slice::from_ref(&(3..5));
    container.read(step, part, &mut out).unwrap();
    assert_eq!(out, [300i64, 400].map(i64::to_ne_bytes).concat()[..]);
}

#[test]
fn regress_items_wherever_they_lie() {
    let (text, _) = large(1, 2);
    for shift in 4060..4110 {
        let style = "l".repeat(shift);
        let container = open_bytes(format!("ITEM: UNITS\n{style}\n{text}").into_bytes()).unwrap();
        let found = container.attributes.text("lammps_units");
        assert_eq!(found, Some(style.as_str()));
    }
}

#[test]
fn regress_a_dump_cut_short_is_no_shorter_dump() {
    for name in ["six_digits.lammpstrj", "granular.lammpstrj"] {
        let bytes = common::file("lammps", name);
        let bytes = &bytes[..bytes.len().min(3500)];
        let begins: &[u8] = match name {
            "six_digits.lammpstrj" => b"ITEM: TIMESTEP\n",
            _ => b"ITEM: TIME\n",
        };
        for length in 6..bytes.len() {
            let is_whole = bytes[length..].starts_with(begins)
                && bytes[..length].windows(11).any(|w| w == b"ITEM: ATOMS");
            let container = open_bytes(bytes[..length].to_vec());
            assert_eq!(container.is_ok(), is_whole, "{name} {length}");
        }
    }
}
