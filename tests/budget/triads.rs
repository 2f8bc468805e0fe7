//! Transfer by triads: against the change of energy, and refused where it has no meaning.

use std::f64::consts::TAU;
use test_support::fields::{chain, fixed, spring};
use wavecascade::budget::{Motion, Triads, TriadsRequest, chain_triads};
use wavecascade::chain::{Accuracy, Chain, Ends, Record, Run, Simulation};
use wavecascade::observer::Silent;

fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

fn alpha_chain(ends: Ends, sites: usize) -> Chain {
    chain(
        vec![1.5; sites],
        vec![2.0; if ends == Ends::Free { sites - 1 } else { sites }],
        spring(0.25, 0.0),
        ends,
    )
}

fn run(chain: Chain, start: impl Fn(f64) -> f64, end: f64, samples: usize) -> Run {
    let sites = chain.n_sites();
    let mut simulation = Simulation::impact(chain, 1.0, end, samples);
    for (j, v) in simulation.velocity.iter_mut().enumerate() {
        *v = start(j as f64 / sites as f64);
    }
    simulation.accuracy = Accuracy::LocalError(1e-12);
    simulation.estimate_error = false;
    simulation.record = Record::ALL;
    simulation.run(&Silent).unwrap()
}

fn triads(run: &Run, request: &TriadsRequest) -> Triads {
    chain_triads(&Motion::of(run).unwrap(), 1.0, request, &Silent).unwrap()
}

/// What each wavenumber has at the end and not at the start is what its pairs gave it.
#[test]
fn val_energy_of_alpha_chains_by_wavenumber() {
    let fixed = fixed(2.0);
    let cases = [
        (alpha_chain(Ends::Periodic, 24), 24),
        (alpha_chain(Ends::Periodic, 25), 25),
        (alpha_chain(fixed, 15), 32),
    ];
    for (chain, period) in cases {
        let wave = |x: f64| 0.4 * (TAU * x).sin() + 0.3 * (2.0 * TAU * x).cos();
        let run = run(chain, wave, 40.0, 4001);
        let found = triads(&run, &TriadsRequest::default());
        assert_eq!(found.wavenumber.len(), period / 2 + 1);
        let energy = run.chain.energy(
            run.displacement
                .as_ref()
                .unwrap()
                .row(0)
                .as_slice()
                .unwrap(),
            run.velocity.row(0).as_slice().unwrap(),
            0.0,
        );
        assert!((found.energy / energy - 1.0).abs() < 1e-14);
        let scale = largest(&found.change);
        assert!(scale > 0.05 * energy);
        let off = largest(&found.unexplained()) / scale;
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
    let wave = |x: f64| 0.4 * (6.0 * TAU * x).sin() + 0.3 * (4.0 * TAU * x).cos();
    let run = run(alpha_chain(Ends::Periodic, 16), wave, 3.0, 601);
    let found = triads(&run, &TriadsRequest::default());
    let umklapp = &found.umklapp;
    // 6 + 6 + 4 = 16.
    let of_six = umklapp[[4, 6]];
    assert!(of_six.abs() > 1e-3 * found.energy);
    assert!((umklapp[[6, 6]] + of_six).abs() < 1e-12 * of_six.abs());
    let off = largest(&found.unexplained()) / largest(&found.change);
    assert!((1e-7..1e-4).contains(&off), "{off:e}");
}

/// Of a precompressed Hertz chain the terms beyond the quadratic one move less the weaker the waves are.
#[test]
fn val_expansion_of_pressed_contacts() {
    let mut shares = Vec::new();
    for amplitude in [0.02, 0.04] {
        let chain = Chain {
            precompression: 1.0,
            ends: Ends::Periodic,
            ..Chain::dimer(32, 1.0)
        };
        let wave = |x: f64| amplitude * ((TAU * x).sin() + (2.0 * TAU * x).sin());
        let run = run(chain, wave, 10.0, 801);
        let found = triads(&run, &TriadsRequest::default());
        let law = found.law;
        // F = delta^1.5 about 1.
        assert!((law.linear - 1.5).abs() < 1e-15 && (law.quadratic - 0.375).abs() < 1e-15);
        let off = largest(&found.unexplained()) / largest(&found.gained);
        assert!(off < 2e-4, "{off:e}");
        assert!(found.is_quadratic());
        shares.push(found.share_beyond());
    }
    let growth = shares[1] / shares[0];
    assert!((1.8..2.6).contains(&growth), "{shares:?}");
}
