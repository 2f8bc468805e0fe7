//! The transform in twice the precision against transforms that are known exactly.

use test_support::shared::dft_dd;

#[test]
fn a_delta_gives_the_roots_of_unity_correctly_rounded() {
    let at = |place: usize, n: usize, bin: usize| {
        let mut x = vec![0.0; n];
        x[place] = 1.0;
        dft_dd(&x, &[bin])[0]
    };
    let third = 0.75_f64.sqrt();
    let eighth = 0.5_f64.sqrt();
    assert_eq!(at(0, 7, 3), (1.0, 0.0));
    assert_eq!(at(1, 12, 1), (third, -0.5));
    assert_eq!(at(5, 12, 1), (-third, -0.5));
    assert_eq!(at(7, 12, 1), (-third, 0.5));
    assert_eq!(at(3, 12, 9), (0.0, -1.0));
    assert_eq!(at(3, 8, 5), (eighth, eighth));
    assert_eq!(at(1, 8, 2), (0.0, -1.0));
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
            let cotangent = 1.0 / (std::f64::consts::PI * nearest / n as f64).tan();
            assert_eq!(re, -half);
            let error = im.abs() - half * cotangent;
            assert!(
                error.abs() < 1e-15 * (half + im.abs()),
                "{n} {bin}: {error:e}"
            );
        }
    }
    let x: Vec<f64> = (0..4096).map(f64::from).collect();
    assert_eq!(
        dft_dd(&x, &[1024, 3072]),
        [(-2048.0, 2048.0), (-2048.0, -2048.0)]
    );
}

#[test]
fn a_tone_on_its_bin_stands_alone() {
    let x = [1.0, 0.5, -0.5, -1.0, -0.5, 0.5];
    let transform = dft_dd(&x, &[0, 1, 2, 3, 4, 5]);
    for (bin, (re, im)) in transform.into_iter().enumerate() {
        let expected = if bin == 1 || bin == 5 { 3.0 } else { 0.0 };
        assert!((re - expected).abs() < 1e-30 && im.abs() < 1e-30, "{bin}");
    }
}

#[test]
fn large_terms_cancel_without_loss() {
    assert_eq!(dft_dd(&[1e16, 1.0, -1e16, 1.0], &[0])[0].0, 2.0);
    assert_eq!(dft_dd(&[1e16, 1.0, 1e16, 1.0], &[1, 2])[0].0, 0.0);
}
