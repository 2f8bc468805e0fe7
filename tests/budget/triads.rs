//! Transfer by triads: against the change of energy, and refused where it has no meaning.

use std::f64::consts::TAU;

use test_support::scenes::{largest, simulation};
use wavecascade::budget::{Motion, Triads, TriadsRequest, chain_triads};
use wavecascade::chain::{Accuracy, Run};
use wavecascade::observer::Silent;

const ALPHA: &str = "law = 'spring'\nalpha = 0.25\nmass_cell = [1.5]\ncoefficient_cell = [2.0]\n";

/// A run whose velocities are a wave along the chain at first, and its triads.
fn triads(keys: &str, wave: impl Fn(f64) -> f64) -> (Run, Triads) {
    let mut simulation = simulation(keys);
    let sites = simulation.velocity.len() as f64;
    for (j, v) in simulation.velocity.iter_mut().enumerate() {
        *v = wave(j as f64 / sites);
    }
    simulation.accuracy = Accuracy::LocalError(1e-12);
    simulation.estimate_error = false;
    let run = simulation.run(&Silent).unwrap();
    let motion = Motion::of(&run).unwrap();
    let found = chain_triads(&motion, 1.0, &TriadsRequest::default(), &Silent).unwrap();
    (run, found)
}

/// What each wavenumber has at the end and not at the start is what its pairs gave it.
#[test]
fn val_energy_of_alpha_chains_by_wavenumber() {
    for (sites, ends, period) in [
        (24, "periodic", 24),
        (25, "periodic", 25),
        (15, "fixed", 32),
    ] {
        let keys =
            format!("{ALPHA}sites = {sites}\nends = '{ends}'\nend_time = 40.0\nsamples = 4001");
        let wave = |x: f64| 0.4 * (TAU * x).sin() + 0.3 * (2.0 * TAU * x).cos();
        let (run, found) = triads(&keys, wave);
        assert_eq!(found.wavenumber.len(), period / 2 + 1);
        let [x, v] =
            [run.displacement.as_ref().unwrap(), &run.velocity].map(|of| of.row(0).to_vec());
        let energy = run.chain.energy(&x, &v, 0.0);
        assert!((found.energy / energy - 1.0).abs() < 1e-14);
        let scale = largest(&found.change);
        assert!(scale > 0.05 * energy);
        let off = largest(found.unexplained()) / scale;
        // The trapezoid rule over the samples.
        assert!((1e-9..2e-6).contains(&off), "{period}: {off:e}");
        let stated = found.sampling_error / scale;
        assert!((1e-9..1e-5).contains(&stated), "{stated:e} {off:e}");
        assert!(stated > 0.3 * off, "{stated:e} {off:e}");
        let of = found.identities;
        assert!(of.detailed < 1e-12 && of.sums < 1e-12, "{of:?}");
        assert!(found.beyond.is_none() && found.is_quadratic());
    }
}

/// Umklapp: three wavenumbers of a full turn per site, from two waves of 3/8 of it and of 1/4.
#[test]
fn val_waves_that_add_up_to_a_turn() {
    let keys = format!("{ALPHA}sites = 16\nends = 'periodic'\nend_time = 3.0\nsamples = 601");
    let wave = |x: f64| 0.4 * (6.0 * TAU * x).sin() + 0.3 * (4.0 * TAU * x).cos();
    let (_, found) = triads(&keys, wave);
    // 6 + 6 + 4 = 16.
    let of_six = found.umklapp[[4, 6]];
    assert!(of_six.abs() > 1e-3 * found.energy);
    assert!((found.umklapp[[6, 6]] + of_six).abs() < 1e-12 * of_six.abs());
    let off = largest(found.unexplained()) / largest(&found.change);
    assert!((1e-7..1e-4).contains(&off), "{off:e}");
}

/// Of a precompressed Hertz chain the terms beyond the quadratic one move less the weaker the waves are.
#[test]
fn val_expansion_of_pressed_contacts() {
    let keys =
        "sites = 32\nends = 'periodic'\nprecompression = 1.0\nend_time = 10.0\nsamples = 801";
    let shares = [0.02, 0.04].map(|amplitude| {
        let wave = |x: f64| amplitude * ((TAU * x).sin() + (2.0 * TAU * x).sin());
        let (_, found) = triads(keys, wave);
        // F = delta^1.5 about 1.
        let law = found.law;
        assert!((law.linear - 1.5).abs() < 1e-15 && (law.quadratic - 0.375).abs() < 1e-15);
        let off = largest(found.unexplained()) / largest(&found.gained);
        assert!(off < 2e-4, "{off:e}");
        assert!(found.is_quadratic());
        found.share_beyond()
    });
    let growth = shares[1] / shares[0];
    assert!((1.8..2.6).contains(&growth), "{shares:?}");
}
