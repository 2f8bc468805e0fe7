//! Waves both ways in a band of frequencies: their amplitudes, their loss, their wavenumber and its slope.

use std::f64::consts::TAU;

use num_complex::Complex;

use crate::numeric::{eliminated, jackknife};

/// Groups of sites, and of rows, that are left out in turn.
pub(super) const GROUPS: usize = 10;
const ITERATIONS: usize = 40;
/// Rows of a band at most in which another wave is looked for.
const LOOKED_AT: usize = 16;
/// Share of its row below which a pivot is none.
const SINGULAR: f64 = 1e-12;
/// Loss and wavenumber in the middle, and the wavenumber's changes by the offset and by its square.
pub(super) type Unknowns = [f64; 4];
const ZERO: Complex<f64> = Complex::new(0.0, 0.0);

/// One frequency of one shot.
pub(super) struct Row<'a> {
    /// Of each site.
    pub spectrum: &'a [Complex<f64>],
    pub frequency: f64,
    /// From the middle of the band, -1 to 1 at its ends.
    pub offset: f64,
    /// Wavenumber per site and group velocity in sites of a stated relation; 0 and `None` where they are searched.
    pub wavenumber: f64,
    pub velocity: Option<f64>,
    /// What the square of an amplitude is of the flux, over the group velocity.
    pub weight: f64,
    /// Cells from the first site of all to this row's first, and from its last to the last of all.
    pub beyond: [f64; 2],
}

/// Rows of one band, by rising frequency, each `A q^j + B q^(n-1-j)` with `q = exp(-(loss + i wavenumber))`, and noise.
pub(super) struct Band<'a> {
    pub rows: Vec<Row<'a>>,
    pub shots: usize,
    /// Where the search begins.
    pub starts: Vec<Unknowns>,
    /// How many unknowns are searched.
    pub unknowns: usize,
    /// Whether there are waves towards earlier sites, B, too.
    pub is_both: bool,
    /// Whether a transient is as it is, and its power has no random spread.
    pub is_single: bool,
    /// Half of the band in cycles.
    pub half: f64,
    /// Length of a cell where samples are strain rates.
    pub strain: Option<f64>,
}

/// Per cell: the loss of amplitude; frequency, wavenumber, group velocity, means by power; the flux of both waves where they enter.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Numbers {
    pub loss: f64,
    pub frequency: f64,
    pub wavenumber: f64,
    pub velocity: f64,
    pub flux: [f64; 2],
}

#[derive(Debug, Clone)]
pub(super) struct Found {
    pub numbers: Numbers,
    /// The same without each group of sites, and of rows.
    pub without: [Vec<Numbers>; 2],
    /// Power of the waves over that of as many unknowns of noise.
    pub over_noise: f64,
    /// `1 - |<A|B>|^2` of the two waves' shapes.
    pub apart: f64,
    /// Share of the power that the waves leave, and of that the share of one wavenumber: 1 of another wave, `ln(n) / n` of noise.
    pub left: [f64; 2],
    /// The largest factor between the power that the waves have among the sites of an end, and that of these sites.
    pub ends: f64,
}

impl Found {
    /// Standard errors of a quantity by what is left out: sites, and rows.
    pub fn errors(&self, of: impl Fn(&Numbers) -> f64) -> [f64; 2] {
        let error =
            |list: usize| jackknife(&self.without[list].iter().map(&of).collect::<Vec<_>>());
        [error(0), error(1)]
    }

    /// The larger one, of what has no random spread: noise is in both, gains are in sites, waves cut by the record in rows.
    pub fn error(&self, of: impl Fn(&Numbers) -> f64) -> f64 {
        let [sites, rows] = self.errors(of);
        sites.max(rows)
    }
}

/// Sums over rows at some unknowns.
#[derive(Default)]
struct Sums {
    normal: [Unknowns; 4],
    gradient: Unknowns,
    residual: f64,
    squares: f64,
    /// Complex numbers that the waves do not explain.
    left: f64,
    apart: f64,
    /// Both amplitudes of each row, and what their squares have of a unit of noise.
    waves: Vec<([Complex<f64>; 2], [f64; 2])>,
}

