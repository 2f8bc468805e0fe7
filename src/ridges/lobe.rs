//! What a window makes of one wave: its main lobe, its side lobes, and where their peak seems to be.

use std::f64::consts::TAU;

use num_complex::Complex;

use crate::numeric::{dot, find_root, parabola};
use crate::prepare::Window;

/// Bins at which the window's transform is known: up to this many, in steps of `1 / FINE`.
const REACH: usize = 48;
const FINE: usize = 32;
/// A longer window has the same lobes to the digits that matter.
const LONGEST: usize = 1024;
/// Most that counts as the variance of a lobe, in squares of bins: the side lobes of a window that does not fall to 0 have no end.
const WIDEST: f64 = 1.0;

/// The power `|W(d)|^2` of a window's transform, `d` bins from the frequency of a wave, 1 at its top.
pub(super) struct Lobe {
    /// At multiples of `1 / FINE` bins.
    power: Vec<f64>,
    /// The largest power from there on.
    envelope: Vec<f64>,
    /// Bins from the top to the first zero.
    pub half: f64,
    /// Width at half of the power, in bins.
    pub width: f64,
    /// Variance of the lobe, in squares of bins: `sum (w_{n+1} - w_n)^2 / sum w^2` of the window w, over that of one bin; 1/3 of a
    /// Hann window, and 0 on an axis that is taken as periodic.
    pub variance: f64,
    /// How many neighbouring bins share one realisation: the sum of the correlations of their powers, `N sum w^4 / (sum w^2)^2`;
    /// 35/18 of a Hann window.
    pub shared: f64,
    /// Whether the axis is taken as periodic: there is no window, and waves that fit do not leak.
    periodic: bool,
}

impl Lobe {
    /// Of `window` over `length` samples.
    pub fn new(window: Window, length: usize) -> Lobe {
        let samples = window.samples(length.min(LONGEST));
        let of = |i: usize| transform(&samples, i as f64 / FINE as f64);
        let top = of(0);
        let power: Vec<f64> = (0..=REACH * FINE).map(|i| of(i) / top).collect();
        let mut envelope = power.clone();
        for i in (0..envelope.len() - 1).rev() {
            envelope[i] = envelope[i].max(envelope[i + 1]);
        }
        let first_rise = power.windows(2).position(|pair| pair[1] > pair[0]);
        let below = power.iter().position(|p| *p < 0.5).unwrap_or(1);
        let (high, low) = (power[below - 1], power[below]);
        let crossing = below as f64 - 1.0 + (high - 0.5) / (high - low);
        let periodic = window == Window::None;
        let pairs = samples.iter().zip(samples.iter().cycle().skip(1));
        let rises: f64 = pairs.map(|(a, b)| (b - a).powi(2)).sum();
        let energy = dot(&samples, &samples);
        let variance = rises / energy * (samples.len() as f64 / TAU).powi(2);
        let fourth: f64 = samples.iter().map(|w| w.powi(4)).sum();
        let most = if periodic { 0.0 } else { WIDEST };
        Lobe {
            variance: variance.min(most),
            shared: samples.len() as f64 * fourth / energy.powi(2),
            half: first_rise.unwrap_or(FINE) as f64 / FINE as f64,
            width: 2.0 * crossing / FINE as f64,
            periodic,
            power,
            envelope,
        }
    }

    fn at(&self, d: f64) -> f64 {
        let place = d.abs() * FINE as f64;
        let i = (place as usize).min(self.power.len() - 2);
        let share = place - i as f64;
        self.power[i] * (1.0 - share) + self.power[i + 1] * share
    }

    /// The most that a wave leaks to `d` bins from it, as a share of its peak; 0 within the main lobe, and
    /// on an axis that is taken as periodic.
    pub fn leak(&self, d: f64) -> f64 {
        let d = d.abs();
        if self.periodic || d < self.half {
            return 0.0;
        }
        let place = (d * FINE as f64) as usize;
        let last = self.envelope.len() - FINE;
        let beyond = || self.envelope[last] * ((last as f64 / FINE as f64) / d).powi(2);
        self.envelope.get(place).copied().unwrap_or_else(beyond)
    }

    /// How far the wave lies from the middle of three bins with these powers, between -1/2 and 1/2: the top
    /// of the parabola through their logarithms, corrected for this window.
    pub fn offset(&self, powers: [f64; 3]) -> f64 {
        let [top, _] = parabola(powers);
        let of_wave = |d: f64| parabola([1.0 + d, d, 1.0 - d].map(|d| self.at(d)))[0];
        find_root(0.0, 0.5, |d| of_wave(d) - top.abs()) * top.signum()
    }
}

fn transform(samples: &[f64], bins: f64) -> f64 {
    let step = TAU * bins / samples.len() as f64;
    let term = |(j, w): (usize, &f64)| Complex::from_polar(*w, step * j as f64);
    let sum: Complex<f64> = samples.iter().enumerate().map(term).sum();
    sum.norm_sqr()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_lobes_of_hann() {
        let lobe = Lobe::new(Window::Hann, 512);
        assert!((lobe.half - 2.0).abs() < 0.05 && (lobe.width - 1.4406).abs() < 2e-3);
        // The highest side lobe of a Hann window is 31.5 dB below its top.
        assert!((10.0 * lobe.leak(2.1).log10() + 31.47).abs() < 0.05);
        assert!((lobe.variance - 1.0 / 3.0).abs() < 1e-4);
        assert!((lobe.shared - 35.0 / 18.0).abs() < 1e-4);
        assert_eq!(lobe.leak(1.0), 0.0);
        assert!(lobe.leak(100.0) < 1e-9 && lobe.leak(100.0) > 0.0);
    }
}
