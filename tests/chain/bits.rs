//! The same bits: stepping only where a force acts, and many chains at once, from any number of threads.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use test_support::changed;
use test_support::scenes::{near, simulation};
use wavecascade::Error;
use wavecascade::chain::{EndTime, Record, Run, Simulation, SteppedSites, run_each};
use wavecascade::observer::{Observer, Silent};

const FEW: &str = "record = ['displacement', 'force']\nsamples = 9\n\
                   sites = 45\nend_time = 40.0\nstiffness_ratio = 2.0\n";

fn bits(run: &Run) -> Vec<u64> {
    let arrays = [
        Some(&run.velocity),
        run.displacement.as_ref(),
        run.force.as_ref(),
        run.energy_passed.as_ref(),
        run.energy_lost.as_ref(),
    ];
    let values = arrays.into_iter().flatten().flat_map(|array| array.iter());
    // Zeros of either sign are the same number.
    values.map(|v| (v + 0.0).to_bits()).collect()
}

/// Stepping only where a force acts changes no bit.
#[test]
fn val_whole_chain() {
    let mut scenes = Vec::new();
    for kappa in ["1", "2.398", "4.9272", "1631", "1e6"] {
        for tolerance in ["1e-3", "1e-7", "1e-11"] {
            scenes.push(format!(
                "stiffness_ratio = {kappa}\ntolerance = {tolerance}"
            ));
        }
    }
    for scheme in ["velocity-verlet", "symplectic-4", "symplectic-6"] {
        let steps = format!("scheme = '{scheme}'\nstep = 0.02");
        scenes.push(format!("stiffness_ratio = 4.9272\n{steps}"));
    }
    let others = [
        "law = 'power'\nexponent = 2.5",
        "precompression = 0.01",
        "law = 'spring'\nend_time = 10.0",
        "ends = 'free'",
        "dashpot = 0.02\ntangent = 0.01\ndrag = 0.003",
    ];
    scenes.extend(others.map(|keys| format!("stiffness_ratio = 3\n{keys}")));
    for scene in scenes {
        let end = if scene.contains("end_time") {
            ""
        } else {
            "end_time = 40.0\n"
        };
        let mut it = simulation(&format!(
            "sites = 60\nsamples = 50\nestimate_error = false\n{end}{scene}"
        ));
        let [whole, active] = [SteppedSites::Whole, SteppedSites::Active].map(|window| {
            it.window = window;
            it.run(&Silent).unwrap()
        });
        let [a, b] = [&active, &whole].map(|run| &run.report.cost);
        assert!(a.forces < b.forces && a.steps == b.steps, "{scene}");
        assert_eq!(bits(&active), bits(&whole), "{scene}");
    }
}

/// The results in the order of the simulations.
fn run_many(simulations: &[Simulation], observer: &dyn Observer) -> Vec<wavecascade::Result<Run>> {
    let slots: Vec<OnceLock<_>> = simulations.iter().map(|_| OnceLock::new()).collect();
    run_each(simulations, observer, &|i, result| {
        assert!(slots[i].set(result).is_ok());
    });
    let slots = slots.into_iter();
    slots.map(|slot| slot.into_inner().unwrap()).collect()
}

/// Chains of every kind.
fn mixture() -> Vec<Simulation> {
    let scenes = [
        "scheme = 'velocity-verlet'\nstep = 0.03",
        "scheme = 'symplectic-4'\nstep = 0.03",
        "scheme = 'symplectic-6'\nstep = 0.03",
        "scheme = 'velocity-verlet'\nstep = 0.03\nprecompression = 0.1",
        "scheme = 'velocity-verlet'\nstep = 0.03\nlaw = 'power'\nexponent = 2.0",
        "tolerance = 1e-6",
        "tolerance = 1e-6\ndrag = 0.01",
    ];
    let text = scenes.map(|scene| format!("{FEW}{scene}"));
    text.iter().map(|text| simulation(text)).collect()
}

#[test]
fn val_each_chain_alone_and_any_number_of_threads() {
    let all = mixture();
    let alone: Vec<Run> = all.iter().map(|s| s.run(&Silent).unwrap()).collect();
    for threads in [1, 2, 4] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let many = pool.build().unwrap().install(|| run_many(&all, &Silent));
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
    // That each is answered once is seen by `run_many`.
    let results = run_many(&mixture(), &Fuse(AtomicUsize::new(2)));
    let mut results = results.iter();
    assert!(results.any(|result| matches!(result, Err(Error::Cancelled))));
}

#[test]
fn val_memory_is_asked_for_before_the_work() {
    let mut simulation = mixture().remove(0);
    simulation.memory = Some(simulation.bytes() - 1);
    let many = run_many(&[simulation.clone()], &Silent).remove(0);
    for result in [simulation.run(&Silent), many] {
        let told = result.unwrap_err();
        let one_more =
            matches!(told, Error::Memory { needed, allowed, .. } if needed == allowed + 1);
        assert!(one_more, "{told}");
    }
    simulation.memory = Some(simulation.bytes());
    assert!(simulation.run(&Silent).is_ok());
    let endless = changed(simulation, |it| {
        (it.samples, it.memory) = (usize::MAX, None)
    });
    let told = endless.run(&Silent).unwrap_err();
    assert!(matches!(told, Error::Memory { .. }), "{told}");
}

#[test]
fn val_end_time_of_the_front() {
    let mut it = simulation("sites = 40\nstiffness_ratio = 4.9272\nsamples = 2001");
    it.record = Record::default();
    let arrives = |it: &Simulation| {
        let run = it.run(&Silent).unwrap();
        run.time[run.time.len() - 1]
    };
    let end = arrives(&it);
    let longer = changed(it.clone(), |it| it.end_time = EndTime::At(2.0 * end));
    let run = longer.run(&Silent).unwrap();
    let mut moved = run.velocity.column(39).into_iter();
    let first = moved.position(|v| v.abs() >= 1e-3).unwrap();
    let step = run.time[1];
    near(end, run.time[first] - 0.5 * step, 1.5 * step, first);
    // A soft chain that is struck faster scales: t -> t / v^{1/5}.
    it.velocity[0] = 32.0;
    assert!((arrives(&it) * 2.0 / end - 1.0).abs() < 1e-3);
}

/// A run of thousands of steps between two samples is stopped between them.
#[test]
fn a_long_run_of_few_samples_is_cancelled() {
    let stopped = simulation("sites = 60\nend_time = 2000.0\nsamples = 2");
    let stopped = stopped.run(&Fuse(AtomicUsize::new(5)));
    assert!(matches!(stopped, Err(Error::Cancelled)));
}
