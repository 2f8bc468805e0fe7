//! `cascade sweep`, and chains in SI with their units.

use test_support::made::in_one_line;
use test_support::place::Place;

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
