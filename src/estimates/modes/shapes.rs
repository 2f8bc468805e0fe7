//! Shapes of modes, and the wavenumber of those that are waves.

use ndarray::{Array2, ArrayView1, ArrayView2, Axis as Along};
use num_complex::Complex;

use super::snapshots::Solved;
use crate::field::Axis;
use crate::numeric::GoldenSection;
use crate::transform::{ComplexScratch, ComplexTransform};

/// A mode is a wave if this share of its energy is in step with a wave.
const LEAST_SHARE: f64 = 0.9;
/// Sites without which a random shape looks like one.
const LEAST_SITES: usize = 8;
/// Wavenumbers that are tried first, for each wavenumber that the sites resolve.
const FINER: usize = 8;

/// The modes of one frequency.
#[derive(Debug, Clone)]
pub struct ModeShapes {
    /// Index of the frequency.
    pub bin: usize,
    pub frequency: f64,
    /// `(mode, site)`: the motion is `Re phi(x) exp(-2 pi i f t)`, so that the phase of a wave towards +x grows
    /// along x; `sum |phi|^2 dx = 1`; the largest element is real and positive. NaN where the eigenvalue is
    /// rounding.
    pub modes: Array2<Complex<f64>>,
    /// The nearest wave to each mode.
    pub waves: Vec<Option<ModeWave>>,
}

/// The wave `|phi(x)| exp(i k x)` that is nearest to a mode.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ModeWave {
    /// In rad per unit of length, positive towards +x.
    pub wavenumber: f64,
    /// `2 pi f / k`.
    pub velocity: f64,
    /// `|sum |phi| phi exp(-i k x)|^2 / (sum |phi|^2)^2`: 1 for a wave whatever its amplitude along x, 0.72 for a
    /// standing one.
    pub share: f64,
    /// Whether the mode is a wave: a share of 0.9 and more, over at least half a wavelength and eight sites. Of fewer sites, one in
    /// four random shapes (of 4) to one in forty (of 7) has such a share.
    pub is_wave: bool,
}

/// Planned search of the nearest wave.
pub(super) struct ShapeSearch<'a> {
    space: &'a Axis,
    transform: Option<ComplexTransform<f64>>,
}

impl<'a> ShapeSearch<'a> {
    pub fn new(space: &'a Axis, n_sites: usize) -> Self {
        let padded = (FINER * n_sites).next_power_of_two();
        ShapeSearch {
            space,
            transform: (n_sites >= 4).then(|| ComplexTransform::new(&vec![1.0; n_sites], padded)),
        }
    }

    pub fn shapes(&self, bin: usize, frequency: f64, solved: Solved) -> ModeShapes {
        let waves = solved
            .modes
            .axis_iter(Along(0))
            .map(|mode| self.wave(mode, frequency))
            .collect();
        ModeShapes {
            bin,
            frequency,
            modes: solved.modes / self.space.step.abs().sqrt(),
            waves,
        }
    }

    fn wave(&self, mode: ArrayView1<Complex<f64>>, frequency: f64) -> Option<ModeWave> {
        let transform = self.transform.as_ref()?;
        let weighted: Vec<Complex<f64>> = mode.iter().map(|z| z * z.norm()).collect();
        let energy: f64 = mode.iter().map(Complex::norm_sqr).sum();
        if energy.is_nan() || energy <= 0.0 {
            return None;
        }
        // In rad a site: exp(i q j) has its power at -q in transforms with exp(+i q j).
        let share = |q: f64| {
            let term = |(j, z): (usize, &Complex<f64>)| z * Complex::cis(-q * j as f64);
            let sum: Complex<f64> = weighted.iter().enumerate().map(term).sum();
            sum.norm_sqr() / (energy * energy)
        };
        let mut scratch = ComplexScratch::default();
        let profile = ArrayView2::from_shape((1, weighted.len()), &weighted).ok()?;
        let powers = transform.powers(profile, &mut scratch);
        let padded = transform.padded();
        let best = (0..padded).max_by(|a, b| powers[*a].total_cmp(&powers[*b]))?;
        let step = std::f64::consts::TAU / padded as f64;
        let near = -(best as f64 - (padded / 2) as f64) * step;
        let value = |q: f64| Ok::<f64, std::convert::Infallible>(share(q));
        let Ok(mut search) = GoldenSection::new([near - step, near + step], value);
        while search.width() > 1e-8 * step {
            let [c, d] = search.inner;
            let Ok(()) = search.narrow(c.1 > d.1, value);
        }
        let [c, d] = search.inner;
        let (q, share) = if c.1 > d.1 { c } else { d };
        let wavenumber = q / self.space.step;
        let is_long = q.abs() * (weighted.len() - 1) as f64 >= std::f64::consts::PI;
        Some(ModeWave {
            wavenumber,
            velocity: std::f64::consts::TAU * frequency / wavenumber,
            share: share.min(1.0),
            is_wave: share >= LEAST_SHARE && is_long && weighted.len() >= LEAST_SITES,
        })
    }
}
