//! What a chain must keep: energy between sites, momentum, and the scaling of its law.

use test_support::fields::{fixed, losses, spring};
use wavecascade::chain::{
    Accuracy, Chain, Drive, Ends, Law, Record, Run, Scheme, Simulation, Waveform,
};
use wavecascade::observer::Silent;

/// Largest violation of `e_j(t) - e_j(0) = W_{j-1} - W_j - lost_j`, relative to `largest`.
fn imbalance(run: &Run) -> f64 {
    imbalance_with_wall(run, |_| 0.0)
}

/// The same with the displacement of the wall before site 0.
fn imbalance_with_wall(run: &Run, wall: impl Fn(f64) -> f64) -> f64 {
    let chain = &run.chain;
    let n = chain.n_sites();
    let (x, v) = (run.displacement.as_ref().unwrap(), &run.velocity);
    let passed = run.energy_passed.as_ref().unwrap();
    let energies = |sample: usize| {
        let mut out = vec![0.0; n];
        let (x, v) = (x.row(sample).to_vec(), v.row(sample).to_vec());
        chain.site_energies(&x, &v, wall(run.time[sample]), &mut out);
        out
    };
    let start = energies(0);
    let (mut worst, mut total) = (0f64, start.iter().sum::<f64>());
    for sample in 0..run.time.len() {
        let now = energies(sample);
        total = total.max(now.iter().sum());
        for j in 0..n {
            let from = match j {
                0 if chain.ends == Ends::Periodic => passed[[sample, n - 1]],
                0 => run.energy_input.as_ref().map_or(0.0, |input| input[sample]),
                _ => passed[[sample, j - 1]],
            };
            let to = if j < chain.n_contacts() {
                passed[[sample, j]]
            } else {
                0.0
            };
            let lost = run
                .energy_lost
                .as_ref()
                .map_or(0.0, |lost| lost[[sample, j]]);
            worst = worst.max((now[j] - start[j] - (from - to - lost)).abs());
        }
    }
    worst / total
}

fn impact(chain: Chain, end: f64, samples: usize) -> Simulation {
    let mut simulation = Simulation::impact(chain, 1.0, end, samples);
    simulation.record = Record::ALL;
    simulation
}

#[test]
fn val_identity_site_energies_balance_at_the_default_tolerance() {
    for kappa in [1.0, 2.398, 4.9272, 1631.0, 1e6] {
        for samples in [5, 200] {
            let run = impact(Chain::dimer(40, kappa), 60.0, samples)
                .run(&Silent)
                .unwrap();
            let off = imbalance(&run);
            println!("{kappa} {samples}: {off:.2e}");
            assert!(off < 1e-11, "{kappa} {samples}: {off:e}");
        }
    }
}

