//! What holds of all estimates, by the rows of `identities.txt`.

use ndarray::{Array2, s};
use test_support::estimate::{Seen, seen};
use test_support::fields::{noise, passing};
use test_support::{near, worst};
use wavecascade::Field;

use crate::peers::{field, rows};

pub fn section(name: &str) -> impl Iterator<Item = Vec<&'static str>> {
    rows(include_str!("identities.txt"), name)
}

#[track_caller]
pub fn assert_undefined(found: &Seen, names: &str) {
    for name in names.split(' ') {
        let is_undefined = found.array(name).iter().all(|v| v.is_nan());
        assert!(is_undefined, "{name}: {}", found.answer);
    }
}

/// A pulse, one behind an offset, one that noise hides over the smallest lag, and two that are in the array all the time, so that the
/// energy of all sites together is steady.
#[test]
fn regress_one_transient_has_no_significance() {
    let clear = passing((2048, 6), 300.0, 5.0, 6.0);
    let hidden = passing((2048, 6), 300.0, 5.0, 20.0) + 0.03 * noise(2048, 6);
    let pulses = [
        &clear - 0.8,
        hidden,
        passing((512, 48), 20.0, 10.0, 12.0),
        passing((2048, 64), 20.0, 31.0, 6.0),
        clear,
    ]
    .map(field);
    for row in section("one transient") {
        for pulse in &pulses {
            let one = seen(row[0], [pulse]).unwrap();
            assert_undefined(&one, row[1]);
            let is_silent = one.answer.contains("cannot be told");
            assert!(
                is_silent || !row[0].starts_with("bicoherence"),
                "{}",
                one.answer
            );
        }
        // Repeated, it has: as many as there are records.
        let five = seen(row[0], [&pulses[0]; 5]).unwrap().array(row[2]);
        near(five[[five.nrows() / 3, 0]], row[3].parse().unwrap(), 1e-12);
    }
}

#[test]
fn val_records_count_as_segments() {
    let values = noise(1024, 9);
    let parts = values.exact_chunks((256, 9)).into_iter();
    let parts: Vec<Field> = parts.map(|part| field(part.to_owned())).collect();
    for row in section("records") {
        let one = seen(row[0], [&field(values.clone())]).unwrap();
        let several = seen(row[0], &parts).unwrap();
        for name in row[1].split(' ') {
            let [a, b] = [&one, &several].map(|seen| seen.array(name));
            let pairs = a.iter().zip(&b).filter(|(a, _)| a.is_finite());
            assert!(pairs.clone().count() > 30, "{} {name}", row[0]);
            let error = worst(pairs.map(|(a, b)| (a - b).abs() / a.abs()));
            assert!(error < 1e-10, "{} {name}: {error:e}", row[0]);
        }
    }
}

#[test]
fn regress_powers_of_two_do_not_move_a_bit() {
    let values = noise(600, 12);
    for row in section("powers of two") {
        let plain = seen(row[0], [&field(values.clone())]).unwrap();
        let largest: i32 = row[1].parse().unwrap();
        for exponent in [-largest, -40, 60, largest] {
            let scaled = seen(row[0], [&field(&values * 2f64.powi(exponent))]).unwrap();
            for array in row[2].split(' ') {
                let (name, power) = array.split_once('^').unwrap();
                let factor = 2f64.powi(exponent * power.parse::<i32>().unwrap());
                let bits = |values: Array2<f64>| values.mapv(f64::to_bits);
                let expected = plain.array(name) * factor;
                assert!(expected.iter().any(|v| v.abs() > 0.0), "{row:?} {name}");
                let is_same = bits(scaled.array(name)) == bits(expected);
                assert!(is_same, "{row:?} {name} 2^{exponent}");
            }
        }
    }
}

#[test]
fn regress_a_silent_site_has_nothing_in_common() {
    let mut values = noise(600, 9);
    values.column_mut(0).fill(0.0);
    values.column_mut(2).fill(3.0);
    let (site, still) = (field(values), field(Array2::zeros((45, 9))));
    for row in section("silent") {
        let made = if row[0] == "site" { &site } else { &still };
        let found = seen(row[1], [made]).unwrap();
        assert_undefined(&found, row[2]);
        let is_said = row.get(3).is_none_or(|words| found.answer.contains(words));
        assert!(is_said, "{}", found.answer);
        // Densities of 0 there, and not elsewhere.
        if let Some(spectrum) = found.arrays.get("spectrum") {
            let still = spectrum.column(0).iter().all(|s| *s == 0.0);
            let offset = spectrum.column(2).iter().all(|s| *s < 1e-28);
            let moves = spectrum.column(1).iter().any(|s| *s > 0.0);
            assert!(still && offset && moves == (row[0] == "site"), "{row:?}");
        }
    }
}

/// One pulse at one site of many: tapers along space see the same.
#[test]
fn regress_energy_at_one_site_has_no_degrees_along_space() {
    let mut values = 1e-3 * noise(512, 32);
    values.slice_mut(s![.., 7]).mapv_inplace(|v| 1e3 * v);
    let words = "spacetime tapers=3:5 space-tapers=2:3 detrend=none equal";
    let found = seen(words, [&field(values)]).unwrap();
    near(found.array("degrees_of_freedom")[[100, 10]], 10.0, 1e-6);
}
