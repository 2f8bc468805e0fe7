//! Breaks of a power law: continuous lines of several pieces.

use crate::numeric::{student_outside, student_two_sided};

/// Places that are tried, evenly spread over the band.
const PLACES: usize = 64;
/// Finer steps between two of them, for the best place and its interval.
const FINER: usize = 16;
/// Points beside a break, at least.
const MARGIN: usize = 3;

/// A continuous line of several pieces through points of `ln x` and `ln S`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct BreakFit {
    /// x at the breaks.
    pub at: Vec<f64>,
    /// For each break the x between which the residuals grow by less than the interval's F, all else held.
    pub intervals: Vec<[f64; 2]>,
    /// Slopes of the pieces.
    pub slopes: Vec<f64>,
    /// Probability of the improvement by each break without one, times the number of places that were tried.
    pub probabilities: Vec<f64>,
    /// Ordinate `ln S` at the first point, for drawing.
    pub start: [f64; 2],
}

impl BreakFit {
    /// `ln S` of the line at `ln x`.
    pub fn at_logarithm(&self, x: f64) -> f64 {
        let [mut from, mut y] = self.start;
        let ends = self.at.iter().map(|b| b.ln()).chain([f64::INFINITY]);
        for (slope, end) in self.slopes.iter().zip(ends) {
            if x <= end {
                return y + slope * (x - from);
            }
            y += slope * (end - from);
            from = end;
        }
        y
    }
}

/// The accepted breaks, at most `most`; `None` if there are none.
///
/// One break is accepted where a line with it is better than a straight one: by an F-test of its change of slope,
/// with the probability multiplied by the number of places that were tried (Bonferroni), below `alpha`. A second
/// one likewise against the first, of all pairs of places.
pub(super) fn breaks(points: &[(f64, f64)], most: usize, alpha: f64) -> Option<BreakFit> {
    let n = points.len();
    if n < 2 * MARGIN + 2 || most == 0 {
        return None;
    }
    let [low, high] = [points[MARGIN].0, points[n - 1 - MARGIN].0];
    let count = PLACES.min(n - 2 * MARGIN);
    let step = (high - low) / (count - 1) as f64;
    let places: Vec<f64> = (0..count).map(|i| low + step * i as f64).collect();
    let straight = Hinges::new(points, &[])?;
    // A piece between two breaks has points of its own.
    let far = |a: f64, b: f64| points.iter().filter(|p| p.0 > a && p.0 <= b).count() >= MARGIN;
    let singles: Vec<Vec<f64>> = places.iter().map(|b| vec![*b]).collect();
    let later = |a: f64| places.iter().filter(move |b| most > 1 && far(a, **b));
    let pairs = places.iter().flat_map(|a| later(*a).map(|b| vec![*a, *b]));
    let pairs: Vec<Vec<f64>> = pairs.collect();
    let chance = |worse: &Hinges, better: &Hinges, tried: usize| {
        let freedom = better.freedom();
        let ratio = (worse.squares - better.squares) / (better.squares / freedom);
        (student_outside(ratio.max(0.0).sqrt(), freedom) * tried as f64).min(1.0)
    };
    let best = |all: &[Vec<f64>]| {
        let fits = all.iter().filter_map(|at| Hinges::new(points, at));
        fits.min_by(|a, b| a.squares.total_cmp(&b.squares))
    };
    let one = best(&singles)?;
    let first = chance(&straight, &one, singles.len());
    let two = best(&pairs).map(|two| (chance(&one, &two, pairs.len()), two));
    let (mut fit, probabilities) = match two {
        Some((second, two)) if second < alpha => (two, vec![first, second]),
        _ if first < alpha => (one, vec![first]),
        _ => return None,
    };
    // One break elsewhere, all else held.
    let moved = |fit: &Hinges, k: usize, x: f64| {
        let mut at = fit.breaks.clone();
        at[k] = x;
        let is_there = at.is_sorted() && x >= low && x <= high;
        is_there.then(|| Hinges::new(points, &at))?
    };
    let fine = step / FINER as f64;
    for k in (0..fit.breaks.len()).chain(0..fit.breaks.len()) {
        let about = fit.breaks[k] - step;
        for i in 0..=2 * FINER {
            let other = moved(&fit, k, about + fine * i as f64);
            let better = other.filter(|other| other.squares < fit.squares);
            fit = better.unwrap_or(fit);
        }
    }
    let freedom = fit.freedom();
    let limit = fit.squares * (1.0 + student_two_sided(alpha, freedom).powi(2) / freedom);
    // As far as the residuals stay below the limit.
    let reach = |k: usize, sign: f64| {
        let mut x = fit.breaks[k];
        while moved(&fit, k, x).is_some_and(|fit| fit.squares <= limit) {
            x += sign * fine;
        }
        x.clamp(low, high).exp()
    };
    let ends = [&[f64::NEG_INFINITY], &fit.breaks[..], &[f64::INFINITY]].concat();
    let slope = |ends: &[f64]| {
        let fitted = points.iter().zip(&fit.fitted);
        let mut inside = fitted.filter(|(p, _)| ends[0] <= p.0 && p.0 <= ends[1]);
        let (from, to) = (inside.next()?, inside.next_back()?);
        Some((to.1 - from.1) / (to.0.0 - from.0.0))
    };
    let interval = |k: usize| [-1.0, 1.0].map(|sign| reach(k, sign));
    Some(BreakFit {
        at: fit.breaks.iter().map(|b| b.exp()).collect(),
        intervals: (0..fit.breaks.len()).map(interval).collect(),
        slopes: ends.windows(2).map(slope).collect::<Option<_>>()?,
        probabilities,
        start: [points[0].0, fit.fitted[0]],
    })
}

