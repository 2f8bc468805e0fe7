//! Filters of a field in frequency and wavenumber.
//!
//! # Equation
//! `V(k, f) = sum_{n,j} v(t_n, x_j) exp(i (k x_j - 2 pi f t_n))` is multiplied by a gain and
//! transformed back. A gain of 1 gives the field back to rounding. The field is taken for periodic
//! in both directions: what leaves at one end enters at the other, so a record that does not end as
//! it begins is padded or tapered first.

use std::f64::consts::TAU;

use num_complex::Complex;

use crate::error::{Error, Result};
use column_fft::{ComplexToRealColumns, FftDirection, Filter2d, RealToComplexColumns};

/// Which waves pass.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Travelling {
    #[default]
    Anywhere,
    TowardPlusX,
    TowardMinusX,
    /// What has no direction: f or k is 0 or, with an even number of samples, at the Nyquist limit.
    Nowhere,
}

/// What of a field passes; nothing stated, all of it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Passband {
    /// `|f|` from and to, in cycles, both included.
    pub frequency: Option<(f64, f64)>,
    /// `|k|` from and to, in rad, both included.
    pub wavenumber: Option<(f64, f64)>,
    /// Phase velocities `|2 pi f / k|` from and to, both included: a fan in (f, k). The constant
    /// part has none and does not pass; at `k = 0` the velocity is infinite.
    pub speed: Option<(f64, f64)>,
    pub travelling: Travelling,
}

impl Passband {
    /// Checks that bands begin before they end.
    ///
    /// # Errors
    /// [`Error::Request`] names the band that does not.
    pub fn check(&self) -> Result<()> {
        let options = ["frequency", "wavenumber", "speed"].into_iter();
        for (option, band) in options.zip([self.frequency, self.wavenumber, self.speed]) {
            if let Some((from, to)) = band
                && !(0.0 <= from && from <= to)
            {
                let found = format!("{from} to {to}");
                return Err(Error::request(option, "0 <= from <= to", found));
            }
        }
        Ok(())
    }

    /// Whether a wave of frequency `f >= 0` and signed wavenumber k passes; `directed`: neither is
    /// 0 or a Nyquist limit.
    fn passes(&self, f: f64, k: f64, directed: bool) -> bool {
        let within = |value: f64, band: Option<(f64, f64)>| {
            band.is_none_or(|(from, to)| from <= value && value <= to)
        };
        let speed = TAU * f / k.abs();
        within(f, self.frequency)
            && within(k.abs(), self.wavenumber)
            && within(speed, self.speed)
            && match self.travelling {
                Travelling::Anywhere => true,
                Travelling::TowardPlusX => directed && k > 0.0,
                Travelling::TowardMinusX => directed && k < 0.0,
                Travelling::Nowhere => !directed,
            }
    }

    /// Of a field of `(times, sites)` with steps `dt` and `dx`: what multiplies the bins of frequency m.
    pub(crate) fn gain(
        &self,
        (times, sites): (usize, usize),
        (dt, dx): (f64, f64),
    ) -> impl Fn(usize, &mut [Complex<f64>]) + Sync {
        move |m: usize, row: &mut [Complex<f64>]| {
            let f = m as f64 / (times as f64 * dt);
            for (q, bin) in row.iter_mut().enumerate() {
                let turn = if 2 * q > sites { sites as f64 } else { 0.0 };
                let k = TAU * (q as f64 - turn) / (sites as f64 * dx);
                let edge = m == 0 || 2 * m == times || q == 0 || 2 * q == sites;
                if !self.passes(f, k, !edge) {
                    *bin = Complex::default();
                }
            }
        }
    }
}

/// Transforms of fields of `(times, sites)` there and back, with kernels `exp(+i k x)` along space.
pub(crate) fn space_time_filter(shape: (usize, usize)) -> Filter2d<f64> {
    Filter2d::new(shape, FftDirection::Inverse).expect("times and sites")
}

/// Bytes of working space that a thread needs at most for them, but for a few profiles; known before anything is planned.
pub(crate) fn space_time_filter_bytes((times, sites): (usize, usize)) -> u64 {
    // The scratch of the forward transform is kept during the inverse one.
    let numbers = RealToComplexColumns::<f64>::scratch_len_of(times, sites, sites)
        + ComplexToRealColumns::<f64>::scratch_len_of(times);
    (numbers * size_of::<Complex<f64>>()) as u64
}
