//! What exact budgets are computed from: a chain and how it moves.

use ndarray::{Array2, ArrayView1, ArrayView2, Axis};

use crate::chain::{Chain, Drive, Run};
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
        let displacement = run.displacement.as_ref().ok_or_else(|| Error::Request {
            option: "record",
            expected: "a run that recorded displacements, for the energy of contacts".into(),
            found: "none in it".into(),
        })?;
        Ok(Motion {
            chain: &run.chain,
            drive: run.drive.as_ref(),
            time: run.time.view(),
            displacement: displacement.view(),
            velocity: run.velocity.view(),
            resonators: match (&run.resonator_displacement, &run.resonator_velocity) {
                (Some(y), Some(w)) => Some([y.view(), w.view()]),
                _ => None,
            },
            energy_passed: run.energy_passed.as_ref(),
            energy_lost: run.energy_lost.as_ref(),
            energy_input: run.energy_input.as_ref().map(|input| input.view()),
        })
    }

    /// The chain at sample i.
    pub(super) fn at(&self, i: usize) -> ChainState<'a> {
        let row = |array: ArrayView2<'a, f64>| array.index_axis_move(Axis(0), i).to_slice();
        ChainState {
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

    /// # Errors
    /// [`Error::Request`] naming what does not fit the chain.
    pub(super) fn check(&self) -> Result<()> {
        let refuse = |option, expected: String, found: String| {
            Err(Error::Request {
                option,
                expected,
                found,
            })
        };
        self.chain.check()?;
        if self.samples() < 2 {
            return refuse("samples", "2 or more".into(), self.samples().to_string());
        }
        let step = self.step();
        let even =
            |(i, t): (usize, &f64)| (t - self.time[0] - step * i as f64).abs() <= 1e-6 * step;
        if !(step > 0.0 && self.time.iter().enumerate().all(even)) {
            return refuse(
                "time",
                "rising, evenly spaced times".into(),
                "others".into(),
            );
        }
        let (n, m) = (self.chain.n_sites(), self.chain.n_contacts());
        let shape = (self.samples(), n);
        for (name, array, columns) in [
            ("energy_passed", self.energy_passed, m),
            ("energy_lost", self.energy_lost, n),
        ] {
            if let Some(array) = array.filter(|array| array.dim() != (self.samples(), columns)) {
                let expected = format!("the shape ({}, {columns})", self.samples());
                return refuse(name, expected, format!("{:?}", array.dim()));
            }
        }
        if self
            .energy_input
            .is_some_and(|input| input.len() != self.samples())
        {
            return refuse(
                "energy_input",
                format!("{} values", self.samples()),
                "others".into(),
            );
        }
        if self.resonators.is_some() != self.chain.resonators().is_some() {
            let expected = "the motion of resonators for a chain that has them, and for no other";
            return refuse("resonators", expected.into(), "otherwise".into());
        }
        let resonators = ["resonator_displacement", "resonator_velocity"].into_iter();
        let resonators = resonators.zip(self.resonators.into_iter().flatten());
        let bodies = [
            ("displacement", self.displacement),
            ("velocity", self.velocity),
        ];
        for (name, array) in bodies.into_iter().chain(resonators) {
            if array.dim() != shape {
                return refuse(
                    name,
                    format!("the shape {shape:?}"),
                    format!("{:?}", array.dim()),
                );
            }
            if array.rows().into_iter().any(|row| row.to_slice().is_none()) {
                return refuse(name, "rows in order in memory".into(), "others".into());
            }
            if let Some(value) = array.iter().find(|value| !value.is_finite()) {
                return refuse(name, "finite values".into(), value.to_string());
            }
        }
        Ok(())
    }
}

/// A chain at one time.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChainState<'a> {
    pub(super) t: f64,
    pub(super) x: &'a [f64],
    pub(super) v: &'a [f64],
    /// Those of resonators; empty without.
    pub(super) resonators: [&'a [f64]; 2],
}
