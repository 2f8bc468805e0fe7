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
    /// The series that interpolates values at the times `t_j = j L / (2 N)`, `j = 0..=N`, of an
    /// even function of period L.
    pub(super) fn even(period: f64, values: &[f64]) -> Series {
        let n = values.len() - 1;
        let table = cosines(2 * n);
        let end = |k| if k == 0 || k == n { 0.5 } else { 1.0 };
        let cosine = (0..=n)
            .map(|k| {
                let sum: f64 = (0..=n)
                    .map(|j| end(j) * values[j] * table[k * j % (2 * n)])
                    .sum();
                2.0 * end(k) * sum / n as f64
            })
            .collect();
        Series {
            period,
            cosine,
            sine: vec![0.0; n + 1],
        }
    }

    /// The series that interpolates values at the 2 N times `t_j = j L / (2 N)`, `j = 1 - N..=N`.
    pub(super) fn full(period: f64, values: &[f64]) -> Series {
        let (m, n) = (values.len(), values.len() / 2);
        let table = cosines(4 * m);
        let end = |k| if k == 0 || k == n { 0.5 } else { 1.0 };
        let (mut cosine, mut sine) = (vec![0.0; n + 1], vec![0.0; n + 1]);
        for k in 0..=n {
            for (j, value) in values.iter().enumerate() {
                // Phase in units of 2 pi / (4 m). The time index is j - (n - 1) = j + n + 1 modulo
                // m.
                let turn = 4 * (k * (j + n + 1) % m);
                cosine[k] += value * table[turn];
                sine[k] += value * table[(turn + 3 * m) % (4 * m)];
            }
            cosine[k] *= 2.0 * end(k) / m as f64;
            sine[k] *= 2.0 / m as f64;
        }
        sine[0] = 0.0;
        sine[n] = 0.0;
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
        let size: Vec<f64> = (self.cosine.iter().zip(&self.sine))
            .map(|(c, s)| c.hypot(*s))
            .collect();
        let largest = |part: &[f64]| part.iter().fold(0.0, |m: f64, v| m.max(*v));
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
        let mut integral = self.map(|w, c, s| {
            if w == 0.0 {
                (0.0, 0.0)
            } else {
                (-s / w, c / w)
            }
        });
        integral.cosine[0] = -integral.value(0.5 * self.period);
        integral
    }

    /// `self + factor * other`, of equal period and length.
    pub(super) fn plus(&self, factor: f64, other: &Series) -> Series {
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + factor * b).collect();
        Series {
            period: self.period,
            cosine: sum(&self.cosine, &other.cosine),
            sine: sum(&self.sine, &other.sine),
        }
    }

    /// `factor * f`.
    pub(super) fn scaled(&self, factor: f64) -> Series {
        self.map(|_, c, s| (factor * c, factor * s))
    }

    /// `f(-t)`.
    pub(super) fn reversed(&self) -> Series {
        self.map(|_, c, s| (c, -s))
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

/// `cos(2 pi j / m)`, `j = 0..m`.
pub(super) fn cosines(m: usize) -> Vec<f64> {
    (0..m).map(|j| (TAU * j as f64 / m as f64).cos()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `exp(cos w t + sin 2 w t / 2)` has a series that ends below rounding.
    #[test]
    fn val_closed_form_of_a_periodic_function() {
        let (period, n) = (3.0, 40);
        let w = TAU / period;
        let f = |t: f64| ((w * t).cos() + 0.5 * (2.0 * w * t).sin()).exp();
        let slope = |t: f64| f(t) * w * (-(w * t).sin() + (2.0 * w * t).cos());
        let time = |j: usize| (j as f64 - (n as f64 - 1.0)) * period / (2 * n) as f64;
        let values: Vec<f64> = (0..2 * n).map(|j| f(time(j))).collect();
        let series = Series::full(period, &values);
        for t in [-1.49, -0.3, 0.0, 0.77, 1.5] {
            assert!((series.value(t) - f(t)).abs() < 1e-13);
            assert!((series.derivative().value(t) - slope(t)).abs() < 1e-12);
            assert!((series.shifted(0.01).shifted(-0.01).value(t) - f(t)).abs() < 1e-13);
            assert!((series.reversed().value(-t) - f(t)).abs() < 1e-13);
            let rise = series.derivative().integral().value(t);
            assert!((rise - (f(t) - f(1.5))).abs() < 1e-13);
        }
        assert!(series.spectral_tail() < 1e-15);
        assert_eq!(series.value(1.51), 0.0);
    }

    #[test]
    fn val_an_even_function_from_half_of_its_values() {
        let (period, n) = (3.0, 40);
        let f = |t: f64| (TAU / period * t).cos().exp();
        let values: Vec<f64> = (0..=n)
            .map(|j| f(j as f64 * period / (2 * n) as f64))
            .collect();
        let series = Series::even(period, &values);
        for t in [-1.4, 0.2, 1.5] {
            assert!((series.value(t) - f(t)).abs() < 1e-14);
        }
    }
}
