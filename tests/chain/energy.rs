//! What a chain must keep: energy between sites, momentum, and the scaling of its law.

use test_support::scenes::{apart, largest, rows, run, sized};
use wavecascade::chain::{Drive, Ends, Run};

/// Largest violation of `e_j(t) - e_j(0) = W_{j-1} - W_j + input_j - lost_j`, relative to the largest energy.
fn imbalance(run: &Run) -> f64 {
    let (chain, drive) = (&run.chain, run.drive.as_ref());
    let n = chain.n_sites();
    let energies = |sample: usize| {
        let x = run.displacement.as_ref().unwrap().row(sample).to_vec();
        let v = run.velocity.row(sample).to_vec();
        let wall = match drive {
            Some(Drive::Wall(wave)) => wave.at(run.time[sample]),
            _ => 0.0,
        };
        let mut out = vec![0.0; n];
        chain.site_energies(&x, &v, wall, &mut out);
        if let Some(own) = &chain.on_site.resonators {
            let [y, w] = run.resonators_at(sample);
            for j in 0..n {
                out[j] +=
                    0.5 * (own.mass[j] * w[j].powi(2) + own.stiffness[j] * (y[j] - x[j]).powi(2));
            }
        }
        out
    };
    let passed = |sample: usize, j: usize| match j < chain.n_contacts() {
        true => run.energy_passed.as_ref().unwrap()[[sample, j]],
        false => 0.0,
    };
    let start = energies(0);
    let (mut worst, mut total) = (0f64, start.iter().sum::<f64>());
    for sample in 0..run.time.len() {
        let now = energies(sample);
        total = total.max(now.iter().sum());
        let lost = |j: usize| {
            run.energy_lost
                .as_ref()
                .map_or(0.0, |lost| lost[[sample, j]])
        };
        let input = |j: usize| match (&run.energy_input, drive.map_or(0, Drive::site) == j) {
            (Some(input), true) => input[sample],
            _ => 0.0,
        };
        let before = |j: usize| match j {
            0 if chain.ends == Ends::Periodic => passed(sample, n - 1),
            0 => 0.0,
            _ => passed(sample, j - 1),
        };
        let grown = (0..n).map(|j| now[j] - start[j]);
        let came = (0..n).map(|j| before(j) - passed(sample, j) + input(j) - lost(j));
        worst = largest([worst, apart(grown, came)]);
    }
    worst / total
}

fn impact(kappa: f64, sites: usize, more: &str) -> Run {
    run(&format!(
        "sites = {sites}\nstiffness_ratio = {kappa:?}\n{more}"
    ))
}

#[test]
fn val_identity_energies_balance_with_losses_drive_and_other_ends() {
    let chains = rows(include_str!("chains.txt"));
    for ([name, _, keys], samples) in chains.zip([5, 40, 200].into_iter().cycle()) {
        let keys = format!("end_time = 15.0\nsamples = {samples}\n{keys}");
        let run = run(&sized(&keys, 20));
        let (off, drift) = (imbalance(&run), run.report.energy_drift.unwrap());
        println!("{name}: {off:.2e}, drift {drift:.1e}");
        assert!(off < 2e-11 && drift < 1e-11, "{name}: {off:e} {drift:e}");
    }
}

#[test]
fn val_identity_momentum_is_kept_until_the_wall_is_felt() {
    for kappa in [1.0, 4.9272, 1e4] {
        let run = impact(kappa, 80, "end_time = 30.0\nsamples = 60");
        let momentum = run.velocity.rows().into_iter().map(|row| row.sum());
        assert!(apart(momentum, [1.0; 60]) < 5e-14);
    }
}

/// `A x(A^{1/4} t)` solves the chain where `x(t)` does.
#[test]
fn val_scaling_of_the_amplitude() {
    let of = |speed: f64| {
        let end = 30.0 / speed.powf(0.2);
        let start = format!("striker_velocity = {speed:e}\nend_time = {end:?}\nsamples = 50");
        impact(4.9272, 40, &start).velocity / speed
    };
    let unit = of(1.0);
    for exponent in [-12, -3, 5, 12] {
        let off = apart(of(10f64.powi(exponent)), &unit);
        assert!(off < 1e-10, "1e{exponent}: {off:e}");
    }
}

#[test]
fn val_identity_drift_of_every_scheme() {
    for (scheme, step) in [
        ("velocity-verlet", 0.01),
        ("symplectic-4", 0.05),
        ("symplectic-6", 0.05),
    ] {
        let steps = format!("scheme = '{scheme}'\nstep = {step}\nend_time = 20.0\nsamples = 10");
        let run = impact(4.9272, 20, &steps);
        let (drift, off) = (run.report.energy_drift.unwrap(), imbalance(&run));
        println!("{scheme:?}: drift {drift:.1e}, imbalance {off:.1e}");
        assert!(drift < 2e-5 && off < 6e-5, "{scheme}: {drift:e} {off:e}");
    }
}
