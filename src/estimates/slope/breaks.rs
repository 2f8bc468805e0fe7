//! Breaks of a power law: continuous lines of several pieces.

use crate::numeric::GoldenSection;
use crate::numeric::{student_outside, student_two_sided};

/// Places that are tried, evenly spread over the band.
const PLACES: usize = 64;
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
        for (slope, end) in self
            .slopes
            .iter()
            .zip(self.at.iter().map(|b| b.ln()).chain([f64::INFINITY]))
        {
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
    let straight = hinges(points, &[])?;
    let single = |b: &f64| Some((vec![*b], hinges(points, &[*b])?));
    let one = best(places.iter().filter_map(single))?;
    let chance = |worse: &Hinges, better: &Hinges, tried: usize| {
        let freedom = n as f64 - better.coefficients.len() as f64;
        let ratio = (worse.squares - better.squares) / (better.squares / freedom);
        (student_outside(ratio.max(0.0).sqrt(), freedom) * tried as f64).min(1.0)
    };
    let first = chance(&straight, &one.1, places.len());
    let mut accepted = (first < alpha).then(|| (one.clone(), vec![first]));
    if most > 1 {
        let far = |a: f64, b: f64| points.iter().filter(|p| p.0 > a && p.0 <= b).count() >= MARGIN;
        let mut pairs = Vec::new();
        for (i, a) in places.iter().enumerate() {
            pairs.extend(
                places[i + 1..]
                    .iter()
                    .filter(|b| far(*a, **b))
                    .map(|b| [*a, *b]),
            );
        }
        let double = |pair: &[f64; 2]| Some((pair.to_vec(), hinges(points, pair)?));
        if let Some(two) = best(pairs.iter().filter_map(double)) {
            let second = chance(&one.1, &two.1, pairs.len());
            if second < alpha {
                accepted = Some((two, vec![first, second]));
            }
        }
    }
    let ((at, _), probabilities) = accepted?;
    let search = Search {
        points,
        ends: [low, high],
        step,
    };
    let at = search.refined(at);
    let fit = hinges(points, &at)?;
    let freedom = n as f64 - fit.coefficients.len() as f64;
    let limit = fit.squares * (1.0 + student_two_sided(alpha, freedom).powi(2) / freedom);
    let interval = |k: usize| [-1.0, 1.0].map(|sign| search.reach(&at, k, sign, limit).exp());
    let mut slopes = vec![fit.coefficients[1]];
    for change in &fit.coefficients[2..] {
        slopes.push(slopes[slopes.len() - 1] + change);
    }
    let start = [
        points[0].0,
        fit.coefficients[0] + fit.coefficients[1] * (points[0].0 - fit.origin),
    ];
    Some(BreakFit {
        intervals: (0..at.len()).map(interval).collect(),
        at: at.iter().map(|b| b.exp()).collect(),
        slopes,
        probabilities,
        start,
    })
}

/// Places of breaks between those that were tried.
struct Search<'a> {
    points: &'a [(f64, f64)],
    ends: [f64; 2],
    /// Between places.
    step: f64,
}

impl Search<'_> {
    /// Negative residuals with break `k` at `x`.
    fn value(&self, at: &[f64], k: usize, x: f64) -> f64 {
        let mut moved = at.to_vec();
        moved[k] = x;
        let is_ordered = moved.is_sorted() && x >= self.ends[0] && x <= self.ends[1];
        match hinges(self.points, &moved).filter(|_| is_ordered) {
            Some(fit) => -fit.squares,
            None => f64::NEG_INFINITY,
        }
    }

    /// The best places near these.
    fn refined(&self, mut at: Vec<f64>) -> Vec<f64> {
        for _ in 0..2 {
            for k in 0..at.len() {
                let value = |x: f64| Ok::<f64, std::convert::Infallible>(self.value(&at, k, x));
                let Ok(mut search) =
                    GoldenSection::new([at[k] - self.step, at[k] + self.step], value);
                while search.width() > 1e-6 * self.step {
                    let [c, d] = search.inner;
                    let Ok(()) = search.narrow(c.1 > d.1, value);
                }
                let [c, d] = search.inner;
                let found = if c.1 > d.1 { c } else { d };
                if found.1 > self.value(&at, k, at[k]) {
                    at[k] = found.0;
                }
            }
        }
        at
    }

    /// How far break `k` can be moved until the residuals are above `limit`.
    fn reach(&self, at: &[f64], k: usize, sign: f64, limit: f64) -> f64 {
        let mut x = at[k];
        loop {
            let next = x + sign * self.step / 16.0;
            if -self.value(at, k, next) > limit {
                return next.clamp(self.ends[0], self.ends[1]);
            }
            x = next;
        }
    }
}

