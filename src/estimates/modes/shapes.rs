//! Shapes of modes, and the wavenumber and velocity of those that are waves.

use std::f64::consts::{PI, TAU};

use ndarray::{Array2, ArrayView2};
use num_complex::Complex;

use super::Modes;
use super::snapshots::Solved;
use crate::estimates::realisations::Realisations;
use crate::numeric::{LineFit, find_root, student_two_sided};
use crate::transform::{ComplexScratch, ComplexTransform};

/// A mode is a wave if this share of its energy is in step with a wave.
const LEAST_SHARE: f64 = 0.9;
/// Sites without which a random shape looks like one.
const LEAST_SITES: usize = 8;
/// Wavenumbers that are tried first, for each wavenumber that the sites resolve.
const FINER: usize = 8;
/// Lines that are fitted to the phases: the first leaves those of noise alone.
const FITS: usize = 2;
/// Distance in bins at which the growth of a line's power along the bins is measured: halfway to the farthest of a maximum.
const QUARTER: f64 = 0.25;
/// Distance in bins from which on a bin has what leaks from others; the window's transform is 0 at the next bin but one.
const FARTHEST: f64 = 0.9;
/// Largest half interval that is stated, over the velocity: of wider ones the direction is hardly known.
const WIDEST: f64 = 0.5;

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
    /// Whether each mode is above the null: `sum_x lambda |phi(x)|^2 / S(x, x)`, the sites that are coherent with it, exceed
    /// [`Modes::level`]. Where that cannot be stated, none is.
    pub is_coherent: Vec<bool>,
    /// The nearest wave to each mode.
    pub waves: Vec<Option<ModeWave>>,
}

/// The wave `|phi(x)| exp(i k x)` that is nearest to a mode.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ModeWave {
    /// In rad per unit of length, positive towards +x.
    pub wavenumber: f64,
    /// `2 pi f / k`, with the frequency at which the power of the bin lies where the interval is stated.
    pub velocity: f64,
    /// Half of its interval at `1 - alpha`; `None` of modes after the first, under several tapers, where the power of the bin
    /// leaks from others, and where no interval can be stated.
    pub velocity_half: Option<f64>,
    /// `|sum |phi| phi exp(-i k x)|^2 / (sum |phi|^2)^2`: 1 for a wave whatever its amplitude along x, 0.72 for a
    /// standing one.
    pub share: f64,
    /// Whether the mode is a wave: coherent, where that can be told, with a share of 0.9 and more, over eight sites and half
    /// a wavelength, by the spread of its energy: a mode that lives on one site has no length.
    pub is_wave: bool,
}

/// Planned search of waves.
pub(super) struct ShapeSearch<'a> {
    found: &'a Modes,
    realisations: &'a Realisations,
    transform: Option<ComplexTransform<f64>>,
}

/// The nearest wave, in sites.
struct Nearest {
    wavenumber: f64,
    /// Standard error.
    error: f64,
    share: f64,
    /// Sites over which the energy would be even with the same spread along x.
    extent: f64,
}

impl<'a> ShapeSearch<'a> {
    pub fn new(found: &'a Modes, realisations: &'a Realisations) -> Self {
        let n_sites = found.n_sites;
        let padded = (FINER * n_sites).next_power_of_two();
        ShapeSearch {
            found,
            realisations,
            transform: (n_sites >= 4).then(|| ComplexTransform::new(&vec![1.0; n_sites], padded)),
        }
    }

    pub fn shapes(&self, bin: usize, solved: &[Solved]) -> ModeShapes {
        let (n_sites, dx) = (self.found.n_sites, self.found.space.step.abs());
        let level = self.found.level(bin);
        let cell = |(n, j): (usize, usize)| solved[n].shape[j] / dx.sqrt();
        let is_coherent = |mode: &Solved| level.is_some_and(|level| mode.related > level);
        let may_be = |mode: &Solved| level.is_none() || is_coherent(mode);
        let wave = |(n, mode): (usize, &Solved)| self.wave(bin, n, mode, may_be(mode));
        ModeShapes {
            bin,
            frequency: self.found.frequency[bin],
            modes: Array2::from_shape_fn((solved.len(), n_sites), cell),
            is_coherent: solved.iter().map(is_coherent).collect(),
            waves: solved.iter().enumerate().map(wave).collect(),
        }
    }

