//! Waves both ways in a band of frequencies: their amplitudes, their loss, their wavenumber and its slope.

use std::array::from_fn;
use std::f64::consts::TAU;
use std::ops::Range;

use ndarray::{Array1, ArrayView1};
use num_complex::Complex;

use super::NoFlux;
use crate::numeric::{eliminated, jackknife};

/// Groups of sites, and of frequencies, that count half in turn: left out, those at the ends of a parabola would say too much.
pub(super) const GROUPS: usize = 10;
const HALF: f64 = 0.5;
const ITERATIONS: i32 = 12;
/// Share of its row below which a pivot is none.
const SINGULAR: f64 = 1e-12;
/// Rows of a band at most in which another wave is looked for.
const LOOKED_AT: usize = 16;
/// Share of the power above which what the waves leave may be another wave, whose flux is beyond the interval. It is one if more of
/// it is in one wavenumber than noise has in such a share of rows.
const LEFT: f64 = 0.01;
const RARE: f64 = 0.02;
/// Power of the waves over that of the noise in as many unknowns, at least.
const OVER_NOISE: f64 = 2.0;
/// Phase, or logarithm of the amplitude, to which a wave is known over all sites at least: beyond it errors are none of a linear fit.
const KNOWN: f64 = 0.5;
/// Share of itself to which the group velocity is known at least.
const VELOCITY_KNOWN: f64 = 0.3;
/// Share of the shapes of the two waves that is not the same at least, at each frequency: one at which they are (a wavelength of many
/// arrays, or of two sites) has more error than all others.
const TOLD_APART: f64 = 0.2;
/// Factor between the power at an end and that of the waves there at most.
const AT_ENDS: f64 = 1.5;
/// Square of what is left of a wave of amplitude 1 without the other at which both are the same.
const SAME: f64 = 1e-9;

/// Loss and wavenumber in the middle of the band, and the wavenumber's changes by the offset and by its square.
pub(super) type Unknowns = [f64; 4];
/// Weight of rows of which each is one.
const EVERY: fn(&Row) -> f64 = |_| 1.0;
type Line = Array1<Complex<f64>>;

/// One frequency of one shot at one site of each cell.
pub(super) struct Row<'a> {
    pub spectrum: ArrayView1<'a, Complex<f64>>,
    /// Of its sites, from the first one of all.
    pub distances: ArrayView1<'a, f64>,
    /// Of its frequency from the middle of the band, over the frequency there.
    pub offset: f64,
    /// Wavenumber of a stated relation, 0 where it is searched; the group velocity, if it is stated.
    pub wavenumber: f64,
    pub velocity: Option<f64>,
    /// What the square of an amplitude is of the flux, over the group velocity.
    pub weight: f64,
    /// Shots are as random as they differ; frequencies of one record in blocks, since neighbours share a window's lobe.
    pub group: usize,
}

/// What is so of all bands.
pub(super) struct Setup {
    /// 1 of waves towards +x and towards -x that there are, 0 of others.
    pub ways: [f64; 2],
    /// Of shots, or of frequencies of one record.
    pub groups: usize,
    /// From the first site to the last.
    pub span: f64,
    pub is_law: bool,
    /// Whether a transient is as it is, and its power has no random spread.
    pub is_single: bool,
    /// Deviation of the frequencies of the waves of a band, in cycles, from which on they have a slope: a tone has none.
    pub spread: f64,
    /// Power of the wavenumber by which the square of a sample is that of a velocity.
    pub strain: i32,
}

/// Rows of one band, each `A exp(-(loss + i wavenumber) x) + B exp(-(loss + i wavenumber) (span - x))`, and noise.
pub(super) struct Band<'a> {
    pub setup: &'a Setup,
    pub rows: Vec<Row<'a>>,
    pub middle: f64,
}

/// What is found of a band.
#[derive(Debug, Clone, Copy)]
pub(super) struct Numbers {
    /// Of amplitude.
    pub loss: f64,
    /// The mean by power; the wavenumber and the group velocity there.
    pub frequency: f64,
    pub wavenumber: f64,
    pub velocity: f64,
    /// Deviation of the frequencies by power.
    spread: f64,
    /// Of both waves where they enter.
    pub flux: [f64; 2],
}

