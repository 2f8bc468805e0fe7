//! The spline of degree five through given values.

use super::lattice::all_are;
use crate::{Error, Result};

const DEGREE: usize = 5;

/// Fewest values that determine one polynomial of that degree.
const LEAST: usize = DEGREE + 1;

/// Diagonals of the equations above and below the main one.
const BAND: usize = DEGREE;

/// A piecewise polynomial of degree five with four continuous derivatives, through values at rising times: without
/// knots at the two inner values nearest to each end, as `make_interp_spline(t, y, k=5)` of SciPy.
///
/// Its fifth derivative jumps by about `F^(6) dt`. A step h much longer than dt meets the function that is
/// sampled, to `dt^6`; a shorter one meets few jumps, each of which adds `F^(6) dt h^7`: never more than the
/// error of order eight of a step as long as dt.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    times: Vec<f64>,
    /// Of each piece, the coefficients of powers of the share of it that has passed.
    pieces: Vec<[f64; DEGREE + 2]>,
}

impl Spline {
    /// # Errors
    /// [`crate::Error::Request`] for fewer than six values, times that do not rise, and values that are not finite.
    pub(super) fn through(times: &[f64], values: &[f64]) -> Result<Spline> {
        let n = times.len();
        let expected = format!("{LEAST} or more values, one a time");
        let found = format!("{} values at {n} times", values.len());
        let enough = n >= LEAST && values.len() == n;
        Error::require(enough, "drive_values", expected, found)?;
        if let Some(i) = (1..n).find(|&i| {
            let step = times[i] - times[i - 1];
            !(step > 0.0 && step.is_finite())
        }) {
            let found = format!("{} after {}", times[i], times[i - 1]);
            return Err(Error::request("drive_times", "times that rise", found));
        }
        all_are(("drive_values", "finite values"), values, f64::is_finite)?;
        let last = times[n - 1];
        let inner = &times[LEAST / 2..n - LEAST / 2];
        let knots = [&[times[0]; LEAST][..], inner, &[last; LEAST]].concat();
        // The last span of knots that begins at or before a time.
        let span = |t: f64| knots[..n].partition_point(|knot| *knot <= t) - 1;
        let coefficients = interpolating(times, values, &knots, span);
        let pieces = times.windows(2).map(|ends| {
            let at = span(ends[0]);
            let mut piece = [0.0; DEGREE + 2];
            let basis = basis(&knots, at, ends[0], ends[1] - ends[0]);
            for (spline, c) in basis.iter().zip(&coefficients[at - DEGREE..]) {
                let powers = piece.iter_mut().zip(spline);
                powers.for_each(|(sum, power)| *sum += c * power);
            }
            piece
        });
        Ok(Spline {
            pieces: pieces.collect(),
            times: times.to_vec(),
        })
    }

    /// First and last time.
    pub(super) fn span(&self) -> [f64; 2] {
        [self.times[0], self.times[self.times.len() - 1]]
    }

    /// The derivative of this order, 0 to 2, at time t; beyond its ends the end pieces go on.
    pub(super) fn derivative(&self, order: usize, t: f64) -> f64 {
        let after = self.times.partition_point(|time| *time <= t);
        let piece = after.saturating_sub(1).min(self.pieces.len() - 1);
        let h = self.times[piece + 1] - self.times[piece];
        let share = (t - self.times[piece]) / h;
        let powers = self.pieces[piece].iter().enumerate().skip(order).rev();
        let sum = powers.fold(0.0, |sum, (power, c)| {
            let factor = match order {
                0 => 1.0,
                1 => power as f64,
                _ => (power * (power - 1)) as f64,
            };
            sum * share + factor * c
        });
        sum / h.powi(order as i32)
    }

