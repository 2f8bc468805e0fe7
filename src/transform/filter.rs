//! Filters of a field in frequency and wavenumber.
//!
//! # Equation
//! `V(k, f) = sum_{n,j} v(t_n, x_j) exp(i (k x_j - 2 pi f t_n))` is multiplied by a gain and
//! transformed back. A gain of 1 gives the field back to rounding. The field is taken for periodic
//! in both directions: what leaves at one end enters at the other, so a record that does not end as
//! it begins is padded or tapered first.

use std::f64::consts::TAU;

use ndarray::{Array2, ArrayView2};
use num_complex::Complex;

use crate::error::{Error, Result};
use column_fft::{ComplexToRealColumns, FftDirection, Filter2d, Real, RealToComplexColumns};

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
        for (option, band) in [
            ("frequency", self.frequency),
            ("wavenumber", self.wavenumber),
            ("speed", self.speed),
        ] {
            let Some((from, to)) = band else { continue };
            if !(0.0 <= from && from <= to) {
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
}

/// Filters fields of one shape, planned once.
#[derive(Debug)]
pub struct SpaceTimeFilter<T: Real> {
    pub(crate) plan: Filter2d<T>,
}

impl<T: Real> SpaceTimeFilter<T> {
    /// Plans filters of fields of `(times, sites)`.
    ///
    /// # Panics
    /// If there are no times or no sites.
    pub fn new(shape: (usize, usize)) -> Self {
        SpaceTimeFilter {
            // Kernels `exp(+i k x)` along space.
            plan: Filter2d::new(shape, FftDirection::Inverse).expect("times and sites"),
        }
    }

    /// Bytes of working space that a thread needs at most for fields of `(times, sites)`, but for a
    /// few profiles; known before anything is planned.
    pub(crate) fn working_bytes((times, sites): (usize, usize)) -> u64 {
        // The scratch of the forward transform is kept during the inverse one.
        let numbers = RealToComplexColumns::<T>::scratch_len_of(times, sites, sites)
            + ComplexToRealColumns::<T>::scratch_len_of(times);
        (numbers * size_of::<Complex<T>>()) as u64
    }

    /// What of `values`, `(time, site)` with steps `dt` and `dx`, passes `band`. By all threads of
    /// the current pool, with the same bits from any number of them.
    ///
    /// # Errors
    /// As [`Passband::check`].
    ///
    /// # Panics
    /// If the shape is not that of the plan.
    pub fn apply(
        &self,
        values: ArrayView2<T>,
        (dt, dx): (f64, f64),
        band: &Passband,
    ) -> Result<Array2<T>> {
        band.check()?;
        let shape = self.plan.shape();
        assert_eq!(values.dim(), shape);
        let mut filtered = Array2::default(shape);
        let gain = self.gain((dt, dx), band);
        let into = filtered.view_mut();
        let passed = self.plan.process_in_parallel(values, into, gain);
        passed.expect("shapes of the plan");
        Ok(filtered)
    }

    /// What multiplies the bins of frequency m.
    pub(crate) fn gain<'a>(
        &self,
        (dt, dx): (f64, f64),
        band: &'a Passband,
    ) -> impl Fn(usize, &mut [Complex<T>]) + Sync + use<'a, T> {
        let (times, sites) = self.plan.shape();
        move |m: usize, row: &mut [Complex<T>]| {
            let f = m as f64 / (times as f64 * dt);
            for (q, bin) in row.iter_mut().enumerate() {
                let turn = if 2 * q > sites { sites as f64 } else { 0.0 };
                let k = TAU * (q as f64 - turn) / (sites as f64 * dx);
                let edge = m == 0 || 2 * m == times || q == 0 || 2 * q == sites;
                if !band.passes(f, k, !edge) {
                    *bin = Complex::default();
                }
            }
        }
    }
}
