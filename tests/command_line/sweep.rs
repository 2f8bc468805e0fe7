//! `cascade sweep`, and chains in SI with their units.

use test_support::contains_all;
use test_support::made::in_one_line;
use test_support::place::Place;

const BEADS: &str = "sweep --sites 8 --material steel --shape sphere --striker-velocity 1m/s";

#[test]
fn a_sweep_says_what_is_wrong_and_that_runs_failed() {
    let place = Place::new();
    let sweep = "sweep --sites 8 --end-time 20 --samples 8";
    place.says(&format!("{sweep} --vary stiffness_ratio=1,2 --out good"));
    let said = place.refuses(2, "sweep --merge good --sites 3 --out m");
    contains_all(&said, &["--merge", "--sites"]);
    let steps = format!("{sweep} --scheme velocity-verlet --vary step=0.01,9 --out half");
    let output = place.run(&steps.split(' ').collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(1), "one of two runs failed");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("1 of the runs failed"), "{said}");
    let table = place.read("half/table.csv");
    assert_eq!(table.lines().count(), 3);
    contains_all(table.lines().nth(2).unwrap(), &["stability"]);
}

/// Ranges take units; forces and times have theirs in the answer and on the page.
#[test]
fn a_sweep_takes_units_and_states_them() {
    let place = Place::new();
    let said = place.says(&format!(
        "{BEADS} --vary radius=5mm:20mm:4 --end-time 800us --out s"
    ));
    let said = in_one_line(&said);
    assert!(said.contains(" N at radius 5.000 mm to "), "{said}");
    assert!(said.contains(" N at radius 20.00 mm"), "{said}");
    let table = place.read("s/table.csv");
    let rows: Vec<Vec<&str>> = table
        .lines()
        .map(|line| line.split(',').collect())
        .collect();
    let radii: Vec<&str> = rows[1..].iter().map(|row| row[0]).collect();
    assert_eq!(radii, ["5.0mm", "10.0mm", "15.0mm", "20.0mm"]);
    let page = place.read("s/report.html");
    for text in [
        "radius (mm)",
        "force, last contact (N)",
        "time of the force, last contact (s)",
        " N at radius 5.000 mm",
    ] {
        assert!(page.contains(text), "{text}");
    }
    // Forces of similar spheres at one speed grow with the square of the radius.
    let column = rows[0].iter().position(|name| *name == "peak_force_last");
    let forces = rows[1..]
        .iter()
        .map(|row| row[column.unwrap()].parse().unwrap());
    let forces: Vec<f64> = forces.collect();
    assert!(
        (forces[3] / forces[0] / 16.0 - 1.0).abs() < 1e-6,
        "{forces:?}"
    );
}

/// A run that ends by itself ends behind the largest force at the wall; another says what a force needs.
#[test]
fn a_sweep_without_values_says_what_to_state() {
    let place = Place::new();
    let vary = "sweep --sites 8 --vary stiffness_ratio=1,2";
    let said = place.says(&format!("{vary} --out a"));
    contains_all(&said, &["force at the last contact from ", "2 of 2 run"]);
    assert!(!said.contains("known"), "{said}");
    let found = place.json("a/summary.json");
    assert_eq!(found["known"], 2);
    for (words, needed) in [
        ("--end-time 4", "--end-time"),
        ("--end-time 40 --samples 5", "--samples"),
    ] {
        let said = place.says(&format!("{vary} {words} --out b{needed}"));
        contains_all(&said, &["known in none of 2 members", "2 of 2 run", needed]);
        assert_eq!(said.matches("known").count(), 1, "{said}");
    }
    let table = place.read("b--samples/table.csv");
    for line in table.lines().skip(1) {
        assert!(line.contains(",samples,"), "{table}");
    }
}

/// A run that ends by itself ends before the wall's force peaks, and says with which end it is there.
#[test]
fn a_run_that_ends_by_itself_says_when_the_wall_peaks() {
    let place = Place::new();
    let said = in_one_line(&place.good(&["simulate", "--sites", "20", "--out", "a.npz"]));
    let (_, end) = said.split_once("--end-time ").expect("an end to type");
    let end = end.split_whitespace().next().unwrap().to_owned();
    let said = place.says(&format!("simulate --sites 20 --end-time {end} --out b.npz"));
    assert!(!said.contains("--end-time"), "{said}");
    let peak = |name: &str| {
        let read = wavecascade::report::RunFile::read(&place.path(name));
        let run = read.unwrap().run;
        let last = run.chain.n_contacts() - 1;
        let end = run.time[run.time.len() - 1];
        (run.peak_force(last).unwrap().time, end)
    };
    let (first, second) = (peak("a.npz"), peak("b.npz"));
    assert!(first.0 > 0.999 * first.1, "{first:?} {second:?}");
    assert!(second.0 < 0.98 * second.1, "{first:?} {second:?}");
    let free = place.says("simulate --sites 20 --ends free --out c.npz");
    assert!(!free.contains("--end-time"), "{free}");
}
