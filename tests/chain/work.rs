//! The work of one run each of the schemes, so that a change of it is seen.

use std::sync::atomic::{AtomicUsize, Ordering};

use test_support::scenes::{parsed, rows, run, simulation, within};
use wavecascade::chain::{Accuracy, Record, RunWarning};
use wavecascade::observer::{Observer, Silent};

/// Counts integrations.
#[derive(Default)]
struct Integrations(AtomicUsize);

impl Observer for Integrations {
    fn stage(&self, name: &'static str, _units: u64) {
        assert_eq!(name, "stepping");
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn regress_work_of_every_scheme() {
    for [keys, error, expected] in rows(include_str!("work.txt")) {
        // The integrations of long runs are of two samples.
        let samples = if keys.contains("300") { 2 } else { 11 };
        let mut it = simulation(&format!("samples = {samples}\nrecord = []\n{keys}"));
        it.accuracy = error.parse().map_or(it.accuracy, Accuracy::LocalError);
        it.estimate_error = false;
        let cost = it.run(&Silent).unwrap().report.cost;
        let found = [
            cost.steps,
            cost.rejected_steps,
            cost.forces,
            cost.corrected_contacts,
        ];
        assert_eq!(
            found.map(|count| count as f64),
            parsed(&expected)[..],
            "{keys}"
        );
    }
}

/// Where two runs grow apart so fast that rounding would, too, no other pair is made. The observer sees the finer of the two.
#[test]
fn regress_one_pair_of_runs_where_rounding_is_amplified() {
    for (kappa, record, amplifies, cost) in [
        (8.0, Record::ALL, true, Some([3152, 3_925_312])),
        (9.2276, Record::default(), true, None),
        (100.0, Record::default(), false, None),
    ] {
        let keys = format!("sites = 300\nstiffness_ratio = {kappa}\nend_time = 250.0\nsamples = 2");
        let mut it = simulation(&format!("{keys}\ntolerance = 1e-6"));
        it.record = record;
        let integrations = Integrations::default();
        let report = it.run(&integrations).unwrap().report;
        let warned = matches!(report.warnings[..], [RunWarning::Amplifies { growth: Some([rate, until]), .. }]
            if (0.05..0.5).contains(&rate) && (50.0..240.0).contains(&until));
        assert_eq!(warned, amplifies, "{kappa}: {report:?}");
        assert_eq!(warned, report.error.unwrap() > 1e-6);
        assert_eq!(integrations.0.into_inner(), 1, "{kappa}");
        let found = [report.cost.steps, report.cost.forces];
        assert_eq!(found, cost.unwrap_or(found), "{kappa}");
    }
}

#[test]
fn regress_steps_are_estimated_to_a_factor_of_ten() {
    for [scene] in rows(include_str!("estimates.txt")) {
        let scene = format!("{scene}\nsamples = 17");
        let estimated = simulation(&scene).work().steps.unwrap();
        let cost = run(&scene).report.cost;
        let found = (cost.steps + cost.rejected_steps) as f64;
        within(estimated / found, 0.1..10.0, scene);
    }
}

/// How long a wall that is much stiffer than the other contacts is pressed is not known before.
#[test]
fn regress_steps_are_not_told_of_a_wall_that_is_much_stiffer() {
    for stiff in ["1e8", "9.2e18"] {
        let it = simulation(&format!(
            "sites = 10\nend_time = 1e4\nwall_coefficient = {stiff}"
        ));
        assert_eq!(it.work().steps, None);
    }
}
