//! Unitary transforms of sites and contacts, and the wavenumbers of their components.

use std::f64::consts::PI;
use std::sync::Arc;

use column_fft::{RealToComplex, rows};
use num_complex::Complex;

use crate::chain::Ends;
use crate::transform::fold;

/// What rows along a chain are expanded in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// `exp(i k x)` over the N sites; the N contacts are at their left sites.
    #[default]
    Fourier,
    /// Between two walls: sines of the sites, cosines of the contacts, `k = pi m / (N + 1)`.
    Standing,
}

impl Basis {
    /// That of a chain's ends: the modes of the uniform linear chain between two walls, else Fourier.
    pub fn of(ends: Ends) -> Basis {
        match ends {
            Ends::Fixed { .. } => Basis::Standing,
            _ => Basis::Fourier,
        }
    }
}

/// Transforms between sites (contacts) and components of rising wavenumber.
///
/// `sum_m w_m |X_m|^2 = sum_j X_j^2` with the weights [`Modes::weight`]: in the Fourier basis a
/// component counts k and -k, except 0 and, for even N, the largest k.
#[derive(Clone)]
pub(super) struct Modes {
    basis: Basis,
    sites: usize,
    plan: Arc<dyn RealToComplex<f64>>,
    /// `exp(i pi m / (2 (N + 1)))`: contacts are halfway between sites.
    halfway: Vec<Complex<f64>>,
}

/// Working space of one thread.
#[derive(Debug, Clone)]
pub(super) struct ModesScratch {
    input: Vec<f64>,
    output: Vec<Complex<f64>>,
    work: Vec<Complex<f64>>,
}

impl Modes {
    pub(super) fn new(basis: Basis, sites: usize) -> Modes {
        let length = match basis {
            Basis::Fourier => sites,
            Basis::Standing => 2 * (sites + 1),
        };
        let quarter = PI / length as f64;
        let turn = |m: usize| Complex::from_polar(1.0, -quarter * m as f64);
        let halfway = match basis {
            Basis::Fourier => Vec::new(),
            Basis::Standing => (0..=sites).map(turn).collect(),
        };
        Modes {
            basis,
            sites,
            plan: rows::plan_fft_forward(length),
            halfway,
        }
    }

    pub(super) fn basis(&self) -> Basis {
        self.basis
    }

    /// Components.
    pub(super) fn len(&self) -> usize {
        match self.basis {
            Basis::Fourier => self.sites / 2 + 1,
            Basis::Standing => self.sites + 1,
        }
    }

    /// Wavenumbers in rad per length, for sites `pitch` apart.
    pub(super) fn wavenumbers(&self, pitch: f64) -> Vec<f64> {
        let step = 2.0 * PI / self.plan.len() as f64;
        (0..self.len()).map(|m| step * m as f64 / pitch).collect()
    }

    /// The number of wavenumbers that component m counts.
    #[inline]
    pub(super) fn weight(&self, m: usize) -> f64 {
        match self.basis {
            Basis::Fourier => fold(m, self.sites),
            Basis::Standing => 1.0,
        }
    }

    pub(super) fn scratch(&self) -> ModesScratch {
        ModesScratch {
            input: self.plan.make_input_vec(),
            output: self.plan.make_output_vec(),
            work: self.plan.make_scratch_vec(),
        }
    }

    /// Components of a row over the sites.
    pub(super) fn of_sites(
        &self,
        row: &[f64],
        scratch: &mut ModesScratch,
        out: &mut [Complex<f64>],
    ) {
        if self.basis == Basis::Fourier {
            return self.fourier(row, scratch, out);
        }
        // The odd continuation: site j is at j + 1.
        self.continued(row, (1, -1.0), scratch);
        let scale = (0.5 / (self.sites + 1) as f64).sqrt();
        for (out, z) in out.iter_mut().zip(&scratch.output) {
            *out = Complex::new(-scale * z.im, 0.0);
        }
    }

