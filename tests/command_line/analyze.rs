//! `cascade analyze` as a stranger meets it: what it writes and prints, and where.

use test_support::place::Place;
use wavecascade::arrays::LargeArray;

/// Cells within six decades of the largest reach over half of both axes.
#[test]
fn pictures_of_the_shipped_scenes_are_filled() {
    let scenes = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/scenes");
    let place = Place::new();
    for scene in ["dimer", "quartz_cylinders"] {
        let path = scenes.join(format!("{scene}.toml"));
        let path = path.to_str().unwrap();
        place.good(&["simulate", path, "--out", "run.npz", "--force"]);
        let field = test_support::made::open(&place, "run.npz");
        let request = wavecascade::analyze::Request::default();
        let (analysis, _) = wavecascade::analyze(&field, &request).unwrap();
        let map = analysis.maps[&LargeArray::SPACETIME_SPECTRUM].shown();
        let level = 1e-6 * map.values.iter().copied().fold(0.0, f32::max);
        let (rows, columns) = map.values.dim();
        let (mut top, mut left, mut right) = (0, columns, 0);
        for ((row, column), value) in map.values.indexed_iter() {
            if *value > level {
                top = top.max(row + 1);
                (left, right) = (left.min(column), right.max(column + 1));
            }
        }
        assert!(2 * top > rows, "{scene}: {top} of {rows}");
        let width = right - left;
        assert!(2 * width > columns, "{scene}: {width} of {columns}");
        assert!(rows > 60 && columns > 20, "{scene}: {rows} x {columns}");
    }
}
