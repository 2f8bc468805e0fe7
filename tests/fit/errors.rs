//! Records that cannot be fitted are refused, and say why; wrong options are rows of `command_line/refusals.txt`.

use ndarray::Array2;
use wavecascade::Field;
use wavecascade::chain::scene::SceneSource;
use wavecascade::observer::Silent;

use super::made::Measurement;

const SCENE: &str = "sites = 6\nstiffness_ratio = 2.0";

#[test]
fn what_is_wrong_is_named() {
    let made = Measurement::of(&[1, 4], 100, 8.0);
    let of_size = |size| Field::from_array(Array2::from_elem((100, 2), size));
    let few = Measurement::of(&[1, 4], 3, 8.0).measured(SCENE);
    for (field, named) in [
        (of_size(1e155), "of which the largest is"),
        (of_size(1e-155), "of which the largest is"),
        (few, "samples or more"),
    ] {
        let request = made.request(&["stiffness_ratio"]);
        let error = request.run(&field, &SceneSource::new(None, SCENE), &Silent);
        let error = error.unwrap_err();
        assert!(
            error.is_usage() && error.to_string().contains(named),
            "{error}"
        );
    }
}
