//! The picture of who uses whom, `docs/architecture.md`, is drawn from the code. With `RECORD_MAP=1` it is written anew.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;

use crate::rooms::{listed, root, uses};

type Uses = BTreeMap<String, BTreeSet<String>>;

/// Rooms that so many others use are drawn as the ground on which all stand, without arrows.
const GROUND: usize = 10;

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

fn drawn() -> String {
    let (ground, above) = split(used());
    let arrows = reduced(&above);
    let mut text = String::from(
        "# Who uses whom\n\nModules of `wavecascade`: each uses those that its arrows lead down to, and those of the ground.\n\n\
         ```mermaid\ngraph TD\n",
    );
    for (room, used) in &arrows {
        let _ = writeln!(text, "    {room}");
        for other in used {
            let _ = writeln!(text, "    {room} --> {other}");
        }
    }
    text += "    subgraph ground\n";
    for room in ground {
        let _ = writeln!(text, "        {room}");
    }
    text + "    end\n```\n"
}

#[test]
fn regress_the_picture_of_the_map_is_that_of_the_code() {
    let path = root().join("docs/architecture.md");
    let drawn = drawn();
    if std::env::var_os("RECORD_MAP").is_some() {
        fs::write(&path, &drawn).unwrap();
    }
    let stored = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        stored == drawn,
        "docs/architecture.md is of other code: RECORD_MAP=1 cargo test --test house"
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
