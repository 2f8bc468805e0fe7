//! What exact budgets are computed from: a chain and how it moves.

use ndarray::{Array2, ArrayView1, ArrayView2, Axis};

use crate::chain::{Chain, Drive, NodeState, Run};
use crate::error::{Error, Result};

/// The motion of a chain, `(time, site)`: velocities alone have no exact budget, since the energy
/// of contacts is not known from them.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    pub chain: &'a Chain,
    pub drive: Option<&'a Drive>,
    /// Uniform samples.
    pub time: ArrayView1<'a, f64>,
    /// From the static state.
    pub displacement: ArrayView2<'a, f64>,
    pub velocity: ArrayView2<'a, f64>,
    /// Displacements and velocities of the resonators of a chain that has them.
    pub resonators: Option<[ArrayView2<'a, f64>; 2]>,
    /// Energy passed through the contacts `(time, contact)`, where it was followed inside the steps.
    pub energy_passed: Option<&'a Array2<f64>>,
    /// Energy lost at each site, likewise.
    pub energy_lost: Option<&'a Array2<f64>>,
    /// Energy put in at a driven end, likewise.
    pub energy_input: Option<ArrayView1<'a, f64>>,
}

impl<'a> Motion<'a> {
    /// The motion that a run recorded.
    ///
    /// # Errors
    /// [`Error::Request`] for a run without displacements.
    pub fn of(run: &'a Run) -> Result<Motion<'a>> {
        let displacement = run.displacement.as_ref().ok_or_else(|| {
            let expected = "a run that recorded displacements, for the energy of contacts";
            Error::request("record", expected, "none in it")
        })?;
        let own = run.resonator_displacement.as_ref();
        let own = own.zip(run.resonator_velocity.as_ref());
        Ok(Motion {
            chain: &run.chain,
            drive: run.drive.as_ref(),
            time: run.time.view(),
            displacement: displacement.view(),
            velocity: run.velocity.view(),
            resonators: own.map(|(y, w)| [y.view(), w.view()]),
            energy_passed: run.energy_passed.as_ref(),
            energy_lost: run.energy_lost.as_ref(),
            energy_input: run.energy_input.as_ref().map(|input| input.view()),
        })
    }

    /// The chain at sample i.
    pub(super) fn at(&self, i: usize) -> NodeState<'a> {
        let row = |array: ArrayView2<'a, f64>| array.index_axis_move(Axis(0), i).to_slice();
        NodeState {
            t: self.time[i],
            // Rows are contiguous, as `check` ensures.
            x: row(self.displacement).unwrap_or_default(),
            v: row(self.velocity).unwrap_or_default(),
            resonators: match self.resonators {
                Some(both) => both.map(|array| row(array).unwrap_or_default()),
                None => [&[]; 2],
            },
        }
    }

    pub(super) fn samples(&self) -> usize {
        self.time.len()
    }

    pub(super) fn duration(&self) -> f64 {
        self.time[self.samples() - 1] - self.time[0]
    }

    pub(super) fn step(&self) -> f64 {
        self.duration() / (self.samples() - 1) as f64
    }

    /// Weights of sample i under the trapezoid rule: in the step before it, and in that behind it.
    pub(super) fn halves(&self, i: usize) -> [f64; 2] {
        let half = 0.5 * self.step();
        let is_end = |end: usize| if i == end { 0.0 } else { half };
        [is_end(0), is_end(self.samples() - 1)]
    }

    /// # Errors
    /// [`Error::Request`] naming what does not fit the chain.
    pub(super) fn check(&self) -> Result<()> {
        self.chain.check()?;
        let samples = self.samples();
        Error::require(samples >= 2, "samples", "2 or more", samples)?;
        let step = self.step();
        let even =
            |(i, t): (usize, &f64)| (t - self.time[0] - step * i as f64).abs() <= 1e-6 * step;
        let even = step > 0.0 && self.time.iter().enumerate().all(even);
        Error::require(even, "time", "rising, evenly spaced times", "others")?;
        let are_its_own = self.resonators.is_some() == self.chain.resonators().is_some();
        let expected = "the motion of resonators for a chain that has them, and for no other";
        Error::require(are_its_own, "resonators", expected, "otherwise")?;
        let (n, m) = (self.chain.n_sites(), self.chain.n_contacts());
        let [y, w] = self.resonators.map_or([None; 2], |both| both.map(Some));
        let followed = |array: Option<&'a Array2<f64>>| array.map(|array| array.view());
        let input = self.energy_input.map(|input| input.insert_axis(Axis(1)));
        for (name, array, columns, is_motion) in [
            ("energy_passed", followed(self.energy_passed), m, false),
            ("energy_lost", followed(self.energy_lost), n, false),
            ("energy_input", input, 1, false),
            ("displacement", Some(self.displacement), n, true),
            ("velocity", Some(self.velocity), n, true),
            ("resonator_displacement", y, n, true),
            ("resonator_velocity", w, n, true),
        ] {
            let Some(array) = array else { continue };
            let (expected, found) = ((samples, columns), array.dim());
            let shape = format!("the shape {expected:?}");
            Error::require(found == expected, name, shape, format!("{found:?}"))?;
            let is_row = |row: ArrayView1<f64>| row.to_slice().is_some();
            let in_order = !is_motion || array.rows().into_iter().all(is_row);
            Error::require(in_order, name, "rows in order in memory", "others")?;
            if let Some(value) = array.iter().find(|x| is_motion && !x.is_finite()) {
                return Err(Error::request(name, "finite values", value));
            }
        }
        Ok(())
    }
}
