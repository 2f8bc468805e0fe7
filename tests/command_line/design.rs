//! `cascade design`: files, what is printed, and what is refused.

use test_support::place::Place;

#[test]
fn a_design_is_written_and_replaced() {
    let place = Place::new();
    let text = "sites = 6\ncoefficients = [1, 1, 1, 1, 1, 1]\nend_time = 30.0\nsamples = 256\n";
    place.write("chain.toml", text);
    let design =
        "design chain.toml --free coefficients[]=0.2..5 --minimize peak_force_last --tries 300";
    let said = place.says(design);
    for part in [
        "the largest force of the last contact falls from 1.",
        "random",
    ] {
        assert!(said.contains(part), "{said}");
    }
    assert!(said.lines().count() <= 12, "{said}");
    let files = "summary.json design.npz design.toml report.html figures/design.png";
    place.has("chain-design", files);
    let found = place.json("chain-design/summary.json");
    assert_eq!(found["schema"], "cascade.design/1");
    // The scene found does what is said of it.
    place.says("sweep chain-design/design.toml --vary samples=256,512 --out again -q");
    let table = place.read("again/table.csv");
    let (head, row) = (table.lines().next().unwrap(), table.lines().nth(1).unwrap());
    let is_force = |name: &str| name.starts_with("peak_force_last");
    let column = head.split(',').position(is_force).unwrap();
    let force: f64 = row.split(',').nth(column).unwrap().parse().unwrap();
    let after = found["after"].as_f64().unwrap();
    assert!((force - after).abs() < 1e-6 * after, "{force} {after}");

    place.refuses(2, design);
    place.says(&format!("{design} --force -q"));
}
