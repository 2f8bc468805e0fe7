//! Waves both ways in a band of frequencies: their amplitudes, their loss, their wavenumber and its slope.

use std::f64::consts::TAU;

use num_complex::Complex;

use crate::numeric::{eliminated, jackknife, median};

/// Groups of sites, and of rows, that are left out in turn.
pub(super) const GROUPS: usize = 20;
const ZERO: Complex<f64> = Complex::new(0.0, 0.0);
const ITERATIONS: usize = 40;
/// Standard errors by which, and phases over all sites in rad by which wavenumbers of loud shots differ from those of others.
const SURE: f64 = 5.0;
const CHANGE: f64 = 0.2;
/// Share of its row below which a pivot is none.
const SINGULAR: f64 = 1e-12;
/// Loss, wavenumber, and its first and second derivative.
const UNKNOWNS: usize = 4;
type Unknowns = [f64; UNKNOWNS];

/// One frequency of one shot.
pub(super) struct Row<'a> {
    /// Of each site.
    pub spectrum: &'a [Complex<f64>],
    pub frequency: f64,
    /// Wavenumber per site of a stated relation, of the wave whose energy goes to later sites; 0 where it is searched.
    pub wavenumber: f64,
    /// Group velocity where it is not read off the wavenumbers, in sites and cycles.
    pub velocity: Option<f64>,
    /// Of the squares of amplitudes, to a share of the flux over the group velocity.
    pub weight: f64,
}

/// Rows of one band, of which each is `A q^j + B q^(n-1-j)`, `q = exp(-(loss + i wavenumber))`, and noise.
pub(super) struct Band<'a> {
    /// By rising frequency, those of all shots at each.
    pub rows: Vec<Row<'a>>,
    pub shots: usize,
    /// Wavenumbers per site in the middle, and group velocities, that the search starts from; none where wavenumbers are stated.
    pub starts: Vec<[f64; 2]>,
    /// Whether samples are strain rates, and velocities follow from wavenumbers.
    pub is_strain: bool,
    /// Whether there are waves towards earlier sites, B, too.
    pub is_both: bool,
    /// The middle of the band and half of its width.
    pub middle: f64,
    pub half: f64,
}

/// What a band says, per site: the loss of amplitude; frequency, wavenumber and group velocity, means by power; and the flux of
/// both waves at the sites where they enter.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Numbers {
    pub loss: f64,
    pub frequency: f64,
    pub wavenumber: f64,
    pub velocity: f64,
    pub flux: [f64; 2],
}

/// The same with what is without each group of sites, of rows, and without each shot, where there are several.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub numbers: Numbers,
    pub without: [Vec<Numbers>; 3],
    /// Sum of the squares of the rows' fluxes.
    pub squares: [f64; 2],
    /// Power of the waves over that of as many unknowns of noise.
    pub over_noise: f64,
    /// `1 - |<A|B>|^2` of the two waves' shapes.
    pub apart: f64,
    /// Whether loud shots have other wavenumbers than quiet ones.
    pub follows_amplitude: bool,
}

impl Found {
    /// Standard errors of a quantity by what is left out: sites, rows, shots.
    pub fn errors(&self, of: impl Fn(&Numbers) -> f64) -> [f64; 3] {
        let values = |without: &Vec<Numbers>| without.iter().map(&of).collect::<Vec<f64>>();
        self.without
            .each_ref()
            .map(|without| error_without(&values(without)))
    }
}

/// All rows.
fn every(_: usize) -> bool {
    true
}

/// Standard error by values without each group; 0 where none is left out.
pub(super) fn error_without(values: &[f64]) -> f64 {
    if values.len() > 1 {
        jackknife(values)
    } else {
        0.0
    }
}

/// Sums over rows at some unknowns.
#[derive(Default)]
struct Sums {
    normal: [Unknowns; UNKNOWNS],
    gradient: Unknowns,
    residual: f64,
    /// Squares of all samples, and complex numbers that the waves do not explain.
    squares: f64,
    left: f64,
    apart: f64,
    /// Squares of amplitudes of each row, and what they have of the noise for one unit of its power.
    waves: Vec<[f64; 4]>,
}

