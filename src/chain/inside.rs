//! Stepping with samples inside the steps, which change none of them.

use super::path::NodeState;
use super::simulation::Simulation;
use crate::Result;
use crate::observer::Observer;

impl Simulation {
    /// Steps to the last of `times`, rising from 0, as [`Simulation::along`] does, and shows the chain at each.
    pub(crate) fn sampled(
        &self,
        times: &[f64],
        local_error: f64,
        observer: &dyn Observer,
        visit: &mut dyn FnMut(NodeState),
    ) -> Result<()> {
        let (mut stepping, _) = self.stepping(times, local_error, false)?;
        stepping.advance_through(times, observer, &mut |t, state| {
            visit(NodeState::of(&self.chain, t, state));
            observer.advance(1);
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::stepping::FIRST_SITE;
    use crate::chain::{Chain, Ends, Law};
    use crate::observer::Silent;

    const END: f64 = 40.0;

    /// Displacements and velocities at samples; `landing`: of steps that end at each.
    fn rows(
        simulation: &Simulation,
        samples: usize,
        local: f64,
        landing: bool,
    ) -> Vec<[Vec<f64>; 2]> {
        let last = (samples - 1) as f64;
        let times: Vec<f64> = (0..samples).map(|i| END * (i as f64 / last)).collect();
        let mut rows = Vec::new();
        if landing {
            let (mut stepping, _) = simulation.stepping(&times, local, false).unwrap();
            for t in times {
                stepping.advance_to(t, &Silent).unwrap();
                let state = stepping.state();
                let sites = FIRST_SITE..FIRST_SITE + simulation.chain.n_sites();
                rows.push([&state.x, &state.v].map(|row| row[sites.clone()].to_vec()));
            }
        } else {
            let mut keep = |at: NodeState| rows.push([at.x.to_vec(), at.v.to_vec()]);
            simulation
                .sampled(&times, local, &Silent, &mut keep)
                .unwrap();
        }
        rows
    }

    fn dimer(kappa: f64) -> Simulation {
        Simulation::impact(Chain::dimer(40, kappa), 1.0, END, 2)
    }

    #[test]
    fn regress_samples_inside_change_no_bit() {
        for local in [1e-6, 1e-10] {
            let two = rows(&dimer(4.9272), 2, local, false);
            for samples in [64, 300, 4096] {
                let many = rows(&dimer(4.9272), samples, local, false);
                assert_eq!(two.last(), many.last(), "{samples}");
            }
        }
    }

    /// Against steps a thousandth as rough that end at the samples.
    #[test]
    fn val_convergence_samples_inside() {
        let with = |kappa: f64, change: &dyn Fn(&mut Chain)| {
            let mut simulation = dimer(kappa);
            change(&mut simulation.chain);
            simulation
        };
        let springs = Law::Spring {
            alpha: 0.25,
            beta: 0.5,
        };
        for (name, simulation) in [
            ("1", dimer(1.0)),
            ("4.9272", dimer(4.9272)),
            ("1631", dimer(1631.0)),
            (
                "power",
                with(3.0, &|it| it.law = Law::Power { exponent: 2.5 }.into()),
            ),
            ("pressed", with(3.0, &|it| it.precompression = 0.01)),
            ("springs", with(2.0, &|it| it.law = springs.clone().into())),
            ("ring", with(2.0, &|it| it.ends = Ends::Periodic)),
        ] {
            for local in [1e-6, 1e-9] {
                let truth = rows(&simulation, 1024, 1e-3 * local, true);
                let found = rows(&simulation, 1024, local, false);
                // Errors of the steps add up; those inside them do not.
                for (kind, most) in [(0, 30.0), (1, 10.0)] {
                    let pairs = found.iter().zip(&truth);
                    let pairs = pairs.flat_map(|(a, b)| a[kind].iter().zip(&b[kind]));
                    let off = pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()));
                    assert!(off < most * local, "{name} {local:e}: {off:e}");
                }
            }
        }
    }
}
