//! Stepping with samples inside the steps, which change none of them.

use std::ops::Range;

use super::lattice::Ends;
use super::path::NodeState;
use super::simulation::Simulation;
use super::stepping::{FIRST_CONTACT, FIRST_SITE, Samples};
use crate::Result;
use crate::observer::Observer;

impl Simulation {
    /// Steps to the last of `times`, rising from 0, as [`Simulation::along`] does, and shows at each
    /// the sites beside these contacts, in order, with the energy that the contacts have passed on, followed inside
    /// the steps. Other sites are not up to date.
    pub(crate) fn sampled(
        &self,
        times: &[f64],
        contacts: &[usize],
        local_error: f64,
        observer: &dyn Observer,
        visit: &mut dyn FnMut(NodeState, &[f64]),
    ) -> Result<()> {
        let (mut stepping, _) = self.stepping(times, local_error, true)?;
        let m = self.chain.n_contacts();
        let sides = |j: &usize| FIRST_CONTACT + j - 1..FIRST_CONTACT + j + 1;
        // The last contact of a ring leads to the first site.
        let first = (self.chain.ends == Ends::Periodic).then_some(FIRST_SITE..FIRST_SITE + 1);
        let places: Vec<Range<usize>> = first
            .into_iter()
            .chain(contacts.iter().map(sides))
            .collect();
        let wanted = Samples {
            times,
            places: &places,
        };
        stepping.advance_through(wanted, observer, &mut |i, state| {
            let place = NodeState::of(&self.chain, times[i], state);
            visit(place, &state.passed[FIRST_CONTACT..][..m]);
            observer.advance(1);
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::stepping::State;
    use crate::chain::{Chain, Law};
    use crate::observer::Silent;

    const END: f64 = 40.0;

    /// Displacements, velocities, and energies passed.
    type Row = [Vec<f64>; 3];

    fn times(samples: usize) -> Vec<f64> {
        let last = (samples - 1) as f64;
        (0..samples).map(|i| END * (i as f64 / last)).collect()
    }

    fn inside(simulation: &Simulation, samples: usize, local_error: f64) -> Vec<Row> {
        let mut rows = Vec::new();
        let contacts: Vec<usize> = (0..simulation.chain.n_contacts()).collect();
        let mut keep = |at: NodeState, passed: &[f64]| {
            rows.push([at.x.to_vec(), at.v.to_vec(), passed.to_vec()]);
        };
        let times = times(samples);
        simulation
            .sampled(&times, &contacts, local_error, &Silent, &mut keep)
            .unwrap();
        rows
    }

    /// Steps end at each sample.
    fn landing(simulation: &Simulation, samples: usize, local_error: f64) -> Vec<Row> {
        let times = times(samples);
        let (mut stepping, _) = simulation.stepping(&times, local_error, true).unwrap();
        let (n, m) = (simulation.chain.n_sites(), simulation.chain.n_contacts());
        let mut row = |t: &f64| {
            stepping.advance_to(*t, &Silent).unwrap();
            let State { x, v, passed, .. } = stepping.state();
            let sites = [x, v].map(|row| row[FIRST_SITE..][..n].to_vec());
            let [x, v] = sites;
            [x, v, passed[FIRST_CONTACT..][..m].to_vec()]
        };
        times.iter().map(&mut row).collect()
    }

    fn worst(a: &[Row], b: &[Row]) -> [f64; 3] {
        [0, 1, 2].map(|kind| {
            let rows = a.iter().zip(b);
            let pairs = rows.flat_map(|(a, b)| a[kind].iter().zip(&b[kind]));
            pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()))
        })
    }

    fn dimer(kappa: f64) -> Simulation {
        Simulation::impact(Chain::dimer(40, kappa), 1.0, END, 2)
    }

    #[test]
    fn regress_samples_inside_change_no_bit() {
        let bits = |row: Option<&Row>| -> Vec<u64> {
            let values = row.unwrap().iter().flatten();
            values.map(|value| value.to_bits()).collect()
        };
        for local_error in [1e-6, 1e-10] {
            let two = inside(&dimer(4.9272), 2, local_error);
            for samples in [64, 300, 4096] {
                let many = inside(&dimer(4.9272), samples, local_error);
                assert_eq!(bits(two.last()), bits(many.last()), "{samples}");
            }
        }
    }

    /// Against steps a thousandth as rough that end at the samples.
    #[test]
    fn val_convergence_samples_inside() {
        let mut power = dimer(3.0);
        power.chain.law = Law::Power { exponent: 2.5 }.into();
        let mut pressed = dimer(3.0);
        pressed.chain.precompression = 0.01;
        let mut springs = dimer(2.0);
        springs.chain.law = Law::Spring {
            alpha: 0.25,
            beta: 0.5,
        }
        .into();
        let mut ring = dimer(2.0);
        ring.chain.ends = Ends::Periodic;
        for (name, simulation) in [
            ("1", dimer(1.0)),
            ("4.9272", dimer(4.9272)),
            ("1631", dimer(1631.0)),
            ("power", power),
            ("pressed", pressed),
            ("springs", springs),
            ("ring", ring),
        ] {
            for local_error in [1e-6, 1e-9] {
                let truth = landing(&simulation, 1024, 1e-3 * local_error);
                let found = worst(&inside(&simulation, 1024, local_error), &truth);
                println!("{name} {local_error:e}: {found:?}");
                // Errors of the steps add up; those inside them do not.
                for (found, most) in found.iter().zip([30.0, 10.0, 10.0]) {
                    assert!(
                        *found < most * local_error,
                        "{name} {local_error:e}: {found:e}"
                    );
                }
            }
        }
    }

    /// The energy that has passed is that of the sites behind, at each sample.
    #[test]
    fn val_balance_energies_inside_steps() {
        let simulation = dimer(4.9272);
        let chain = &simulation.chain;
        let mut worst = 0.0f64;
        for [x, v, passed] in inside(&simulation, 2048, 1e-11) {
            let mut behind = 0.0;
            for j in 0..39 {
                let energy = chain.contact(j).energy(x[j] - x[j + 1]);
                // Half of the energy of a contact is that of the site behind it.
                behind += 0.5 * chain.mass[j] * v[j] * v[j] + 0.5 * energy;
                worst = worst.max((behind + passed[j] - 0.5 * chain.mass[0]).abs());
                behind += 0.5 * energy;
            }
        }
        println!("{worst:e}");
        assert!(worst < 3e-11, "{worst:e}");
    }
}