impl Band<'_> {
    /// Least squares by the method of Levenberg and Marquardt, then one step without each group.
    pub fn found(&self) -> Found {
        let starts = self.starts.iter();
        let starts = starts.map(|[k, velocity]| [0.0, *k, TAU * self.half / velocity, 0.0]);
        let stated = self.starts.is_empty().then_some([0.0; UNKNOWNS]);
        let tried = starts.chain(stated).map(|start| self.least_squares(start));
        let best = tried.min_by(|a, b| a.1.residual.total_cmp(&b.1.residual));
        let (at, sums) = best.unwrap_or_default();
        let count = self.rows.len();
        let without = |sites: Option<usize>, rows: Option<usize>| {
            let has = |i: usize| rows != Some(i * GROUPS.min(count) / count);
            let own = self.sums(&at, sites, has);
            let at = self.step(&at, &own, 0.0).unwrap_or(at);
            self.numbers(&at, &self.sums(&at, sites, every))
        };
        let sites = self.rows[0].spectrum.len();
        let squares = |wave: usize| {
            let flux =
                |(row, i): (&Row, usize)| -> f64 { self.flux(row, &at, &sums, i)[wave].powi(2) };
            self.rows.iter().zip(0..).map(flux).sum::<f64>()
        };
        let numbers = self.numbers(&at, &sums);
        // The flux of the other shots, of as many as there are.
        let without_shot = |shot: usize| {
            let mut flux = [0.0; 2];
            let rows = self.rows.iter().enumerate();
            for (i, row) in rows.filter(|(i, _)| i % self.shots != shot) {
                let own = self.flux(row, &at, &sums, i);
                flux.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
            }
            let factor = self.shots as f64 / (self.shots as f64 - 1.0);
            Numbers {
                flux: flux.map(|sum| factor * sum),
                ..numbers
            }
        };
        let unknowns = if self.is_both { 2.0 } else { 1.0 } * self.rows.len() as f64;
        let noise = sums.residual / sums.left;
        Found {
            numbers,
            without: [
                (0..GROUPS.min(sites))
                    .map(|g| without(Some(g), None))
                    .collect(),
                (0..GROUPS.min(self.rows.len()))
                    .map(|g| without(None, Some(g)))
                    .collect(),
                (0..self.shots)
                    .filter(|_| self.shots > 1)
                    .map(without_shot)
                    .collect(),
            ],
            squares: [squares(0), squares(1)],
            over_noise: (sums.squares - sums.residual) / unknowns / noise,
            apart: sums.apart / self.rows.len() as f64,
            follows_amplitude: self.follows_amplitude(&at),
        }
    }

    /// Whether the wavenumber of the louder half of the shots differs from that of the others.
    fn follows_amplitude(&self, at: &Unknowns) -> bool {
        let power = |shot: usize| -> f64 {
            let rows = self.rows.iter().skip(shot).step_by(self.shots);
            rows.flat_map(|row| row.spectrum)
                .map(|x| x.norm_sqr())
                .sum()
        };
        let powers: Vec<f64> = (0..self.shots).map(power).collect();
        let middle = median(powers.iter().copied()).unwrap_or(0.0);
        let is_loud = |i: usize| powers[i % self.shots] > middle;
        let n = self.rows[0].spectrum.len();
        let difference = |sites: Option<usize>| {
            let of = |is_of_loud: bool| {
                let own = self.sums(at, sites, |i| is_loud(i) == is_of_loud);
                self.step(at, &own, 0.0).map_or(f64::NAN, |next| next[1])
            };
            of(true) - of(false)
        };
        let is_told = || {
            let without: Vec<f64> = (0..GROUPS.min(n)).map(|g| difference(Some(g))).collect();
            let (change, error) = (difference(None).abs(), error_without(&without));
            change > SURE * error && change * n as f64 > CHANGE
        };
        self.shots > 1 && !self.starts.is_empty() && is_told()
    }

    fn least_squares(&self, mut at: Unknowns) -> (Unknowns, Sums) {
        let mut sums = self.sums(&at, None, every);
        let mut damping = 1e-3;
        for _ in 0..ITERATIONS {
            let Some(tried) = self.step(&at, &sums, damping) else {
                break;
            };
            let next = self.sums(&tried, None, every);
            if next.residual <= sums.residual {
                let is_done = sums.residual - next.residual <= 1e-14 * sums.squares;
                (at, sums) = (tried, next);
                damping = (damping / 10.0f64).max(1e-12);
                if is_done {
                    break;
                }
            } else if damping > 1e8 {
                break;
            } else {
                damping *= 10.0;
            }
        }
        (at, sums)
    }

    fn offset(&self, row: &Row) -> f64 {
        (row.frequency - self.middle) / self.half
    }

    /// `loss + i wavenumber` of a row.
    fn exponent(&self, row: &Row, at: &Unknowns) -> Complex<f64> {
        let u = self.offset(row);
        Complex::new(at[0], row.wavenumber + at[1] + u * (at[2] + u * at[3]))
    }

    /// Sums of some rows, without a group of sites.
    fn sums(&self, at: &Unknowns, sites: Option<usize>, has: impl Fn(usize) -> bool) -> Sums {
        let n = self.rows[0].spectrum.len();
        let groups = GROUPS.min(n);
        let kept: Vec<usize> = (0..n).filter(|j| sites != Some(j % groups)).collect();
        let mut sums = Sums::default();
        let mut shape = vec![ZERO; n];
        for (i, row) in self.rows.iter().enumerate() {
            if !has(i) {
                continue;
            }
            let ratio = (-self.exponent(row, at)).exp();
            let mut power = Complex::new(1.0, 0.0);
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
        let mut gram = [0.0; 2];
        let (mut cross, mut right) = (ZERO, [ZERO; 2]);
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
        let along = along[0].conj() * explained[0] + along[1].conj() * explained[1];
        let size = size - along.re;
        let u = self.offset(row);
        let powers = [1.0, u, u * u];
        sums.normal[0][0] += size;
        sums.gradient[0] += slope.re;
        for (i, p) in powers.iter().enumerate() {
            // That by the wavenumber is i times that by the loss.
            sums.gradient[i + 1] += slope.im * p;
            for (j, q) in powers.iter().enumerate() {
                sums.normal[i + 1][j + 1] += size * p * q;
            }
        }
        sums.left += kept.len() as f64 - if self.is_both { 2.0 } else { 1.0 };
        sums.apart += apart / (gram[0] * gram[1]);
        let [a, b] = waves.map(|wave| wave.norm_sqr());
        sums.waves.push([a, b, own[0], own[1]]);
    }

    /// The next unknowns.
    fn step(&self, at: &Unknowns, sums: &Sums, damping: f64) -> Option<Unknowns> {
        let frequencies = self
            .rows
            .chunk_by(|a, b| a.frequency == b.frequency)
            .count();
        let searched = match self.starts.is_empty() {
            true => 0,
            false => frequencies.min(UNKNOWNS - 1),
        };
        let count = 1 + searched;
        let row = |i: usize| {
            let mut row = sums.normal[i][..count].to_vec();
            row[i] *= 1.0 + damping;
            row.push(sums.gradient[i]);
            row
        };
        let solved = eliminated((0..count).map(row).collect(), SINGULAR)?;
        let mut next = *at;
        next.iter_mut()
            .zip(&solved)
            .for_each(|(value, step)| *value += step[0]);
        Some(next)
    }

    fn velocity(&self, row: &Row, at: &Unknowns) -> f64 {
        let slope = (at[2] + 2.0 * self.offset(row) * at[3]) / self.half;
        row.velocity.unwrap_or(TAU / slope)
    }

    /// Flux of both waves of row `i`, without that of the noise.
    fn flux(&self, row: &Row, at: &Unknowns, sums: &Sums, i: usize) -> [f64; 2] {
        let noise = sums.residual / sums.left;
        let [a, b, own_a, own_b] = sums.waves[i];
        let of_velocity = match self.is_strain {
            true => self.exponent(row, at).norm_sqr().recip(),
            false => 1.0,
        };
        let factor = row.weight * of_velocity * self.velocity(row, at);
        [factor * (a - noise * own_a), factor * (b - noise * own_b)]
    }

    fn numbers(&self, at: &Unknowns, sums: &Sums) -> Numbers {
        let mut numbers = Numbers {
            loss: at[0],
            ..Numbers::default()
        };
        let (mut all, mut slowness) = (0.0, 0.0);
        for (i, row) in self.rows.iter().enumerate() {
            let flux = self.flux(row, at, sums, i);
            let power = sums.waves[i][0] + sums.waves[i][1];
            all += power;
            slowness += power / self.velocity(row, at);
            numbers.frequency += power * row.frequency;
            numbers.wavenumber += power * self.exponent(row, at).im;
            for (sum, flux) in numbers.flux.iter_mut().zip(flux) {
                *sum += flux;
            }
        }
        numbers.frequency /= all;
        numbers.wavenumber /= all;
        numbers.velocity = all / slowness;
        numbers
    }
}
