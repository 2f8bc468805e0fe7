//! Wavenumbers and group velocities of a stated relation of dispersion.

use std::f64::consts::{PI, TAU};

use crate::analyze::{Axes, Dispersion};
use crate::error::Result;
use crate::numeric::find_root;

/// Intervals of wavenumbers in which a frequency is looked for.
const INTERVALS: usize = 960;
/// Step of differences, as a share of the Nyquist wavenumber.
const STEP: f64 = 1e-5;

/// Waves of a relation on the axes of a field.
pub(super) struct Waves<'a> {
    law: &'a Dispersion,
    axes: &'a Axes,
    wavenumbers: Vec<f64>,
    /// Frequencies of each branch.
    branches: Vec<Vec<f64>>,
}

impl<'a> Waves<'a> {
    /// # Errors
    /// Those of [`Dispersion::at`].
    pub fn of(law: &'a Dispersion, axes: &'a Axes) -> Result<Waves<'a>> {
        let nyquist = PI / axes.space.step.abs();
        let all = (0..=INTERVALS).map(|n| nyquist * n as f64 / INTERVALS as f64);
        let wavenumbers: Vec<f64> = all.collect();
        Ok(Waves {
            branches: cycles(law, axes, &wavenumbers)?,
            wavenumbers,
            law,
            axes,
        })
    }

    pub fn highest(&self) -> f64 {
        let all = self.branches.iter().flatten().filter(|f| f.is_finite());
        all.fold(0.0, |m: f64, f| m.max(*f))
    }

    /// The wavenumber, with the sign of the wave whose energy goes to +x, and the group velocity; `None` where no wave or
    /// several have the frequency.
    pub fn at(&self, frequency: f64) -> Option<[f64; 2]> {
        let mut found = self
            .branches
            .iter()
            .enumerate()
            .flat_map(|(branch, values)| {
                let crosses = move |i: &usize| {
                    let [a, b] = [values[*i], values[i + 1]].map(|f| f - frequency);
                    (a <= 0.0) != (b <= 0.0) && a.is_finite() && b.is_finite()
                };
                (0..INTERVALS).filter(crosses).map(move |i| (branch, i))
            });
        let (branch, i) = found.next()?;
        let value = |k: f64| {
            let found = cycles(self.law, self.axes, &[k]);
            found.map_or(f64::NAN, |found| found[branch][0])
        };
        let ends = [self.wavenumbers[i], self.wavenumbers[i + 1]];
        let k = find_root(ends[0], ends[1], |k| value(k) - frequency);
        let step = STEP * PI / self.axes.space.step.abs();
        // A relation of |k| has a kink at 0.
        let below = (k - step).max(0.0);
        let velocity = TAU * (value(k + step) - value(below)) / (k + step - below);
        let is_one = found.next().is_none() && velocity.is_finite();
        is_one.then_some([k * velocity.signum(), velocity.abs()])
    }
}

/// Frequencies of each branch; NaN where they are below 0.
fn cycles(law: &Dispersion, axes: &Axes, wavenumbers: &[f64]) -> Result<Vec<Vec<f64>>> {
    let mut branches = law.at(axes, wavenumbers)?;
    for omega in branches.iter_mut().flatten() {
        *omega = if *omega < 0.0 { f64::NAN } else { *omega / TAU };
    }
    Ok(branches)
}
