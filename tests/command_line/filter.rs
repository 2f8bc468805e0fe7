//! `cascade filter` as a stranger meets it.

use ndarray::Array2;
use test_support::made::{open, values};
use test_support::place::Place;

/// Waves towards +x, towards -x and nowhere are together the field, as are bands side by side; axes
/// and units stay.
#[test]
fn val_parts_are_together_the_field() {
    let place = Place::new();
    place.says(
        "simulate --sites 40 --material steel --shape sphere --radius 9.5mm --striker-velocity 1 \
         --samples 300 --out run.npz",
    );
    let run = open(&place, "run.npz");
    let whole = values(&run);
    let largest = |of: &Array2<f64>| of.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    for parts in [
        &["--towards plus-x", "--towards minus-x", "--towards nowhere"][..],
        &["--frequency :10000", "--frequency 10000.0001:"],
        &["--wavenumber 0:50 --pad", "--wavenumber 50.0001: --pad"],
    ] {
        let mut sum = Array2::zeros(whole.dim());
        for part in parts {
            place.says(&format!("filter run.npz --force --out part.npz {part}"));
            let field = open(&place, "part.npz");
            assert_eq!((&field.unit, &field.time.unit), (&run.unit, &run.time.unit));
            assert!((field.time.step / run.time.step - 1.0).abs() < 1e-12);
            assert!((field.space.step / run.space.step - 1.0).abs() < 1e-12);
            sum += &values(&field);
        }
        let off = largest(&(&sum - &whole)) / largest(&whole);
        assert!(off < 2e-15, "{parts:?}: {off:e}");
    }
    // An impact at site 0 runs towards +x.
    let said = place.says("filter run.npz --towards plus-x --pad --out plus.npz");
    let share = said.split_once(" %").unwrap().0.rsplit(' ').next().unwrap();
    let share: f64 = share.parse().unwrap();
    assert!((85.0..100.0).contains(&share), "{said}");
    let said = place.says("filter run.npz --speed 1: --json --out fast.npz");
    assert!(said.contains("energy_after"), "{said}");
}