    fn wave(&self, bin: usize, n: usize, mode: &Solved, may_be: bool) -> Option<ModeWave> {
        let near = self.nearest(&mode.shape)?;
        let (found, step) = (self.found, self.found.frequency[1]);
        let centroid = || self.centroid(bin, mode.unsteadiness);
        let at = (n == 0).then(centroid).flatten();
        let wavenumber = near.wavenumber / found.space.step;
        let frequency = found.frequency[bin] + at.map_or(0.0, |[offset, _]| offset * step);
        let velocity = TAU * frequency / wavenumber;
        let half = at.map(|[_, error]| {
            let relative = (near.error / near.wavenumber).hypot(error * step / frequency);
            student_two_sided(found.alpha, (found.n_sites - 2) as f64) * relative
        });
        let half = half.filter(|half| *half < WIDEST);
        Some(ModeWave {
            wavenumber,
            velocity,
            velocity_half: half.map(|half| half * velocity.abs()),
            share: near.share,
            is_wave: may_be
                && near.share >= LEAST_SHARE
                && found.n_sites >= LEAST_SITES
                && near.wavenumber.abs() * near.extent >= PI,
        })
    }

    /// The line through the phases along x, by energy.
    ///
    /// # Equation
    /// With the shares of energy `w` and the phases `theta` that a wave of the wavenumber q leaves,
    ///
    /// ```text
    /// dq = sum w (x - <x>) theta / s,    s = sum w (x - <x>)^2,    error^2 = sum w theta^2 / (n - 2) / s.
    /// ```
    ///
    /// The errors of phases go with the inverse of the amplitude, as those of equal noise at all sites.
    fn nearest(&self, mode: &[Complex<f64>]) -> Option<Nearest> {
        let transform = self.transform.as_ref()?;
        if mode[0].is_nan() {
            return None;
        }
        let weighted: Vec<Complex<f64>> = mode.iter().map(|z| z * z.norm()).collect();
        let profile = ArrayView2::from_shape((1, weighted.len()), &weighted).ok()?;
        let mut scratch = ComplexScratch::default();
        let powers = transform.powers(profile, &mut scratch);
        let padded = transform.padded();
        let best = (0..padded).max_by(|a, b| powers[*a].total_cmp(&powers[*b]))?;
        // In rad a site: exp(i q j) has its power at -q in transforms with exp(+i q j).
        let mut q = -(best as f64 - (padded / 2) as f64) * TAU / padded as f64;
        // How far the mode is in step with a wave, and the line through the phases that it leaves.
        let left = |q: f64| {
            let turn = |(j, z): (usize, &Complex<f64>)| z * Complex::cis(-q * j as f64);
            let rotated: Vec<Complex<f64>> = weighted.iter().enumerate().map(turn).collect();
            let all: Complex<f64> = rotated.iter().sum();
            let cells = rotated.iter().zip(mode).enumerate();
            let points =
                cells.map(|(j, (z, own))| [j as f64, (z * all.conj()).arg(), own.norm_sqr()]);
            Some((all.norm_sqr(), LineFit::weighted(points)?))
        };
        for _ in 0..FITS {
            q += left(q)?.1.slope;
        }
        let (share, line) = left(q)?;
        Some(Nearest {
            wavenumber: q,
            error: line.slope_error,
            share: share.min(1.0),
            extent: (12.0 * line.spread).sqrt(),
        })
    }

    /// Bins from a bin to the frequency at which the power of its first mode lies, and the standard error; `None` where that
    /// cannot be told.
    ///
    /// # Equation
    /// The power grows along the bins by `g = ln(lambda(+1) / lambda(-1)) / 2` a bin. A line d bins above the bin has
    /// `g(d) = ln(|W(1 - d)|^2 / |W(1 + d)|^2) / 2` of the window's transform, and a spectrum that grows by g has its power where
    /// such a line is, exactly for Gaussian windows. The growth of noise has the error `1 / sqrt(2 K)`, that of a tone none:
    /// it goes with the unsteadiness u of the power, `sqrt(u / (2 K))`.
    fn centroid(&self, bin: usize, unsteadiness: f64) -> Option<[f64; 2]> {
        let found = self.found;
        let independent = found.independence.independent?;
        if self.realisations.tapers() > 1 || bin == 0 || bin + 1 >= found.frequency.len() {
            return None;
        }
        let growth = |[above, below]: [f64; 2]| 0.5 * (above / below).ln();
        let of_line = |d: f64| {
            let transforms = self.realisations.taper_transforms(&[d - 1.0, d + 1.0]);
            growth(transforms[0].map(|z| z.norm_sqr()))
        };
        let first = |bin: usize| found.eigenvalues[[bin, 0]];
        let wanted = growth([first(bin + 1), first(bin - 1)]);
        let each = QUARTER / of_line(QUARTER);
        let error = each * (0.5 * unsteadiness.max(0.0) / independent).sqrt();
        let is_own = wanted.abs() < of_line(FARTHEST);
        let offset = || find_root(-FARTHEST, FARTHEST, |d| of_line(d) - wanted);
        is_own.then(|| [offset(), error])
    }
}
