//! Many chains at once: the same bits as each alone, from any number of threads.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use test_support::changed;
use wavecascade::Error;
use wavecascade::chain::{
    Accuracy, Chain, EndTime, Law, Losses, Record, Run, Scheme, Simulation, run_each,
};
use wavecascade::observer::{Observer, Silent};

fn fixed(kappa: f64, scheme: Scheme) -> Simulation {
    let mut simulation = Simulation::impact(Chain::dimer(45, kappa), 1.0, 40.0, 9);
    simulation.scheme = scheme;
    simulation.accuracy = Accuracy::Step(0.03);
    simulation.record = changed(Record::ALL, |it| it.energy = false);
    simulation
}

/// The results in the order of the simulations.
fn run_many(simulations: &[Simulation], observer: &dyn Observer) -> Vec<wavecascade::Result<Run>> {
    let slots: Vec<OnceLock<_>> = simulations.iter().map(|_| OnceLock::new()).collect();
    run_each(simulations, observer, &|i, result| {
        assert!(slots[i].set(result).is_ok());
    });
    slots
        .into_iter()
        .map(|slot| slot.into_inner().unwrap())
        .collect()
}

/// Chains of every kind.
fn mixture() -> Vec<Simulation> {
    let mut all: Vec<Simulation> = Scheme::ALL[2..]
        .iter()
        .map(|scheme| fixed(2.0, *scheme))
        .collect();
    let mut pressed = fixed(2.0, Scheme::VelocityVerlet);
    pressed.chain.precompression = 0.1;
    let mut power = fixed(2.0, Scheme::VelocityVerlet);
    power.chain.law = Law::Power { exponent: 2.0 }.into();
    let mut adaptive = fixed(2.0, Scheme::Nystrom);
    adaptive.accuracy = Accuracy::Tolerance(1e-6);
    let mut lossy = adaptive.clone();
    lossy.scheme = Scheme::RungeKutta;
    lossy.chain.losses = changed(Losses::default(), |it| it.drag = 0.01);
    all.extend([pressed, power, adaptive, lossy]);
    all
}

fn bits(run: &Run) -> Vec<u64> {
    let arrays = [
        Some(&run.velocity),
        run.displacement.as_ref(),
        run.force.as_ref(),
    ];
    let values = arrays.into_iter().flatten().flat_map(|array| array.iter());
    // Zeros of either sign are the same number.
    values.map(|v| (v + 0.0).to_bits()).collect()
}

#[test]
fn val_each_chain_alone_and_any_number_of_threads() {
    let all = mixture();
    let alone: Vec<Run> = all.iter().map(|s| s.run(&Silent).unwrap()).collect();
    for threads in [1, 2, 4] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        let many = pool.install(|| run_many(&all, &Silent));
        for (i, (one, run)) in alone.iter().zip(many).enumerate() {
            let run = run.unwrap();
            assert_eq!(bits(one), bits(&run), "{i}: {:?}", all[i].scheme);
            assert_eq!(one.report.cost.steps, run.report.cost.steps);
            assert_eq!(one.report.energy_drift, run.report.energy_drift);
        }
    }
}

/// Asked so many times whether to stop, says so.
struct Fuse(AtomicUsize);

impl Observer for Fuse {
    fn cancelled(&self) -> bool {
        let left = self.0.load(Ordering::SeqCst);
        self.0.store(left.saturating_sub(1), Ordering::SeqCst);
        left == 0
    }
}

#[test]
fn val_cancelling_leaves_no_chain_unanswered() {
    let all = mixture();
    let answered = AtomicUsize::new(0);
    let cancelled = AtomicUsize::new(0);
    run_each(&all, &Fuse(AtomicUsize::new(2)), &|_, result| {
        answered.fetch_add(1, Ordering::Relaxed);
        if matches!(result, Err(Error::Cancelled)) {
            cancelled.fetch_add(1, Ordering::Relaxed);
        }
    });
    assert_eq!(answered.into_inner(), all.len());
    assert!(cancelled.into_inner() > 0);
}

#[test]
fn val_memory_is_asked_for_before_the_work() {
    let mut simulation = fixed(2.0, Scheme::VelocityVerlet);
    simulation.memory = Some(simulation.bytes() - 1);
    for result in [
        simulation.run(&Silent),
        run_many(&[simulation.clone()], &Silent).remove(0),
    ] {
        let Err(Error::Memory {
            needed, allowed, ..
        }) = result
        else {
            panic!("no error of memory");
        };
        assert_eq!(needed, allowed + 1);
    }
    simulation.memory = Some(simulation.bytes());
    assert!(simulation.run(&Silent).is_ok());
    simulation.samples = usize::MAX;
    simulation.memory = None;
    assert!(matches!(
        simulation.run(&Silent).unwrap_err(),
        Error::Memory { .. }
    ));
}

#[test]
fn val_end_time_of_the_front() {
    let mut simulation = Simulation::impact(Chain::dimer(40, 4.9272), 1.0, 1.0, 2001);
    let arrives = |simulation: &Simulation| {
        let mut simulation = simulation.clone();
        simulation.end_time = EndTime::Arrival;
        let run = simulation.run(&Silent).unwrap();
        run.time[run.time.len() - 1]
    };
    let end = arrives(&simulation);
    simulation.end_time = EndTime::At(2.0 * end);
    let run = simulation.run(&Silent).unwrap();
    let last = run.velocity.column(39);
    let first = last.iter().position(|v| v.abs() >= 1e-3).unwrap();
    let (before, after) = (run.time[first - 1], run.time[first]);
    let slack = after - before;
    assert!(before - slack < end, "{before} {end} {after}");
    assert!(end < after + slack, "{before} {end} {after}");
    // A soft chain that is struck faster scales: t -> t / v^{1/5}.
    simulation.velocity[0] = 32.0;
    assert!((arrives(&simulation) * 2.0 / end - 1.0).abs() < 1e-3);
}

/// A run of thousands of steps between two samples is stopped between them.
#[test]
fn a_long_run_of_few_samples_is_cancelled() {
    let simulation = Simulation::impact(Chain::dimer(60, 1.0), 1.0, 2000.0, 2);
    let stopped = simulation.run(&Fuse(AtomicUsize::new(5)));
    assert!(matches!(stopped, Err(Error::Cancelled)));
}