/// `y = c_0 + c_1 x + sum c_i max(x - b_i, 0)` by least squares.
struct Hinges {
    breaks: Vec<f64>,
    /// At each point.
    fitted: Vec<f64>,
    /// Sum of the squared residuals.
    squares: f64,
}

impl Hinges {
    /// By orthogonal columns (modified Gram-Schmidt). `None` where columns depend on each other.
    fn new(points: &[(f64, f64)], breaks: &[f64]) -> Option<Hinges> {
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let remove = |from: &mut [f64], unit: &[f64]| {
            let along = dot(from, unit);
            from.iter_mut().zip(unit).for_each(|(v, q)| *v -= along * q);
        };
        let mut rest: Vec<f64> = points.iter().map(|p| p.1).collect();
        let mut units: Vec<Vec<f64>> = Vec::new();
        for c in 0..2 + breaks.len() {
            let of = |x: f64| match c {
                0 => 1.0,
                1 => x - points[0].0,
                _ => (x - breaks[c - 2]).max(0.0),
            };
            let mut column: Vec<f64> = points.iter().map(|p| of(p.0)).collect();
            let before = dot(&column, &column).sqrt();
            units.iter().for_each(|unit| remove(&mut column, unit));
            let norm = dot(&column, &column).sqrt();
            if norm.is_nan() || norm <= 1e-10 * before {
                return None;
            }
            column.iter_mut().for_each(|v| *v /= norm);
            remove(&mut rest, &column);
            units.push(column);
        }
        Some(Hinges {
            breaks: breaks.to_vec(),
            fitted: points.iter().zip(&rest).map(|(p, r)| p.1 - r).collect(),
            squares: dot(&rest, &rest),
        })
    }

    /// Points less coefficients.
    fn freedom(&self) -> f64 {
        self.fitted.len() as f64 - 2.0 - self.breaks.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Random;

    fn noisy(count: usize, noise: f64, law: impl Fn(f64) -> f64, seed: u64) -> Vec<(f64, f64)> {
        let mut random = Random::new(seed);
        let point = |m: usize| {
            let x = (m as f64).ln();
            (x, law(x) + noise * random.normal())
        };
        (1..=count).map(point).collect()
    }

    /// Of straight lines in noise, fewer than one in twenty is given a break.
    #[test]
    fn val_straight_lines_have_no_break() {
        let wrong = (0..200)
            .filter(|seed| breaks(&noisy(60, 0.3, |x| -2.0 * x, 10 + seed), 1, 0.05).is_some())
            .count();
        assert!(wrong <= 10, "{wrong} of 200");
    }
}
