//! The equations of a family's waves on a grid of times, and their unknowns.

use std::f64::consts::{PI, TAU};

use super::family::Family;
use super::problem::Problem;
use super::series::Series;
use super::wave::Alternation;

/// The times `t_j = j L / (2 N)`, `j = 1 - N..=N`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    /// N.
    pub(super) half: usize,
    /// L.
    pub(super) period: f64,
}

impl Grid {
    /// The grid of about `density` points per unit of time.
    pub(super) fn new(period: f64, density: f64) -> Grid {
        Grid {
            half: (0.5 * period * density).ceil() as usize,
            period,
        }
    }

    /// Points per unit of time.
    pub(super) fn density(&self) -> f64 {
        2.0 * self.half as f64 / self.period
    }

    pub(super) fn time(&self, j: isize) -> f64 {
        0.5 * self.period * j as f64 / self.half as f64
    }

    /// The indices of the times; of an even function, those from 0 on.
    fn indices(&self, is_even: bool) -> std::ops::RangeInclusive<isize> {
        let half = self.half as isize;
        if is_even { 0..=half } else { 1 - half..=half }
    }

    /// Samples `g(t_m + shift)`, `m = 0..2N`, of the kernel
    /// `g(t) = (1/N) sum_k cos(w_k t) / w_k^2`. With it, `x(t) = sum_j g(t - t_j) f(t_j)` solves
    /// `-x'' = f` up to the mean.
    pub(super) fn kernel(&self, shift: f64) -> Vec<f64> {
        let n = self.half;
        let value = |m: isize| {
            let term = |k: usize| {
                let w = TAU * k as f64 / self.period;
                let weight = if k == n { 0.5 } else { 1.0 } / (n as f64 * w * w);
                weight * (w * (self.time(m) + shift)).cos()
            };
            (1..=n).map(term).sum()
        };
        (0..2 * n as isize).map(value).collect()
    }

    /// The value of a kernel at the time from one index to another.
    pub(super) fn at_lag(&self, kernel: &[f64], from: isize, to: isize) -> f64 {
        kernel[(to - from).rem_euclid(kernel.len() as isize) as usize]
    }
}

impl Family {
    fn is_even(&self) -> bool {
        self.alternation == Alternation::Stiffness
    }

    /// The unknowns in their order, as the contact and the index of the time. Those of a stiffness
    /// dimer are even; of a mass dimer the second contact mirrors the first.
    fn unknowns(&self, grid: Grid) -> impl Iterator<Item = (usize, isize)> {
        let is_even = self.is_even();
        let contacts = if is_even { 0..2 } else { 0..1 };
        contacts.flat_map(move |i| grid.indices(is_even).map(move |j| (i, j)))
    }

    /// The place of a contact's value among the unknowns.
    fn place(&self, grid: Grid, contact: usize, j: isize) -> usize {
        let n = grid.half as isize;
        let place = match (self.alternation, contact) {
            (Alternation::Stiffness, contact) => contact as isize * (n + 1) + j.abs(),
            (Alternation::Mass, 0) => n - 1 + j,
            (Alternation::Mass, _) => (n - 1 - j).rem_euclid(2 * n),
        };
        place as usize
    }

    /// The equations on a grid; theta is the stiffening, minus 1 for the mass dimer.
    pub(super) fn problem(&self, grid: Grid) -> Problem {
        let (plain, ahead, behind) = (grid.kernel(0.0), grid.kernel(0.5), grid.kernel(-0.5));
        let both: Vec<f64> = ahead.iter().zip(&behind).map(|(a, b)| a + b).collect();
        let count = self.unknowns(grid).count();
        let full = || grid.indices(false);
        // Of an equation: its contact, and the factors of its own force and of the other's.
        let kernel = |contact: usize, own: f64, other: &[f64]| {
            let mut rows = vec![vec![0.0; count]; count];
            for (_, j) in self.unknowns(grid).filter(|(i, _)| *i == contact) {
                let row = &mut rows[self.place(grid, contact, j)];
                for from in full() {
                    row[self.place(grid, contact, from)] += own * grid.at_lag(&plain, from, j);
                    row[self.place(grid, 1 - contact, from)] -= grid.at_lag(other, from, j);
                }
            }
            rows
        };
        let mut weights = vec![0.0; count];
        let places = (0..2).flat_map(|i| full().map(move |j| self.place(grid, i, j)));
        places.for_each(|place| weights[place] += 1.0);
        let end_of = |contact: usize| {
            let mut row = vec![0.0; count];
            row[self.place(grid, contact, grid.half as isize)] = 1.0;
            row
        };
        let (second, on_values, on_forces) = match self.alternation {
            Alternation::Stiffness => {
                let scale = 0.5 / (grid.half + 1) as f64;
                let sign = |(i, _)| if i == 0 { scale } else { -scale };
                let balance = self.unknowns(grid).map(sign).zip(&weights);
                let balance = balance.map(|(sign, weight)| sign * weight).collect();
                (
                    kernel(1, 2.0, &both),
                    vec![end_of(0), end_of(1)],
                    vec![balance],
                )
            }
            Alternation::Mass => {
                let slope = full().map(|j| slope_at_end(grid, j)).collect();
                (kernel(0, 1.0, &behind), vec![end_of(0), slope], Vec::new())
            }
        };
        Problem {
            exponent: self.exponent,
            kernels: [kernel(0, 2.0, &both), second],
            weights,
            block: grid.indices(self.is_even()).count(),
            on_values,
            on_forces,
        }
    }

    /// Values of psi, given by contact and time, at the unknowns.
    pub(super) fn sample(&self, grid: Grid, psi: impl Fn(usize, f64) -> f64) -> Vec<f64> {
        let unknowns = self.unknowns(grid);
        unknowns.map(|(i, j)| psi(i, grid.time(j))).collect()
    }

    /// The functions of both contacts with these values at the unknowns.
    pub(super) fn series(&self, grid: Grid, values: &[f64]) -> [Series; 2] {
        [0, 1].map(|contact| {
            let all = grid.indices(false);
            let values: Vec<f64> = all.map(|j| values[self.place(grid, contact, j)]).collect();
            Series::through(grid.period, &values)
        })
    }
}

/// The factor of the value at the time of index j in the slope of the series at half a period.
///
/// Source: L. N. Trefethen, *Spectral Methods in MATLAB* (2000), chapter 3.
fn slope_at_end(grid: Grid, j: isize) -> f64 {
    let lag = grid.half as isize - j;
    let sign = if lag % 2 == 0 { 1.0 } else { -1.0 };
    match lag {
        0 => 0.0,
        lag => sign * PI / grid.period / (PI * lag as f64 / (2 * grid.half) as f64).tan(),
    }
}
