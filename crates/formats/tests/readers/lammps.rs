//! Dumps of LAMMPS against LAMMPS itself (`make_lammps.py`).

use serde_json::Value as Json;
use std::fmt::Write;
use std::sync::Arc;
use wavecascade_formats::{Container, Error, Format, Options, Result, SampleType, Value, open};

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

fn refused(text: &str) -> String {
    open_bytes(text.as_bytes().to_vec())
        .unwrap_err()
        .to_string()
}

#[test]
fn val_lammps_lost_atoms_are_refused() {
    let error = open_bytes(file("lost.lammpstrj")).unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }));
    let frames = frames("lost.lammpstrj");
    let other = frames.iter().find(|frame| frame["atoms"] != 3).unwrap();
    let place = format!("time step {} with {} atoms", other["step"], other["atoms"]);
    assert!(error.to_string().contains(&place), "{error}");
}

#[test]
fn regress_other_atoms_are_refused() {
    let (text, _) = large(4, 5);
    // Atom 8 of the third frame becomes another one, or one that is there already.
    let third = text.match_indices("ITEM: TIMESTEP").nth(2).unwrap().0;
    let at = third + text[third..].find("\n8 ").unwrap() + 1;
    let with = |id: &str| {
        let mut text = text.clone();
        text.replace_range(at..at + 1, id);
        let container = open_bytes(text.into_bytes()).unwrap();
        let vx = container.find("vx").unwrap();
        let mut out = [0; 8 * 10];
        // The frames before it are not touched.
        container.read(vx, &[0..2, 0..5], &mut out).unwrap();
        container.numbers(vx).unwrap_err().to_string()
    };
    let error = with("9");
    assert!(error.contains("time step 200 with the atom 9"), "{error}");
    let error = with("5");
    assert!(
        error.contains("time step 200: expected every atom once"),
        "{error}"
    );
    let error = with("x");
    assert!(error.contains("time step 200: expected the id"), "{error}");
}

#[test]
fn regress_what_is_refused() {
    let (text, _) = large(2, 5);
    for (from, to, expected) in [
        ("id x vx", "mol x vx", "without the column id"),
        ("ATOMS id", "ENTRIES id", "other values than those of atoms"),
        ("TIMESTEP\n0", "TIMESTEP\nzero", "expected a time step"),
        ("OF ATOMS\n5", "OF ATOMS\n4", "4 rows of 3 values"),
        ("OF ATOMS\n5", "OF ATOMS\n999999999", "whole rows"),
        ("NUMBER", "ANOTHER NUMBER", "expected ITEM: NUMBER OF ATOMS"),
        ("TIMESTEP", "STEP", "expected ITEM: TIMESTEP"),
    ] {
        let error = refused(&text.replace(from, to));
        assert!(error.contains(expected), "{error}");
    }
    let other = text.replacen("id x vx", "id x vy", 1);
    assert!(refused(&other).contains("time step 100 with other columns"));
    let timed = format!("ITEM: TIME\n0.5\n{text}");
    assert!(refused(&timed).contains("time step 100: expected ITEM: TIME"));
    let named = Format::detect("run.dump", b"anything");
    assert_eq!(named, Some(Format::Lammps));
    assert_eq!(Format::detect("run.dump", b"\x1f\x8b\x08"), None);
    let error = open(
        Format::Lammps,
        Arc::new(b"anything".to_vec()),
        &Options::default(),
    );
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("byte 0: expected ITEM: ")
    );
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