pub(super) struct Found {
    pub numbers: Numbers,
    /// The same with half of each group of sites, and of rows.
    halved: [Vec<Numbers>; 2],
}

/// All rows at some unknowns.
struct Fit {
    at: Unknowns,
    rows: Vec<Fitted>,
}

struct Fitted {
    amplitudes: [Complex<f64>; 2],
    /// What the square of each has of a unit of noise.
    noise: [f64; 2],
    /// `1 - |<A|B>|^2` of both waves' shapes.
    apart: f64,
    /// What the waves leave.
    left: Line,
    /// By the exponent, half of the slope of the square of that, and of its bend.
    slope: Complex<f64>,
    bend: f64,
}

impl Found {
    /// Standard error of a sum over bands: the larger one of what groups of sites say (noise, gains), which are those of all bands,
    /// and groups of rows of each (noise, random powers, waves cut by the record).
    pub fn error(found: &[&Found], of: &dyn Fn(&Numbers) -> f64) -> f64 {
        let sum = |g: usize| found.iter().map(|found| of(&found.halved[0][g])).sum();
        let sites: Vec<f64> = (0..GROUPS).map(sum).collect();
        let rows = found.iter().map(|found| {
            let rows: Vec<f64> = found.halved[1].iter().map(of).collect();
            jackknife(&rows).powi(2)
        });
        jackknife(&sites).max(rows.sum::<f64>().sqrt()) / (1.0 - HALF)
    }
}

impl Row<'_> {
    /// `loss + i wavenumber`.
    fn exponent(&self, at: &Unknowns) -> Complex<f64> {
        Complex::new(at[0], self.wavenumber + searched(at, self.offset))
    }
}

impl Fit {
    /// Power of what the waves leave.
    fn left(&self) -> f64 {
        self.rows.iter().map(|row| square(&row.left)).sum()
    }
}

