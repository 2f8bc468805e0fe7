//! Dumps of LAMMPS against LAMMPS itself (`make_lammps.py`).

use serde_json::Value as Json;
use std::fmt::Write;
use std::sync::Arc;
use wavecascade_formats::{Container, Format, Options, Result, SampleType, open};

use super::common::{self, values};

fn file(name: &str) -> Vec<u8> {
    common::file("lammps", name)
}

/// The frames of each file.
fn expected() -> serde_json::Map<String, Json> {
    serde_json::from_slice(&file("expected.json")).unwrap()
}

fn frames(name: &str) -> Vec<Json> {
    expected()[name].as_array().unwrap().clone()
}

fn open_bytes(bytes: Vec<u8>) -> Result<Container> {
    assert_eq!(Format::detect("data", &bytes), Some(Format::Lammps));
    open(Format::Lammps, Arc::new(bytes), &Options::default())
}

fn opened(name: &str) -> Container {
    open_bytes(file(name)).unwrap()
}

/// A value of LAMMPS for each atom in the order of the ids 1, 2, ..
fn of_frame(frame: &Json, kind: &str, axis: usize) -> Vec<f64> {
    let all = frame[kind].as_array().unwrap();
    let along = all.iter().skip(axis).step_by(3);
    along.map(|value| value.as_f64().unwrap()).collect()
}

#[test]
fn val_lammps_columns() {
    let columns = [
        ("vx", "v", 0),
        ("vy", "v", 1),
        ("vz", "v", 2),
        ("x", "x", 0),
        ("y", "x", 1),
        ("z", "x", 2),
        ("fx", "f", 0),
    ];
    let mut compared = 0;
    for name in expected().keys().filter(|name| *name != "lost.lammpstrj") {
        let (container, frames) = (opened(name), frames(name));
        let ids = values(&container, "id");
        for (column, kind, axis) in columns {
            let Some(at) = container.find(column) else {
                continue;
            };
            let found = container.numbers(at).unwrap();
            let rows = found.chunks(ids.len());
            assert_eq!(rows.len(), frames.len(), "{name}");
            for (row, frame) in rows.zip(&frames) {
                let all = of_frame(frame, kind, axis);
                let wanted: Vec<f64> = ids.iter().map(|&id| all[id as usize - 1]).collect();
                assert_eq!(row, wanted, "{name} {column}");
                compared += row.len();
            }
        }
    }
    assert_eq!(compared, 21 * 9 * 7 + 21 * 16 * 4 + 12 * (11 + 2 * 4 + 2));
}

#[test]
fn val_lammps_times_and_units() {
    let container = opened("granular.lammpstrj");
    let frames = frames("granular.lammpstrj");
    let steps = |frames: &[Json]| -> Vec<i64> {
        frames.iter().map(|f| f["step"].as_i64().unwrap()).collect()
    };
    let step = container.find("step").unwrap();
    assert_eq!(container.integers(step).unwrap(), Some(steps(&frames)));
    let time = container.find("time").unwrap();
    let found = container.numbers(time).unwrap();
    for (found, frame) in found.iter().zip(&frames) {
        // Sixteen digits are written.
        let wanted = frame["time"].as_f64().unwrap();
        assert!((found - wanted).abs() <= 1e-15 * wanted, "{found} {wanted}");
    }
}

#[test]
fn val_lammps_atoms_of_a_row_are_in_its_order() {
    let container = opened("granular.lammpstrj");
    let x = container.find("first/x").unwrap();
    let mut wanted = of_frame(&frames("granular.lammpstrj")[0], "x", 0);
    wanted.reverse();
    assert_eq!(container.numbers(x).unwrap(), wanted);

    let scaled = opened("scaled.lammpstrj");
    let z = scaled.find("first/z").unwrap();
    let wanted = of_frame(&frames("scaled.lammpstrj")[0], "x", 2);
    for (found, wanted) in scaled.numbers(z).unwrap().iter().zip(wanted) {
        assert!((found - wanted).abs() <= 1e-14);
    }

    let unwrapped = opened("six_digits.lammpstrj");
    assert_eq!(values(&unwrapped, "first/z")[11], 11.5);
}

#[test]
fn val_lammps_atoms_that_change_their_rows() {
    let text = String::from_utf8(file("gas.dump")).unwrap();
    let first_of_frames: Vec<&str> = text
        .split("ITEM: ATOMS")
        .skip(1)
        .map(|frame| frame.lines().nth(1).unwrap().split(' ').next().unwrap())
        .collect();
    assert!(first_of_frames.iter().any(|id| *id != first_of_frames[0]));
    let container = opened("gas.dump");
    let ids: Vec<f64> = (1..=16).map(f64::from).collect();
    assert_eq!(values(&container, "id"), ids);
    let vx = &container.variables[container.find("vx").unwrap()];
    assert_eq!(vx.dimensions[1].coordinate, None);
    let element = &container.variables[container.find("element").unwrap()];
    assert_eq!(element.sample_type, SampleType::Other("text".into()));
    // The kinetic energy, of which LAMMPS writes as many digits.
    let (vx, vy) = (values(&container, "vx"), values(&container, "vy"));
    for (i, energy) in values(&container, "c_energy").iter().enumerate() {
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
        let bytes = file(name);
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