#[test]
fn regress_numbers_as_c_writes_them() {
    let text = "ITEM: TIMESTEP\n-3\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n\
                ITEM: ATOMS vx id\r\n-nan 2 \r\n  4.9406564584124654e-324\t1\r\n\
                ITEM: TIMESTEP\n4\nITEM: NUMBER OF ATOMS\n2\nITEM: ATOMS vx id\ninf 1\n-1e+400 2\n";
    let container = open_bytes(text.as_bytes().to_vec()).unwrap();
    let found = values(&container, "vx");
    assert_eq!(found[0], 5e-324);
    assert!(found[1].is_nan());
    assert_eq!(found[2..], [f64::INFINITY, f64::NEG_INFINITY]);
    assert_eq!(values(&container, "step"), [-3.0, 4.0]);
    let bounds = container.attributes.get("box_bounds");
    let wanted = Value::Numbers(vec![0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
    assert_eq!(bounds, Some(&wanted));
}

/// A chain that crosses the boundary of its box, `x` within it, with what is written behind it and its box.
fn crossing(columns: &str, bounds: &str, flags: bool) -> String {
    let mut text = String::new();
    for frame in 0..2 {
        write!(
            text,
            "ITEM: TIMESTEP\n{frame}\nITEM: NUMBER OF ATOMS\n4\nITEM: BOX BOUNDS {bounds}\nITEM: ATOMS {columns}\n"
        )
        .unwrap();
        // 6, 8, 10 and 12 in a box of 9 that begins at 0; the second frame is 2 farther.
        for (id, place) in [(4, 6.0), (1, 8.0), (2, 10.0), (3, 12.0)] {
            let place = place + 2.0 * f64::from(frame);
            let image = (place / 9.0f64).floor();
            let flags = match flags {
                true => format!(" {image} 0 0"),
                false => String::new(),
            };
            writeln!(text, "{id} {} 0.5 0.5{flags}", place - 9.0 * image).unwrap();
        }
    }
    text
}

#[test]
fn val_definition_image_flags_unwrap_positions() {
    // Along the edges of a tilted box an image along y adds to x, too: xy is 3, the bounds reach to 12.
    for bounds in [
        "pp pp pp\n0 9\n0 1\n0 1",
        "xy xz yz pp pp pp\n0 12 3\n0 1 0\n0 1 0",
    ] {
        let text = crossing("id x y z ix iy iz", bounds, true);
        let container = open_bytes(text.into_bytes()).unwrap();
        assert_eq!(values(&container, "id"), [4.0, 1.0, 2.0, 3.0]);
        assert_eq!(values(&container, "first/x"), [6.0, 8.0, 10.0, 12.0]);
        let unwrapped = [6.0, 8.0, 10.0, 12.0, 8.0, 10.0, 12.0, 14.0];
        assert_eq!(values(&container, "xu"), unwrapped);
        // What the file holds stays as it is.
        assert_eq!(values(&container, "x")[..4], [6.0, 8.0, 1.0, 3.0]);
        assert!(container.remarks.is_empty());
    }
    let shares = crossing("id xs y z ix iy iz", "pp pp pp\n-9 0\n0 1\n0 1", true);
    let shares = shares.replace(" 6 ", " 0.75 ").replace(" 8 ", " 0.875 ");
    let shares = shares
        .replace("2 1 0.5", "2 0.25 0.5")
        .replace("3 3 0.5", "3 0.5 0.5");
    let container = open_bytes(shares.into_bytes()).unwrap();
    assert_eq!(values(&container, "first/x"), [-2.25, -1.125, 2.25, 4.5]);
}

#[test]
fn regress_a_chain_that_may_cross_a_boundary_is_said() {
    let remarks = |columns: &str, bounds: &str| {
        let container = open_bytes(crossing(columns, bounds, false).into_bytes()).unwrap();
        let remarks = container.remarks.into_iter();
        remarks
            .map(|remark| remark.text)
            .collect::<Vec<_>>()
            .concat()
    };
    let bounds = "pp pp pp\n0 9\n0 1\n0 1";
    let said = remarks("id x y z", bounds);
    assert!(
        said.contains("periodic boundary along x") && said.contains("`ix`"),
        "{said}"
    );
    for (columns, bounds) in [
        ("id xu y z", bounds),
        ("id x y z", "ff pp pp\n0 9\n0 1\n0 1"),
        // With room beyond both ends, no atom has crossed.
        ("id x y z", "pp pp pp\n-9 18\n0 1\n0 1"),
    ] {
        assert_eq!(remarks(columns, bounds), "", "{columns} {bounds}");
    }
}