    /// The first `out.len()` components of a row over the contacts.
    pub(super) fn of_contacts(
        &self,
        row: &[f64],
        scratch: &mut ModesScratch,
        out: &mut [Complex<f64>],
    ) {
        if self.basis == Basis::Fourier {
            return self.fourier(row, scratch, out);
        }
        // The even continuation: contact i is at i + 1/2.
        self.continued(row, (0, 1.0), scratch);
        let scale = (0.5 / (self.sites + 1) as f64).sqrt();
        let found = scratch.output.iter().zip(&self.halfway);
        for (m, (out, (z, turn))) in out.iter_mut().zip(found).enumerate() {
            let scale = if m == 0 { scale * 0.5f64.sqrt() } else { scale };
            *out = Complex::new(scale * (z * turn).re, 0.0);
        }
    }

    /// Transforms a row from this place on, continued by its mirror image times a sign.
    fn continued(&self, row: &[f64], (from, sign): (usize, f64), scratch: &mut ModesScratch) {
        let input = &mut scratch.input;
        input.fill(0.0);
        input[from..][..row.len()].copy_from_slice(row);
        for (mirrored, value) in input.iter_mut().rev().zip(row) {
            *mirrored = sign * value;
        }
        self.transform(scratch);
    }

    fn fourier(&self, row: &[f64], scratch: &mut ModesScratch, out: &mut [Complex<f64>]) {
        let scale = (1.0 / self.sites as f64).sqrt();
        scratch.input[..row.len()].copy_from_slice(row);
        scratch.input[row.len()..].fill(0.0);
        self.transform(scratch);
        for (out, z) in out.iter_mut().zip(&scratch.output) {
            // The kernel is exp(+i k x), so that positive k travels towards +x.
            *out = z.conj() * scale;
        }
    }

    fn transform(&self, scratch: &mut ModesScratch) {
        let (input, output) = (&mut scratch.input, &mut scratch.output);
        let (plan, work) = (&self.plan, &mut scratch.work);
        // The lengths are the plan's own, so this cannot fail.
        let _ = plan.process_with_scratch(input, output, work);
    }
}

/// The transform of a row.
pub(super) fn forward(plan: &dyn RealToComplex<f64>, row: &[f64]) -> Vec<Complex<f64>> {
    let (mut input, mut output) = (plan.make_input_vec(), plan.make_output_vec());
    input.copy_from_slice(row);
    // The lengths are the plan's own, so this cannot fail.
    let _ = plan.process(&mut input, &mut output);
    output
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the sums that define the transforms between two walls.
    #[test]
    fn val_defining_sums() {
        for n in [1, 2, 5, 8, 33] {
            let row: Vec<f64> = (0..=n).map(|j| (1.3 * j as f64).sin() + 0.2).collect();
            let modes = Modes::new(Basis::Standing, n);
            let mut scratch = modes.scratch();
            let [mut q, mut phi] = [0, 1].map(|_| vec![Complex::default(); n + 1]);
            modes.of_sites(&row[..n], &mut scratch, &mut q);
            modes.of_contacts(&row, &mut scratch, &mut phi);
            let length = (n + 1) as f64;
            for m in 0..=n {
                let angle = PI * m as f64 / length;
                let sine = |j: usize| row[j] * (angle * (j + 1) as f64).sin();
                let sine: f64 = (0..n).map(sine).sum();
                let cosine = |i: usize| row[i] * (angle * (i as f64 + 0.5)).cos();
                let cosine: f64 = (0..=n).map(cosine).sum();
                let weight = if m == 0 { 1.0 } else { 2.0 };
                assert!((q[m].re - (2.0 / length).sqrt() * sine).abs() < 3e-14);
                let expected = (weight / length).sqrt() * cosine;
                assert!((phi[m].re - expected).abs() < 3e-14, "{n} {m}");
            }
        }
    }
}