#[test]
fn val_identity_energies_balance_with_losses_drive_and_other_ends() {
    let mut lossy = impact(Chain::dimer(20, 3.0), 20.0, 40);
    lossy.scheme = Scheme::RungeKutta;
    lossy.chain.losses = losses([0.0, 0.02, 0.01]);
    let mut pressed = impact(Chain::dimer(20, 3.0), 15.0, 40);
    pressed.chain.precompression = 0.3;
    let mut held = impact(Chain::dimer(20, 2.0), 15.0, 40);
    held.chain.ends = fixed(1.0);
    held.chain.law = spring(0.25, 0.1).into();
    let mut driven = held.clone();
    driven.velocity[0] = 0.0;
    driven.drive = Some(Drive::Wall(Waveform::sine(0.3, 0.2)));
    let mut pushed = impact(Chain::dimer(20, 2.0), 15.0, 40);
    pushed.velocity[0] = 0.0;
    pushed.drive = Some(Drive::Force(Waveform::sine(0.3, 0.1)));
    let mut ring = impact(Chain::dimer(20, 2.0), 15.0, 40);
    ring.chain.ends = Ends::Periodic;
    ring.chain.law = spring(0.0, 0.5).into();
    let mut toda = ring.clone();
    toda.chain.law = Law::toda(0.8).into();
    let mut morse = driven.clone();
    morse.chain.law = Law::morse(0.5).into();
    // The closing contact of a ring loses energy once.
    let mut lossy_ring = ring.clone();
    lossy_ring.scheme = Scheme::RungeKutta;
    lossy_ring.chain.losses = losses([0.02, 0.01, 0.01]);
    // The wall's velocity jumps where the drive ends, at no sample.
    let mut shoved = pressed.clone();
    shoved.chain.ends = fixed(1.0);
    shoved.velocity[0] = 0.0;
    shoved.drive = Some(Drive::Wall(Waveform::half_sine(0.2, 3.1234)));
    let mut lossy_shoved = shoved.clone();
    lossy_shoved.scheme = Scheme::RungeKutta;
    lossy_shoved.chain.losses = lossy.chain.losses;
    for (name, simulation) in [
        ("toda", toda),
        ("morse", morse),
        ("lossy ring", lossy_ring),
        ("shoved", shoved),
        ("lossy and shoved", lossy_shoved),
        ("lossy", lossy),
        ("pressed", pressed),
        ("fixed", held),
        ("driven", driven),
        ("pushed", pushed),
        ("ring", ring),
    ] {
        let run = simulation.run(&Silent).unwrap();
        let off = imbalance_with_wall(&run, |t| match &simulation.drive {
            Some(Drive::Wall(wave)) => wave.at(t),
            _ => 0.0,
        });
        println!(
            "{name}: {off:.2e}, drift {:.1e}",
            run.report.energy_drift.unwrap()
        );
        assert!(off < 2e-11, "{name}: {off:e}");
        assert!(run.report.energy_drift.unwrap() < 1e-11, "{name}");
    }
}

#[test]
fn val_identity_momentum_is_kept_until_the_wall_is_felt() {
    for kappa in [1.0, 4.9272, 1e4] {
        let run = impact(Chain::dimer(80, kappa), 30.0, 60)
            .run(&Silent)
            .unwrap();
        for row in run.velocity.rows() {
            assert!((row.sum() - 1.0).abs() < 5e-14, "{:e}", row.sum() - 1.0);
        }
    }
}

/// `A x(A^{1/4} t)` solves the chain where `x(t)` does.
#[test]
fn val_scaling_of_the_amplitude() {
    let unit = impact(Chain::dimer(40, 4.9272), 30.0, 50)
        .run(&Silent)
        .unwrap();
    for exponent in [-12, -3, 5, 12] {
        let speed = 10f64.powi(exponent);
        let slower = speed.powf(0.2);
        let mut scaled = impact(Chain::dimer(40, 4.9272), 30.0 / slower, 50);
        scaled.velocity[0] = speed;
        let scaled = scaled.run(&Silent).unwrap();
        let off = unit
            .velocity
            .iter()
            .zip(&scaled.velocity)
            .fold(0.0, |worst: f64, (u, s)| worst.max((u - s / speed).abs()));
        println!("1e{exponent}: {off:.1e}");
        assert!(off < 1e-10, "1e{exponent}: {off:e}");
    }
}

#[test]
fn val_identity_drift_of_every_scheme() {
    for (scheme, step, most) in [
        (Scheme::VelocityVerlet, 0.01, 2e-5),
        (Scheme::Symplectic4, 0.05, 2e-5),
        (Scheme::Symplectic6, 0.05, 2e-5),
    ] {
        let mut simulation = impact(Chain::dimer(20, 4.9272), 20.0, 10);
        simulation.scheme = scheme;
        simulation.accuracy = Accuracy::Step(step);
        let run = simulation.run(&Silent).unwrap();
        let (drift, off) = (run.report.energy_drift.unwrap(), imbalance(&run));
        println!("{scheme:?}: drift {drift:.1e}, imbalance {off:.1e}");
        assert!(drift < most, "{scheme:?}: {drift:e} {off:e}");
        assert!(off < 3.0 * most, "{scheme:?}: {drift:e} {off:e}");
    }
}