    /// The integral from 0 on.
    pub(super) fn integral(&self) -> Spline {
        let mut integral = self.clone();
        let mut so_far = 0.0;
        for (piece, ends) in integral.pieces.iter_mut().zip(self.times.windows(2)) {
            let h = ends[1] - ends[0];
            for power in (1..piece.len()).rev() {
                piece[power] = piece[power - 1] * h / power as f64;
            }
            piece[0] = so_far;
            so_far = piece.iter().sum();
        }
        let start = match self.times[0] < 0.0 {
            true => integral.derivative(0, 0.0),
            false => 0.0,
        };
        integral
            .pieces
            .iter_mut()
            .for_each(|piece| piece[0] -= start);
        integral
    }

    /// Largest magnitudes at the times and between them: of the value less `from`, of its rate, and of the rate
    /// of that.
    pub(super) fn largest(&self, from: f64) -> [f64; 3] {
        let mut largest = [0.0f64; 3];
        for ends in self.times.windows(2) {
            for t in [ends[0], 0.5 * (ends[0] + ends[1]), ends[1]] {
                for (order, most) in largest.iter_mut().enumerate() {
                    let from = if order == 0 { from } else { 0.0 };
                    *most = most.max((self.derivative(order, t) - from).abs());
                }
            }
        }
        largest
    }
}

/// Coefficients of the B-splines whose sum takes the values, by elimination in a band. The matrix is totally
/// positive: no rows are exchanged.
fn interpolating(
    times: &[f64],
    values: &[f64],
    knots: &[f64],
    span: impl Fn(f64) -> usize,
) -> Vec<f64> {
    let n = times.len();
    // Row i holds the columns from i - BAND on.
    let mut rows = vec![[0.0; 2 * BAND + 1]; n];
    for (i, row) in rows.iter_mut().enumerate() {
        let at = span(times[i]);
        for (offset, [value, ..]) in basis(knots, at, times[i], 1.0).into_iter().enumerate() {
            if let Some(place) = (at + offset + BAND).checked_sub(DEGREE + i)
                && let Some(place) = row.get_mut(place)
            {
                *place = value;
            }
        }
    }
    let mut solution = values.to_vec();
    for i in 0..n {
        for below in i + 1..(i + BAND + 1).min(n) {
            let at = i + BAND - below;
            let factor = rows[below][at] / rows[i][BAND];
            if factor == 0.0 {
                continue;
            }
            for column in 0..=BAND {
                rows[below][at + column] -= factor * rows[i][BAND + column];
            }
            solution[below] -= factor * solution[i];
        }
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..(i + BAND + 1).min(n))
            .map(|j| rows[i][BAND + j - i] * solution[j])
            .sum();
        solution[i] = (solution[i] - known) / rows[i][BAND];
    }
    solution
}

/// Coefficients of the powers of `(t - from) / h`.
type Powers = [f64; DEGREE + 1];

/// The B-splines that are not 0 in a span of the knots, by the recurrence of Cox and de Boor.
fn basis(knots: &[f64], span: usize, from: f64, h: f64) -> [Powers; DEGREE + 1] {
    // A polynomial times `at + rate (t - from) / h`, over a length.
    let times = |p: &Powers, [at, rate]: [f64; 2], length: f64| -> Powers {
        let below = |k: usize| k.checked_sub(1).map_or(0.0, |k| p[k]);
        std::array::from_fn(|k| (at * p[k] + rate * below(k)) / length)
    };
    let mut splines = [[0.0; DEGREE + 1]; DEGREE + 1];
    splines[0][0] = 1.0;
    for degree in 1..=DEGREE {
        let mut saved = [0.0; DEGREE + 1];
        for r in 0..degree {
            let (low, high) = (knots[span + 1 + r - degree], knots[span + r + 1]);
            let falling = times(&splines[r], [high - from, -h], high - low);
            let rising = times(&splines[r], [from - low, h], high - low);
            splines[r] = std::array::from_fn(|k| saved[k] + falling[k]);
            saved = rising;
        }
        splines[degree] = saved;
    }
    splines
}
