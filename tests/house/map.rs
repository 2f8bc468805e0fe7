//! The picture of who uses whom, `docs/architecture.svg`, is drawn from the code. With `RECORD_MAP=1` it is written anew.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;

use crate::rooms::{listed, root, uses};

type Uses = BTreeMap<String, BTreeSet<String>>;

/// Rooms that so many others use are drawn as the ground on which all stand, without arrows.
const GROUND: usize = 10;
const BOX: (f64, f64) = (112.0, 30.0);
const STEP: (f64, f64) = (132.0, 74.0);
const MARGIN: f64 = 24.0;

/// What each room uses.
fn used() -> Uses {
    let listed = listed();
    let mut all: Uses = listed
        .iter()
        .map(|room| (room.clone(), BTreeSet::new()))
        .collect();
    for (_, room, used) in uses() {
        if let Some(known) = all.get_mut(&room) {
            known.extend(
                used.into_iter()
                    .filter(|other| *other != room && listed.contains(other)),
            );
        }
    }
    all
}

/// The rooms that most use, and what the others use of one another.
fn split(all: Uses) -> (Vec<String>, Uses) {
    let users = |room: &str| all.values().filter(|used| used.contains(room)).count();
    let ground: Vec<String> = listed()
        .into_iter()
        .filter(|room| users(room) >= GROUND && all[room].len() <= 1)
        .collect();
    let above = all.iter().filter(|(room, _)| !ground.contains(room));
    let above = above.map(|(room, used)| {
        let used = used.iter().filter(|other| !ground.contains(other));
        (room.clone(), used.cloned().collect())
    });
    let above = above.collect();
    (ground, above)
}

/// All that a room uses, others between them or not.
fn reached(room: &str, above: &Uses) -> BTreeSet<String> {
    let direct = &above[room];
    let further = direct.iter().flat_map(|other| reached(other, above));
    further.chain(direct.iter().cloned()).collect()
}

/// Without what is used through another room as well.
fn reduced(above: &Uses) -> Uses {
    let direct = |room: &String| {
        let through: BTreeSet<String> = above[room]
            .iter()
            .flat_map(|other| reached(other, above))
            .collect();
        above[room].difference(&through).cloned().collect()
    };
    above
        .keys()
        .map(|room| (room.clone(), direct(room)))
        .collect()
}

/// Rows of rooms from the bottom up, each room with its place along the row: above all that it uses, and near to it.
fn rows(above: &Uses, arrows: &Uses) -> Vec<Vec<(String, f64)>> {
    fn level(room: &str, above: &Uses) -> usize {
        above[room]
            .iter()
            .map(|other| level(other, above) + 1)
            .max()
            .unwrap_or(0)
    }
    let mut rows: Vec<Vec<String>> = Vec::new();
    for room in listed().into_iter().filter(|room| above.contains_key(room)) {
        let at = level(&room, above);
        rows.resize_with(rows.len().max(at + 1), Vec::new);
        rows[at].push(room);
    }
    let mut place: BTreeMap<String, f64> = BTreeMap::new();
    for row in &mut rows {
        let mean = |room: &String| {
            let used = &arrows[room];
            let sum: f64 = used.iter().filter_map(|other| place.get(other)).sum();
            if used.is_empty() {
                0.0
            } else {
                sum / used.len() as f64
            }
        };
        row.sort_by(|a, b| mean(a).total_cmp(&mean(b)));
        let wanted: Vec<f64> = row.iter().map(mean).collect();
        let mut at = wanted.clone();
        for i in 1..at.len() {
            at[i] = at[i].max(at[i - 1] + 1.0);
        }
        let shift = (wanted.iter().sum::<f64>() - at.iter().sum::<f64>()) / at.len() as f64;
        place.extend(row.iter().cloned().zip(at.iter().map(|at| at + shift)));
    }
    let placed = |room: String| {
        let at = place[&room];
        (room, at)
    };
    rows.into_iter()
        .map(|row| row.into_iter().map(placed).collect())
        .collect()
}

fn drawn() -> String {
    let (ground, above) = split(used());
    let arrows = reduced(&above);
    let rows = rows(&above, &arrows);
    let middle = (ground.len() as f64 - 1.0) / 2.0;
    let ground_row: Vec<(String, f64)> = ground
        .iter()
        .cloned()
        .enumerate()
        .map(|(i, room)| (room, i as f64 - middle))
        .collect();
    let all = || {
        std::iter::once(&ground_row)
            .chain(&rows)
            .flatten()
            .map(|(_, at)| *at)
    };
    let (left, right) = (all().fold(0.0, f64::min), all().fold(0.0, f64::max));
    let width = (right - left) * STEP.0 + BOX.0 + 2.0 * MARGIN;
    let height = rows.len() as f64 * STEP.1 + BOX.1 + 2.0 * MARGIN;
    let mut places = BTreeMap::new();
    for (level, row) in std::iter::once(&ground_row).chain(&rows).enumerate() {
        let y = height - MARGIN - BOX.1 - level as f64 * STEP.1;
        for (room, at) in row {
            places.insert(room.as_str(), (MARGIN + (at - left) * STEP.0, y));
        }
    }
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"14\">\n\
         <title>Modules of wavecascade: each uses those that its lines lead down to, and those of the bottom row</title>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    );
    for (room, used) in &arrows {
        let (x, y) = places[room.as_str()];
        for other in used {
            let (to_x, to_y) = places[other.as_str()];
            let (from, to) = ((x + BOX.0 / 2.0, y + BOX.1), (to_x + BOX.0 / 2.0, to_y));
            let bend = (to.1 - from.1) / 2.0;
            let _ = writeln!(
                svg,
                "<path d=\"M{} {}C{} {} {} {} {} {}\" fill=\"none\" stroke=\"#789\" stroke-width=\"1.2\"><title>{room} uses {other}</title></path>",
                from.0,
                from.1,
                from.0,
                from.1 + bend,
                to.0,
                to.1 - bend,
                to.0,
                to.1
            );
        }
    }
    for (room, (x, y)) in &places {
        let fill = if ground.iter().any(|other| other == room) {
            "#e4e8ee"
        } else {
            "#dceaf7"
        };
        let _ = writeln!(
            svg,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\" rx=\"5\" fill=\"{fill}\" stroke=\"#456\"/>\
             <text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{room}</text>",
            BOX.0,
            BOX.1,
            x + BOX.0 / 2.0,
            y + 20.0
        );
    }
    svg + "</svg>\n"
}

#[test]
fn regress_the_picture_of_the_map_is_that_of_the_code() {
    let path = root().join("docs/architecture.svg");
    let drawn = drawn();
    if std::env::var_os("RECORD_MAP").is_some() {
        fs::write(&path, &drawn).unwrap();
    }
    let stored = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        stored == drawn,
        "docs/architecture.svg is of other code: RECORD_MAP=1 cargo test --test house"
    );
}

#[test]
fn val_an_arrow_is_left_out_where_another_way_leads() {
    let set = |rooms: &[&str]| {
        rooms
            .iter()
            .map(|room| (*room).to_owned())
            .collect::<BTreeSet<String>>()
    };
    let above = Uses::from(
        [("a", set(&[])), ("b", set(&["a"])), ("c", set(&["a", "b"]))]
            .map(|(room, used)| (room.to_owned(), used)),
    );
    assert_eq!(reduced(&above)["c"], set(&["b"]));
    assert_eq!(reached("c", &above), set(&["a", "b"]));
}