impl Band<'_> {
    pub fn found(&self) -> Found {
        let tried = self.starts.iter().map(|start| self.least_squares(*start));
        let best = tried.min_by(|a, b| a.1.residual.total_cmp(&b.1.residual));
        let (at, sums) = best.unwrap_or_default();
        let n = self.rows[0].spectrum.len();
        let sites = GROUPS.min(n);
        // Shots are as random as they differ; frequencies of one record in blocks, since neighbours share a window's lobe.
        let count = if self.shots > 1 {
            self.shots
        } else {
            GROUPS.min(self.rows.len())
        };
        let group = |i: usize| match self.shots {
            1 => i * count / self.rows.len(),
            shots => i % shots,
        };
        let without_sites = |g: usize| {
            // Neighbours, without which the fit tells how far it is off where waves change along x.
            let has = |j: usize| j * sites / n != g;
            let at = self
                .step(&at, &self.sums(&at, has, every), 0.0)
                .unwrap_or(at);
            self.numbers(&at, &self.sums(&at, has, every), every)
        };
        let without_rows = |g: usize| {
            let has = |i: usize| group(i) != g;
            let at = self
                .step(&at, &self.sums(&at, every, has), 0.0)
                .unwrap_or(at);
            let sums = self.sums(&at, every, every);
            self.numbers(&at, &sums, |i| self.is_single || has(i))
        };
        let waves = if self.is_both { 2.0 } else { 1.0 } * self.rows.len() as f64;
        Found {
            numbers: self.numbers(&at, &sums, every),
            without: [
                (0..sites).map(without_sites).collect(),
                (0..count).map(without_rows).collect(),
            ],
            over_noise: (sums.squares - sums.residual) / waves / (sums.residual / sums.left),
            apart: sums.apart / self.rows.len() as f64,
            left: [sums.residual / sums.squares, self.in_one(&at, &sums)],
            ends: self.ends(&at, &sums),
        }
    }

    /// Noise adds to the power of sites, and takes nothing from it.
    fn ends(&self, at: &Unknowns, sums: &Sums) -> f64 {
        let n = self.rows[0].spectrum.len();
        let (width, noise) = (n.div_ceil(GROUPS), sums.residual / sums.left);
        let factor = |from: usize| {
            let (mut found, mut waves) = (0.0, 0.0);
            for (row, ([a, b], _)) in self.rows.iter().zip(&sums.waves) {
                let ratio = (-Self::exponent(row, at)).exp();
                for j in from..from + width {
                    let wave = a * ratio.powu(j as u32) + b * ratio.powu((n - 1 - j) as u32);
                    found += row.spectrum[j].norm_sqr();
                    waves += wave.norm_sqr();
                }
            }
            let all_noise = noise * (self.rows.len() * width) as f64;
            f64::max(waves / found, found / (waves + all_noise))
        };
        f64::max(factor(0), factor(n - width))
    }

    /// Share of what the waves leave of each of some rows that one wavenumber holds, a mean.
    fn in_one(&self, at: &Unknowns, sums: &Sums) -> f64 {
        let n = self.rows[0].spectrum.len();
        let share = |(row, ([a, b], _)): (&Row, &([Complex<f64>; 2], [f64; 2]))| {
            let ratio = (-Self::exponent(row, at)).exp();
            let wave = |j: usize| a * ratio.powu(j as u32) + b * ratio.powu((n - 1 - j) as u32);
            let left = row.spectrum.iter().enumerate();
            let left: Vec<Complex<f64>> = left.map(|(j, x)| x - wave(j)).collect();
            let of = |m: usize| {
                let turn = |j: usize| Complex::cis(TAU * (m * j % n) as f64 / n as f64);
                let terms = left.iter().enumerate().map(|(j, x)| x * turn(j));
                terms.sum::<Complex<f64>>().norm_sqr()
            };
            let all: f64 = left.iter().map(|x| x.norm_sqr()).sum();
            (0..n).map(of).fold(0.0, f64::max) / (n as f64 * all)
        };
        let rows = self.rows.iter().zip(&sums.waves);
        let shares = rows.step_by(self.rows.len().div_ceil(LOOKED_AT)).map(share);
        let shares: Vec<f64> = shares.collect();
        shares.iter().sum::<f64>() / shares.len() as f64
    }

    /// By the method of Levenberg and Marquardt.
    fn least_squares(&self, mut at: Unknowns) -> (Unknowns, Sums) {
        let mut sums = self.sums(&at, every, every);
        let mut damping = 1e-3;
        for _ in 0..ITERATIONS {
            let Some(tried) = self.step(&at, &sums, damping) else {
                break;
            };
            let next = self.sums(&tried, every, every);
            let gain = sums.residual - next.residual;
            let is_done = (0.0..=1e-14 * sums.squares).contains(&gain) || damping > 1e8;
            if gain >= 0.0 {
                (at, sums) = (tried, next);
            }
            if is_done {
                break;
            }
            damping *= if gain >= 0.0 { 0.1 } else { 10.0 };
        }
        (at, sums)
    }

    /// `loss + i wavenumber` of a row.
    fn exponent(row: &Row, at: &Unknowns) -> Complex<f64> {
        let searched = at[1] + row.offset * (at[2] + row.offset * at[3]);
        Complex::new(at[0], row.wavenumber + searched)
    }

    /// Sums of some sites and rows.
    fn sums(
        &self,
        at: &Unknowns,
        has_site: impl Fn(usize) -> bool,
        has_row: impl Fn(usize) -> bool,
    ) -> Sums {
        let n = self.rows[0].spectrum.len();
        let kept: Vec<usize> = (0..n).filter(|j| has_site(*j)).collect();
        let (mut sums, mut shape) = (Sums::default(), vec![ZERO; n]);
        for (_, row) in self.rows.iter().enumerate().filter(|(i, _)| has_row(*i)) {
            let (ratio, mut power) = ((-Self::exponent(row, at)).exp(), Complex::new(1.0, 0.0));
            for value in &mut shape {
                *value = power;
                power *= ratio;
            }
            self.add(row, &shape, &kept, &mut sums);
        }
        sums
    }

    /// Adds a row, whose amplitudes are eliminated (variable projection).
    fn add(&self, row: &Row, shape: &[Complex<f64>], kept: &[usize], sums: &mut Sums) {
        let last = shape.len() - 1;
        let (mut gram, mut cross, mut right) = ([0.0; 2], ZERO, [ZERO; 2]);
        for j in kept {
            let (a, b, x) = (shape[*j], shape[last - j], row.spectrum[*j]);
            gram[0] += a.norm_sqr();
            gram[1] += b.norm_sqr();
            cross += a.conj() * b;
            right[0] += a.conj() * x;
            right[1] += b.conj() * x;
        }
        let apart = gram[0] * gram[1] - cross.norm_sqr();
        // The inverse of the Gram matrix of the shapes.
        let (own, other) = match self.is_both {
            true => ([gram[1] / apart, gram[0] / apart], -cross / apart),
            false => ([1.0 / gram[0], 0.0], ZERO),
        };
        let solved = |right: [Complex<f64>; 2]| {
            let first = right[0] * own[0] + other * right[1];
            [first, right[1] * own[1] + other.conj() * right[0]]
        };
        let waves = solved(right);
        let (mut slope, mut along, mut size) = (ZERO, [ZERO; 2], 0.0);
        for j in kept {
            let (a, b) = (shape[*j], shape[last - j]);
            let residual = row.spectrum[*j] - waves[0] * a - waves[1] * b;
            // The derivative of the waves by the exponent.
            let change = waves[1] * b * (*j as f64 - last as f64) - waves[0] * a * *j as f64;
            slope += change.conj() * residual;
            size += change.norm_sqr();
            along[0] += a.conj() * change;
            along[1] += b.conj() * change;
            sums.residual += residual.norm_sqr();
            sums.squares += row.spectrum[*j].norm_sqr();
        }
        let explained = solved(along);
        let explained = along[0].conj() * explained[0] + along[1].conj() * explained[1];
        // The derivatives by wavenumbers are i times that by the loss.
        let powers = [1.0, 1.0, row.offset, row.offset * row.offset];
        for (i, p) in powers.iter().enumerate() {
            sums.gradient[i] += p * if i == 0 { slope.re } else { slope.im };
            for (j, q) in powers
                .iter()
                .enumerate()
                .filter(|(j, _)| (i == 0) == (*j == 0))
            {
                sums.normal[i][j] += (size - explained.re) * p * q;
            }
        }
        sums.left += kept.len() as f64 - if self.is_both { 2.0 } else { 1.0 };
        sums.apart += apart / (gram[0] * gram[1]);
        sums.waves.push((waves, own));
    }

    /// The next unknowns.
    fn step(&self, at: &Unknowns, sums: &Sums, damping: f64) -> Option<Unknowns> {
        let row = |i: usize| {
            let mut row = sums.normal[i][..self.unknowns].to_vec();
            row[i] *= 1.0 + damping;
            row.push(sums.gradient[i]);
            row
        };
        let solved = eliminated((0..self.unknowns).map(row).collect(), SINGULAR)?;
        let mut next = *at;
        next.iter_mut()
            .zip(&solved)
            .for_each(|(value, step)| *value += step[0]);
        Some(next)
    }

    /// What the sums over all rows say; the flux is that of all by those of some.
    fn numbers(&self, at: &Unknowns, sums: &Sums, has: impl Fn(usize) -> bool) -> Numbers {
        let noise = sums.residual / sums.left;
        let mut numbers = Numbers {
            loss: at[0],
            ..Numbers::default()
        };
        let (mut all, mut slowness, mut counted) = (0.0, 0.0, 0.0);
        for (i, (row, (waves, own))) in self.rows.iter().zip(&sums.waves).enumerate() {
            let [a, b] = waves.map(|wave| wave.norm_sqr());
            let slope = (at[2] + 2.0 * row.offset * at[3]) / self.half;
            let (power, velocity) = (a + b, row.velocity.unwrap_or(TAU / slope));
            all += power;
            slowness += power / velocity;
            numbers.frequency += power * row.frequency;
            numbers.wavenumber += power * Self::exponent(row, at).im;
            if has(i) {
                counted += 1.0;
                let wavenumber = Self::exponent(row, at).im;
                let square = self.strain.map_or(1.0, |cell| (cell / wavenumber).powi(2));
                for (way, power) in [a, b].into_iter().enumerate() {
                    let entered = (2.0 * at[0] * row.beyond[way]).exp() * square;
                    let power = power - noise * own[way];
                    numbers.flux[way] += row.weight * velocity * entered * power;
                }
            }
        }
        numbers.frequency /= all;
        numbers.wavenumber /= all;
        numbers.velocity = all / slowness;
        numbers.flux = numbers
            .flux
            .map(|flux| flux * self.rows.len() as f64 / counted);
        numbers
    }
}

fn every(_: usize) -> bool {
    true
}