fn best(fits: impl Iterator<Item = (Vec<f64>, Hinges)>) -> Option<(Vec<f64>, Hinges)> {
    fits.min_by(|a, b| a.1.squares.total_cmp(&b.1.squares))
}

/// `y = c_0 + c_1 (x - origin) + sum c_i max(x - b_i, 0)` by least squares.
#[derive(Debug, Clone)]
struct Hinges {
    coefficients: Vec<f64>,
    origin: f64,
    squares: f64,
}

/// By orthogonal columns (modified Gram-Schmidt). `None` where columns depend on each other.
fn hinges(points: &[(f64, f64)], breaks: &[f64]) -> Option<Hinges> {
    let origin = points[0].0;
    let column = |c: usize| -> Vec<f64> {
        let of = |x: f64| match c {
            0 => 1.0,
            1 => x - origin,
            _ => (x - breaks[c - 2]).max(0.0),
        };
        points.iter().map(|p| of(p.0)).collect()
    };
    let count = 2 + breaks.len();
    let mut columns: Vec<Vec<f64>> = (0..count).map(column).collect();
    let mut triangle = vec![vec![0.0; count]; count];
    let mut rest: Vec<f64> = points.iter().map(|p| p.1).collect();
    let mut projected = vec![0.0; count];
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    for c in 0..count {
        let before = dot(&columns[c], &columns[c]).sqrt();
        for b in 0..c {
            let along = dot(&columns[b], &columns[c]);
            triangle[b][c] = along;
            let (done, open) = columns.split_at_mut(c);
            for (v, q) in open[0].iter_mut().zip(&done[b]) {
                *v -= along * q;
            }
        }
        let norm = dot(&columns[c], &columns[c]).sqrt();
        if norm.is_nan() || norm <= 1e-10 * before {
            return None;
        }
        triangle[c][c] = norm;
        for v in &mut columns[c] {
            *v /= norm;
        }
        projected[c] = dot(&columns[c], &rest);
        for (v, q) in rest.iter_mut().zip(&columns[c]) {
            *v -= projected[c] * q;
        }
    }
    let mut coefficients = projected;
    for c in (0..count).rev() {
        for d in c + 1..count {
            coefficients[c] -= triangle[c][d] * coefficients[d];
        }
        coefficients[c] /= triangle[c][c];
    }
    Some(Hinges {
        coefficients,
        origin,
        squares: dot(&rest, &rest),
    })
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

    #[test]
    fn val_known_breaks_are_found_within_their_intervals() {
        let law = |x: f64| -2.0 * x - 1.5 * (x - 20f64.ln()).max(0.0);
        let found = breaks(&noisy(300, 0.1, law, 1), 2, 0.05).unwrap();
        assert_eq!(found.at.len(), 1, "{found:?}");
        assert!(
            found.intervals[0][0] <= 20.0 && 20.0 <= found.intervals[0][1],
            "{found:?}"
        );
        assert!((found.slopes[0] + 2.0).abs() < 0.2 && (found.slopes[1] + 3.5).abs() < 0.1);
        assert!((found.at_logarithm(5.0) - law(5.0)).abs() < 0.1);
        let law = |x: f64| law(x) + 3.0 * (x - 90f64.ln()).max(0.0);
        let found = breaks(&noisy(300, 0.1, law, 2), 2, 0.05).unwrap();
        assert_eq!(found.at.len(), 2, "{found:?}");
        assert!((found.slopes[2] + 0.5).abs() < 0.2, "{found:?}");
        for (interval, at) in found.intervals.iter().zip([20.0, 90.0]) {
            assert!(interval[0] <= at && at <= interval[1], "{found:?}");
        }
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
