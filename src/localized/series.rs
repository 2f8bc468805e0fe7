//! Functions of time as Fourier series.

use std::f64::consts::TAU;

/// `f(t) = sum_k cosine[k] cos(w_k t) + sine[k] sin(w_k t)`, `w_k = 2 pi k / period`, for times
/// within half a period of 0; 0 outside, where a localized wave has decayed.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    period: f64,
    cosine: Vec<f64>,
    sine: Vec<f64>,
}

impl Series {
    /// The series that interpolates values at the 2 N times `t_j = j L / (2 N)`, `j = 1 - N..=N`.
    pub(super) fn through(period: f64, values: &[f64]) -> Series {
        let (m, n) = (values.len(), values.len() / 2);
        let angles = (0..m).map(|j| TAU * j as f64 / m as f64);
        let waves: Vec<(f64, f64)> = angles.map(f64::sin_cos).collect();
        let terms = (0..=n).map(|k| {
            let is_end = k == 0 || k == n;
            let scale = if is_end { 1.0 } else { 2.0 } / m as f64;
            let (mut cosine, mut sine) = (0.0, 0.0);
            for (j, value) in values.iter().enumerate() {
                // The time index j - (n - 1) is j + n + 1 modulo m.
                let (sin, cos) = waves[k * (j + n + 1) % m];
                cosine += value * cos;
                sine += value * sin;
            }
            (scale * cosine, if is_end { 0.0 } else { scale * sine })
        });
        let (cosine, sine) = terms.unzip();
        Series {
            period,
            cosine,
            sine,
        }
    }

    /// Number of nonzero frequencies.
    pub(super) fn len(&self) -> usize {
        self.cosine.len() - 1
    }

    pub fn period(&self) -> f64 {
        self.period
    }

    /// The largest amplitude among the last tenth of the terms, relative to the largest of all: a
    /// measure of the truncation error.
    pub fn spectral_tail(&self) -> f64 {
        let terms = self.cosine.iter().zip(&self.sine);
        let size: Vec<f64> = terms.map(|(c, s)| c.hypot(*s)).collect();
        largest(&size[size.len() * 9 / 10..]) / largest(&size)
    }

    pub fn value(&self, time: f64) -> f64 {
        if time.abs() > 0.5 * self.period {
            return 0.0;
        }
        // Clenshaw's recurrence for both sums at once.
        let angle = TAU * time / self.period;
        let double = 2.0 * angle.cos();
        let ([mut c1, mut c2], [mut s1, mut s2]) = ([0.0; 2], [0.0; 2]);
        for (c, s) in self.cosine.iter().zip(&self.sine).skip(1).rev() {
            (c1, c2) = (c + double * c1 - c2, c1);
            (s1, s2) = (s + double * s1 - s2, s1);
        }
        self.cosine[0] + c1 * angle.cos() - c2 + s1 * angle.sin()
    }

    /// `f(t + shift)`.
    pub(super) fn shifted(&self, shift: f64) -> Series {
        self.map(|w, c, s| {
            let (sin, cos) = (w * shift).sin_cos();
            (c * cos + s * sin, s * cos - c * sin)
        })
    }

    pub fn derivative(&self) -> Series {
        self.map(|w, c, s| (w * s, -w * c))
    }

    /// The integral that vanishes at the ends of the period; the mean of f must be 0.
    pub(super) fn integral(&self) -> Series {
        let mut integral = self.map(|w, c, s| match w {
            0.0 => (0.0, 0.0),
            w => (-s / w, c / w),
        });
        integral.cosine[0] = -integral.value(0.5 * self.period);
        integral
    }

    /// `self - other`, of equal period and length.
    pub(super) fn minus(&self, other: &Series) -> Series {
        let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
        Series {
            period: self.period,
            cosine: difference(&self.cosine, &other.cosine),
            sine: difference(&self.sine, &other.sine),
        }
    }

    /// `factor * f`.
    pub(super) fn scaled(&self, factor: f64) -> Series {
        self.map(|_, c, s| (factor * c, factor * s))
    }

    /// The integral over a period.
    pub fn total(&self) -> f64 {
        self.cosine[0] * self.period
    }

    fn map(&self, term: impl Fn(f64, f64, f64) -> (f64, f64)) -> Series {
        let w = TAU / self.period;
        let terms = self.cosine.iter().zip(&self.sine).enumerate();
        let (cosine, sine) = terms.map(|(k, (c, s))| term(w * k as f64, *c, *s)).unzip();
        Series {
            period: self.period,
            cosine,
            sine,
        }
    }
}

/// The largest magnitude.
pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}
