//! The transform in twice the precision against transforms that are known exactly.

use std::f64::consts::PI;

use test_support::near;
use test_support::shared::dft_dd;

#[test]
fn a_delta_gives_the_roots_of_unity_correctly_rounded() {
    let third = 0.75_f64.sqrt();
    let eighth = 0.5_f64.sqrt();
    for (place, n, bin, expected) in [
        (0, 7, 3, (1.0, 0.0)),
        (1, 12, 1, (third, -0.5)),
        (5, 12, 1, (-third, -0.5)),
        (7, 12, 1, (-third, 0.5)),
        (3, 12, 9, (0.0, -1.0)),
        (3, 8, 5, (eighth, eighth)),
        (1, 8, 2, (0.0, -1.0)),
    ] {
        let mut x = vec![0.0; n];
        x[place] = 1.0;
        assert_eq!(dft_dd(&x, &[bin]), [expected]);
    }
}

/// `x_n = n` has the transform `-N/2 + i (N/2) cot(pi p / N)`.
#[test]
fn a_ramp_gives_its_real_part_to_the_last_bit() {
    for n in [12, 255, 1000, 4096] {
        let x: Vec<f64> = (0..n).map(|i| i as f64).collect();
        let bins: Vec<usize> = (1..n).step_by(n / 11).collect();
        for (bin, (re, im)) in bins.iter().zip(dft_dd(&x, &bins)) {
            let half = n as f64 / 2.0;
            let nearest = (n - bin).min(*bin) as f64;
            let cotangent = 1.0 / (PI * nearest / n as f64).tan();
            assert_eq!(re, -half);
            near(im.abs(), half * cotangent, 1e-15 * (half + im.abs()));
        }
    }
    let x: Vec<f64> = (0..4096).map(f64::from).collect();
    let expected = [(-2048.0, 2048.0), (-2048.0, -2048.0)];
    assert_eq!(dft_dd(&x, &[1024, 3072]), expected);
}

#[test]
fn a_tone_on_its_bin_stands_alone() {
    let x = [1.0, 0.5, -0.5, -1.0, -0.5, 0.5];
    let transform = dft_dd(&x, &[0, 1, 2, 3, 4, 5]);
    for ((re, im), expected) in transform.into_iter().zip([0.0, 3.0, 0.0, 0.0, 0.0, 3.0]) {
        near(re, expected, 1e-30);
        near(im, 0.0, 1e-30);
    }
}

#[test]
fn large_terms_cancel_without_loss() {
    assert_eq!(dft_dd(&[1e16, 1.0, -1e16, 1.0], &[0])[0].0, 2.0);
    assert_eq!(dft_dd(&[1e16, 1.0, 1e16, 1.0], &[1, 2])[0].0, 0.0);
}