impl Band<'_> {
    /// What is found from the best of some starts.
    pub fn found(&self, starts: &[Unknowns]) -> Result<Found, NoFlux> {
        let tried = starts.iter().map(|start| self.least_squares(*start));
        let best = tried.min_by(|a, b| a.left().total_cmp(&b.left()));
        let fit = best.ok_or(NoFlux::NoWave)?;
        let weight = |is_halved: bool| if is_halved { HALF } else { 1.0 };
        // Of neighbours: with less of them the fit tells how far it is off where waves change along x.
        let of_sites = |g: usize| {
            let n = self.rows[0].spectrum.len();
            let sites = Array1::from_shape_fn(n, |j| weight(j * GROUPS / n == g));
            let at = self.step(&self.fit(fit.at, &sites), &EVERY, 0.0);
            self.numbers(&self.fit(at, &sites), &EVERY)
        };
        let of_rows = |g: usize| {
            let at = self.step(&fit, &|row| weight(row.group == g), 0.0);
            let power = |row: &Row| weight(row.group == g && !self.setup.is_single);
            self.numbers(&self.fit(at, &self.all()), &power)
        };
        let sites = (0..GROUPS).map(of_sites).collect();
        let found = Found {
            numbers: self.numbers(&fit, &EVERY),
            halved: [sites, (0..self.setup.groups).map(of_rows).collect()],
        };
        self.checked(found, &fit)
    }

    /// What is found, if it is of one wave each way.
    fn checked(&self, found: Found, fit: &Fit) -> Result<Found, NoFlux> {
        let n = self.rows[0].spectrum.len();
        // Of samples less so much of what the waves leave.
        let power = |sites: Range<usize>, less: f64| -> f64 {
            let of_row = |(row, fitted): (&Row, &Fitted)| -> f64 {
                let site = |j: usize| row.spectrum[j] - fitted.left[j] * less;
                sites.clone().map(|j| site(j).norm_sqr()).sum()
            };
            self.rows.iter().zip(&fit.rows).map(of_row).sum()
        };
        let noise = self.noise(fit) * fit.rows.len() as f64;
        // Noise adds to the power of sites, and takes nothing from it.
        let is_cut = |sites: Range<usize>| {
            let all_noise = noise * sites.len() as f64;
            let (found, waves) = (power(sites.clone(), 0.0), power(sites, 1.0));
            f64::max(waves / found, found / (waves + all_noise)) > AT_ENDS
        };
        let width = n.div_ceil(GROUPS);
        // Share that one wavenumber has of what is left: 1 of another wave, ln(n) / n of noise.
        let in_one = |row: &Fitted| {
            let turn = |m: usize| Complex::cis(TAU * m as f64 / n as f64);
            let sum = |turn: Complex<f64>| row.left.fold(Complex::ZERO, |sum, x| sum * turn + x);
            let bins = (0..n).map(|m| sum(turn(m)).norm_sqr());
            bins.fold(0.0, f64::max) / n as f64
        };
        let looked_at = fit.rows.iter().step_by(fit.rows.len().div_ceil(LOOKED_AT));
        let all = looked_at.clone().map(|row| square(&row.left));
        let share = looked_at.map(in_one).sum::<f64>() / all.sum::<f64>();
        let error = |of: &dyn Fn(&Numbers) -> f64| Found::error(&[&found], of);
        let off = error(&|n| n.loss).max(error(&|n| n.wavenumber)) * self.setup.span;
        let numbers = &found.numbers;
        let off_velocity = error(&|n| n.velocity) / numbers.velocity;
        let least = OVER_NOISE * noise * (self.setup.ways[0] + self.setup.ways[1]);
        let apart = fit.rows.iter().map(|row| row.apart).fold(1.0, f64::min);
        let is_other =
            fit.left() > LEFT * power(0..n, 0.0) && share > (n as f64 / RARE).ln() / n as f64;
        let is_cut = is_cut(0..width) || is_cut(n - width..n);
        let decays = numbers.loss.abs() * TAU > numbers.wavenumber.abs();
        let is_tone = self.rows[0].velocity.is_none() && numbers.spread < self.setup.spread;
        let is_open = is_tone || !(0.0..VELOCITY_KNOWN).contains(&off_velocity);
        let reasons = [
            (is_other, NoFlux::SeveralWaves),
            (power(0..n, 1.0) < least, NoFlux::NoWave),
            (apart < TOLD_APART, NoFlux::Directions),
            (off.is_nan() || off > KNOWN, NoFlux::NoWave),
            (is_cut, NoFlux::Ends),
            (decays && numbers.wavenumber != 0.0, NoFlux::Evanescent),
            (is_open, NoFlux::Velocity),
        ];
        let reason = reasons.into_iter().find(|(is_so, _)| *is_so);
        reason.map_or(Ok(found), |(_, reason)| Err(reason))
    }

    /// All sites, each as one.
    fn all(&self) -> Array1<f64> {
        Array1::ones(self.rows[0].spectrum.len())
    }

    /// By the method of Levenberg and Marquardt, with a damping that falls.
    fn least_squares(&self, start: Unknowns) -> Fit {
        let next = |fit: Fit, n: i32| {
            let at = self.step(&fit, &EVERY, 0.5f64.powi(n));
            self.fit(at, &self.all())
        };
        (0..ITERATIONS).fold(self.fit(start, &self.all()), next)
    }

    /// Of sites that count so much. The amplitudes are eliminated (variable projection).
    fn fit(&self, at: Unknowns, sites: &Array1<f64>) -> Fit {
        let roots = sites.mapv(f64::sqrt);
        let of_row = |row: &Row| {
            let away = [row.distances.to_owned(), self.setup.span - &row.distances];
            let shape = |way: usize| -> Line {
                let decay = away[way].mapv(|x| (-x * row.exponent(&at)).exp());
                decay * &roots * self.setup.ways[way]
            };
            let shapes = [shape(0), shape(1)];
            // Each wave as far as the other has nothing of it.
            let own: [Line; 2] = from_fn(|way| {
                let (own, other) = (&shapes[way], &shapes[1 - way]);
                own - other * over(dot(other, own), square(other))
            });
            let fit = |line: &Line| own.each_ref().map(|own| over(dot(own, line), square(own)));
            let rest = |line: &Line| {
                let [a, b] = fit(line);
                line - &shapes[0] * a - &shapes[1] * b
            };
            let spectrum = &row.spectrum * &roots;
            let amplitudes = fit(&spectrum);
            let change = |way: usize| &shapes[way] * &away[way] * -amplitudes[way];
            // The derivative of the waves by the exponent, less what the amplitudes make up for.
            let (left, change) = (rest(&spectrum), rest(&(change(0) + change(1))));
            Fitted {
                amplitudes,
                noise: own.each_ref().map(|own| over(Complex::ONE, square(own)).re),
                apart: square(&own[0]) / square(&shapes[0]),
                slope: dot(&change, &left),
                bend: square(&change),
                left,
            }
        };
        let rows = self.rows.iter().map(of_row).collect();
        Fit { at, rows }
    }

    /// The next unknowns, of rows that count so much.
    fn step(&self, fit: &Fit, weight: &dyn Fn(&Row) -> f64, damping: f64) -> Unknowns {
        let sum = |of: &dyn Fn(&Fitted) -> f64, power: i32| -> f64 {
            let all = self.rows.iter().zip(&fit.rows);
            all.map(|(row, fitted)| weight(row) * of(fitted) * row.offset.powi(power))
                .sum()
        };
        let bends = [0, 1, 2, 3, 4].map(|power| sum(&|fitted| fitted.bend, power));
        // The derivatives by wavenumbers are i times that by the loss, which has no part in them.
        let equation = |a: usize| {
            let slope = sum(&|fitted| fitted.slope.im, a as i32);
            let mut row = vec![bends[a], bends[a + 1], bends[a + 2], slope];
            row[a] *= 1.0 + damping;
            row
        };
        let equations = if self.setup.is_law { 0 } else { 3 };
        let equations = (0..equations).map(equation).collect();
        let solved = eliminated(equations, SINGULAR).unwrap_or_default();
        let mut next = fit.at;
        next[0] += sum(&|fitted| fitted.slope.re, 0) / (bends[0] * (1.0 + damping));
        let wavenumbers = next[1..].iter_mut().zip(&solved);
        wavenumbers.for_each(|(value, step)| *value += step[0]);
        next
    }

    /// Mean square of the noise at a site.
    fn noise(&self, fit: &Fit) -> f64 {
        let freedom = self.all().sum() - self.setup.ways[0] - self.setup.ways[1];
        fit.left() / (freedom * fit.rows.len() as f64)
    }

    /// What rows say, which count so much for the flux.
    fn numbers(&self, fit: &Fit, weight: &dyn Fn(&Row) -> f64) -> Numbers {
        let (at, noise, of_slope) = (&fit.at, self.noise(fit), TAU * self.middle);
        let (mut sums, mut flux, mut count) = ([0.0; 5], [0.0; 2], 0.0);
        for (row, fitted) in self.rows.iter().zip(&fit.rows) {
            let measured = of_slope / (at[2] + 2.0 * row.offset * at[3]);
            let velocity = row.velocity.unwrap_or(measured);
            let wavenumber = row.exponent(at).im;
            let strain = wavenumber.powi(self.setup.strain);
            let powers = fitted.amplitudes.map(|amplitude| amplitude.norm_sqr());
            let squared = row.offset.powi(2);
            let terms = [1.0, row.offset, squared, row.wavenumber, 1.0 / velocity];
            sums = from_fn(|n| sums[n] + (powers[0] + powers[1]) * terms[n]);
            let times = weight(row) * row.weight * velocity * strain;
            flux = from_fn(|way| flux[way] + times * (powers[way] - noise * fitted.noise[way]));
            count += weight(row);
        }
        let [power, offset, squares, wavenumber, slowness] = sums;
        Numbers {
            loss: at[0],
            frequency: self.middle * (1.0 + offset / power),
            wavenumber: wavenumber / power + searched(at, offset / power),
            velocity: power / slowness,
            spread: self.middle * (squares / power - (offset / power).powi(2)).sqrt(),
            flux: flux.map(|flux| flux * self.rows.len() as f64 / count),
        }
    }
}

/// The wavenumber, less that of a stated relation.
fn searched(at: &Unknowns, offset: f64) -> f64 {
    at[1] + offset * (at[2] + offset * at[3])
}

fn dot(a: &Line, b: &Line) -> Complex<f64> {
    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
}

fn square(line: &Line) -> f64 {
    line.iter().map(Complex::norm_sqr).sum()
}

/// 0 of a wave that there is not, or that is the same as the other.
fn over(part: Complex<f64>, power: f64) -> Complex<f64> {
    match power > SAME {
        true => part / power,
        false => Complex::ZERO,
    }
}
