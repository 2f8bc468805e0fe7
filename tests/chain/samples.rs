//! Samples inside steps: they change no step, and are as accurate as the run says.

use wavecascade::chain::{Accuracy, Chain, Drive, Ends, Law, Record, Run, Simulation, Waveform};
use wavecascade::observer::Silent;

fn run(simulation: &Simulation, samples: usize) -> Run {
    let mut simulation = simulation.clone();
    simulation.samples = samples;
    simulation.run(&Silent).unwrap()
}

fn last(run: &Run) -> Vec<u64> {
    let last = run.time.len() - 1;
    let rows = [
        Some(&run.velocity),
        run.displacement.as_ref(),
        run.force.as_ref(),
        run.energy_passed.as_ref(),
    ];
    let rows = rows.into_iter().flatten();
    rows.flat_map(|row| row.row(last).map(|v| v.to_bits()).to_vec())
        .collect()
}

#[test]
fn regress_samples_change_no_step_and_no_bit() {
    let mut simulation = Simulation::impact(Chain::dimer(60, 4.9272), 1.0, 50.0, 2);
    for (tolerance, expected) in [
        (1e-5, [35_832, 80_816, 631_968]),
        (1e-9, [27_880, 63_232, 480_464]),
    ] {
        simulation.accuracy = Accuracy::Tolerance(tolerance);
        let two = run(&simulation, 2);
        let mut found = [0; 3];
        for (found, samples) in found.iter_mut().zip([64, 300, 4096]) {
            let many = run(&simulation, samples);
            assert_eq!(last(&two), last(&many), "{tolerance:e} {samples}");
            let (few, cost) = (two.report.cost, many.report.cost);
            assert_eq!(few.steps, cost.steps);
            assert_eq!(few.forces, cost.forces);
            assert_eq!(few.rejected_steps, cost.rejected_steps);
            assert_eq!(two.report.error, many.report.error);
            *found = cost.sampling_forces;
        }
        assert_eq!(found, expected, "{tolerance:e}");
    }
}

/// At the samples of a run with finer steps, which end elsewhere.
#[test]
fn val_convergence_samples_are_as_accurate_as_stated() {
    let dimer = |kappa: f64| Simulation::impact(Chain::dimer(40, kappa), 1.0, 40.0, 1024);
    let mut power = dimer(3.0);
    power.chain.law = Law::Power { exponent: 2.5 };
    let mut pressed = dimer(3.0);
    pressed.chain.precompression = 0.01;
    let mut springs = dimer(2.0);
    springs.chain.law = Law::Spring {
        alpha: 0.25,
        beta: 0.5,
    };
    let mut ring = dimer(2.0);
    ring.chain.ends = Ends::Periodic;
    let wave = Waveform::HalfSine {
        amplitude: 2.0,
        duration: 3.0,
    };
    let mut pushed = dimer(2.0);
    pushed.velocity[0] = 0.0;
    pushed.drive = Some(Drive::Force(wave));
    let mut flights = dimer(5.0);
    flights.velocity.iter_mut().enumerate().for_each(|(j, v)| {
        *v = [1.0, -0.5, 0.1, 0.3, -0.9][j % 5];
    });
    for (name, mut simulation) in [
        ("1", dimer(1.0)),
        ("4.9272", dimer(4.9272)),
        ("1631", dimer(1631.0)),
        ("power", power),
        ("pressed", pressed),
        ("springs", springs),
        ("ring", ring),
        ("pushed", pushed),
        ("flights", flights),
    ] {
        simulation.accuracy = Accuracy::Tolerance(1e-11);
        let fine = run(&simulation, 1024);
        for tolerance in [1e-4, 1e-7] {
            simulation.accuracy = Accuracy::Tolerance(tolerance);
            let found = run(&simulation, 1024);
            let pairs = found.velocity.iter().zip(&fine.velocity);
            let off = pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()));
            let off = off / found.report.velocity_scale;
            let stated = found.report.error.unwrap();
            println!("{name} {tolerance:e}: {off:.1e}, stated {stated:.1e}");
            assert!(off <= stated, "{name} {tolerance:e}: {off:e} {stated:e}");
            // The momentum, which forces and displacements share with the velocities.
            let forces = found.force.as_ref().unwrap();
            let pairs = forces.iter().zip(fine.force.as_ref().unwrap());
            let largest = forces.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
            let off = pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()));
            println!("    forces {:.1e}", off / largest);
            assert!(
                off < 30.0 * stated * largest,
                "{name} {tolerance:e}: {off:e}"
            );
        }
    }
}

/// The energy that has passed is that of the sites behind, at each sample.
#[test]
fn val_balance_energies_inside_steps() {
    let mut simulation = Simulation::impact(Chain::dimer(40, 4.9272), 1.0, 40.0, 2048);
    simulation.accuracy = Accuracy::Tolerance(1e-9);
    simulation.record = Record::ALL;
    let run = simulation.run(&Silent).unwrap();
    let (x, passed) = (
        run.displacement.as_ref().unwrap(),
        run.energy_passed.as_ref().unwrap(),
    );
    let chain = &run.chain;
    let mut worst = 0.0f64;
    for sample in 0..2048 {
        let (x, v) = (x.row(sample), run.velocity.row(sample));
        let mut behind = 0.0;
        for j in 0..39 {
            let overlap = x[j] - x[j + 1];
            let energy = chain.law.energy(chain.coefficient[j], 0.0, overlap);
            // Half of the energy of a contact is that of the site behind it.
            behind += 0.5 * chain.mass[j] * v[j] * v[j] + 0.5 * energy;
            let off = behind + passed[[sample, j]] - 0.5 * chain.mass[0];
            worst = worst.max(off.abs());
            behind += 0.5 * energy;
        }
    }
    println!("{worst:e}");
    assert!(worst < 2e-11, "{worst:e}");
}
