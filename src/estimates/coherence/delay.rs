//! The delay of a site behind the reference.

use std::f64::consts::{PI, TAU};

use column_fft::{Columns, ColumnsMut, ComplexToComplexColumns};
use num_complex::Complex;

use crate::transform::FftDirection;

/// The delay of a site behind the reference.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Delay {
    /// In units of time; positive where the site follows the reference.
    pub delay: f64,
    /// Standard error, if the records differ by a delay and independent noise.
    pub error: f64,
    /// Frequencies that are coherent.
    pub frequencies: usize,
}

/// Points of the search for each sample of a segment.
const FINER: usize = 4;
/// Least coherent frequencies.
const LEAST: usize = 2;

/// Finds delays, by the maximum of
///
/// ```text
/// C(tau) = sum_f W(f) cos(phase(f) + 2 pi f tau),    W = g / (1 - g),
/// ```
///
/// over coherent frequencies between 0 and the Nyquist frequency, `g` the magnitude-squared coherence:
/// the maximum-likelihood estimate. Its variance is `B / (2 K sum (2 pi f)^2 W)`, with the `B` bins that the
/// taper spreads a frequency over.
///
/// Source: C. H. Knapp, G. C. Carter, IEEE Trans. Acoust. Speech Signal Process. 24, 320 (1976).
pub(super) struct DelaySearch {
    transform: ComplexToComplexColumns<f64>,
    length: usize,
    dt: f64,
    shared_bins: f64,
}

impl DelaySearch {
    pub fn new(length: usize, dt: f64, shared_bins: f64) -> Self {
        let points = (FINER * length).next_power_of_two();
        let transform = ComplexToComplexColumns::new(points, FftDirection::Inverse);
        DelaySearch {
            transform: transform.expect("at least four samples"),
            length,
            dt,
            shared_bins,
        }
    }

    /// The delay of a site with this coherence and this phase of the cross-spectrum, bin by bin from
    /// frequency 0; `None` with fewer than two coherent frequencies, those above the level. `known`: the level and
    /// the number of independent realisations.
    pub fn find(
        &self,
        coherence: &[f64],
        phase: &[f64],
        [level, independent]: [f64; 2],
    ) -> Option<Delay> {
        let inside = 1..self.length.div_ceil(2);
        let coherent = |m: &usize| coherence[*m] > level;
        let weight = |m: usize| coherence[m] / (1.0 - coherence[m]).max(f64::EPSILON);
        let bins: Vec<usize> = inside.filter(coherent).collect();
        if bins.len() < LEAST {
            return None;
        }
        let points = self.transform.len();
        let mut sums = vec![Complex::default(); points];
        for &m in &bins {
            sums[m] = Complex::from_polar(weight(m), phase[m]);
        }
        let mut found = vec![Complex::default(); points];
        let input = Columns::new(&sums, points, 1, 1).ok()?;
        let output = ColumnsMut::new(&mut found, points, 1, 1).ok()?;
        self.transform.process(input, output).ok()?;
        let largest = (0..points).max_by(|&a, &b| found[a].re.total_cmp(&found[b].re))?;
        let signed = |point: usize| match 2 * point > points {
            true => point as f64 - points as f64,
            false => point as f64,
        };
        // In cycles of the lowest frequency.
        let mut tau = signed(largest) / points as f64;
        let angle = |m: usize, tau: f64| phase[m] + TAU * m as f64 * tau;
        for _ in 0..8 {
            let slope: f64 = bins
                .iter()
                .map(|&m| -weight(m) * m as f64 * angle(m, tau).sin())
                .sum();
            let bend: f64 = bins
                .iter()
                .map(|&m| -weight(m) * (m as f64).powi(2) * angle(m, tau).cos())
                .sum();
            // Within the lobe that the search found.
            let step = slope / bend / TAU;
            if bend >= 0.0 || step.abs() > 1.0 / points as f64 {
                break;
            }
            tau -= step;
        }
        let information: f64 = bins.iter().map(|&m| weight(m) * (m as f64).powi(2)).sum();
        let period = self.length as f64 * self.dt;
        let variance = self.shared_bins / (2.0 * independent * information);
        Some(Delay {
            delay: tau * period,
            error: variance.sqrt() / (2.0 * PI) * period,
            frequencies: bins.len(),
        })
    }
}
