//! Searches in the unit cube for the least value of a function that is expensive, noisy or has kinks.
//!
//! Points come in groups, which are evaluated together, so that a result does not depend on threads.

use ndarray::Array2;

use crate::Result;
use crate::numeric::{Random, golden_section};

/// Evaluates points; infinite for those that are none.
pub(super) type Evaluate<'a> = &'a mut dyn FnMut(&[Vec<f64>]) -> Result<Vec<f64>>;

/// Width of the bracket of a single key at which it is located.
const CONVERGED: f64 = 1e-7;
/// Part of the runs on the grid of a single key, the rest narrows its best cell.
const ON_GRID: f64 = 0.6;

/// A point drawn evenly.
fn anew(random: &mut Random, dimensions: usize) -> Vec<f64> {
    (0..dimensions).map(|_| random.uniform()).collect()
}

/// Independent uniform points.
pub(super) fn random(dimensions: usize, runs: usize, seed: u64, evaluate: Evaluate) -> Result<()> {
    let mut random = Random::new(seed ^ 0x5eed);
    let points: Vec<Vec<f64>> = (0..runs).map(|_| anew(&mut random, dimensions)).collect();
    for points in points.chunks(64) {
        evaluate(points)?;
    }
    Ok(())
}

/// An even grid over one key, then golden sections in its best cell.
pub(super) fn bracket(runs: usize, evaluate: Evaluate) -> Result<()> {
    let count = ((ON_GRID * runs as f64) as usize).max(3);
    let grid: Vec<Vec<f64>> = (0..count)
        .map(|i| vec![i as f64 / (count - 1) as f64])
        .collect();
    let values = evaluate(&grid)?;
    let best = least(&values);
    let ends = [best.saturating_sub(1), (best + 1).min(count - 1)].map(|i| grid[i][0]);
    let left = runs.saturating_sub(count);
    if left < 2 {
        return Ok(());
    }
    golden_section(ends, CONVERGED, left, |x| Ok(-evaluate(&[vec![x]])?[0])).map(drop)
}

/// Index of the least.
fn least(values: &[f64]) -> usize {
    let all = values.iter().enumerate();
    all.min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(i, _)| i)
}

/// Descents by differences (BFGS within the cube) from the scene and from the best of random points, one after the
/// other until the runs are used up. A step is the best of several lengths, which are run together.
///
/// Source: J. Nocedal, S. J. Wright, Numerical Optimization (2006), 6.1; that it works on kinks: A. S. Lewis, M. L.
/// Overton, Math. Program. 141, 135 (2013).
pub(super) fn descend(start: &[f64], runs: usize, seed: u64, evaluate: Evaluate) -> Result<()> {
    let mut random = Random::new(seed);
    let n = start.len();
    let mut left = runs;
    let mut begin = start.to_vec();
    loop {
        let drawn = (0..(CANDIDATES * n).max(left / FIFTH)).map(|_| anew(&mut random, n));
        let points: Vec<Vec<f64>> = drawn.chain([begin]).take(left).collect();
        left -= points.len();
        let values = evaluate(&points)?;
        let best = least(&values);
        let mut descent = Descent::new(points[best].clone(), values[best]);
        while left > 2 * n && descent.idle < IDLE {
            left -= descent.step(left, &mut *evaluate)?;
        }
        if left <= 2 * n {
            return evaluate(&vec![descent.x; left]).map(|_| ());
        }
        begin = anew(&mut random, n);
    }
}

/// Random points for each key, or part of the runs that are left if that is more, of which a descent starts from the best.
const CANDIDATES: usize = 4;
const FIFTH: usize = 5;
/// Difference by which gradients are found, as a share of the cube.
const DIFFERENCE: f64 = 1e-5;
/// The same of differences of both sides.
const WIDE: f64 = 1e-4;
/// Steps that are tried at once, each half of the one before.
const LENGTHS: usize = 10;
/// Steps in a row that gain little, after which a descent has ended.
const IDLE: usize = 3;
/// Relative gain of a step below which it is little.
const GAIN: f64 = 1e-5;

/// A point that moves downwards.
struct Descent {
    x: Vec<f64>,
    value: f64,
    /// Approximate inverse of the second derivatives.
    inverse: Array2<f64>,
    /// The gradient before the last step, and that step.
    gradient: Option<Vec<f64>>,
    learn: Option<Vec<f64>>,
    /// Whether the scale of second derivatives is unknown.
    is_first: bool,
    idle: usize,
}

impl Descent {
    fn new(x: Vec<f64>, value: f64) -> Descent {
        Descent {
            inverse: Array2::eye(x.len()),
            x,
            value,
            gradient: None,
            learn: None,
            is_first: true,
            idle: 0,
        }
    }

    /// One step; returns its runs.
    fn step(&mut self, left: usize, evaluate: Evaluate) -> Result<usize> {
        let n = self.x.len();
        let runs = if self.idle > 0 { 2 * n } else { n };
        let gradient = self.gradient_at(&mut *evaluate)?;
        let downhill = |i: usize| -dot(self.inverse.row(i).iter(), &gradient);
        let mut direction: Vec<f64> = (0..n).map(downhill).collect();
        let slope = dot(&direction, &gradient);
        let is_new = self.gradient.is_none();
        if slope.is_nan() || slope >= 0.0 || is_new {
            self.inverse = Array2::eye(n);
            self.is_first = true;
            let length = dot(&gradient, &gradient).sqrt().max(f64::MIN_POSITIVE);
            direction = gradient.iter().map(|g| -0.5 * g / length).collect();
        }
        let moved = |length: f64| -> Vec<f64> {
            let to = self.x.iter().zip(&direction);
            to.map(|(x, d)| (x + length * d).clamp(0.0, 1.0)).collect()
        };
        let count = LENGTHS.min(left - runs);
        let points: Vec<Vec<f64>> = (0..count)
            .map(|i| moved(2.0 * 0.5f64.powi(i as i32)))
            .collect();
        let values = evaluate(&points)?;
        let best = least(&values);
        if values[best] < self.value {
            let gain = (self.value - values[best]) / self.value.abs().max(f64::MIN_POSITIVE);
            self.idle = if gain < GAIN { self.idle + 1 } else { 0 };
            self.value = values[best];
            self.learn = Some(minus(&points[best], &self.x));
            self.x = points[best].clone();
            self.gradient = Some(gradient);
        } else {
            self.idle += 1;
            self.gradient = None;
            self.learn = None;
        }
        Ok(runs + count)
    }

    /// By differences inwards, of both sides after a step that gained little, and what it tells of the second
    /// derivatives.
    fn gradient_at(&mut self, evaluate: Evaluate) -> Result<Vec<f64>> {
        let n = self.x.len();
        let off = |i: usize, by: f64| {
            let mut x = self.x.clone();
            x[i] = (x[i] + by).clamp(0.0, 1.0);
            x
        };
        let inwards = |i: usize| match self.x[i] > 0.5 {
            true => off(i, -DIFFERENCE),
            false => off(i, DIFFERENCE),
        };
        let (low, high) = (|i: usize| off(i, -WIDE), |i: usize| off(i, WIDE));
        let points: Vec<Vec<f64>> = match self.idle > 0 {
            true => (0..n).map(low).chain((0..n).map(high)).collect(),
            false => (0..n).map(inwards).collect(),
        };
        let values = evaluate(&points)?;
        let slope = |i: usize| match self.idle > 0 {
            true => (values[n + i] - values[i]) / (points[n + i][i] - points[i][i]),
            false => (values[i] - self.value) / (points[i][i] - self.x[i]),
        };
        let mut gradient: Vec<f64> = (0..n).map(slope).collect();
        // Bounds that the descent presses against.
        for (g, x) in gradient.iter_mut().zip(&self.x) {
            let is_held = (*x <= 0.0 && *g > 0.0) || (*x >= 1.0 && *g < 0.0);
            if is_held || !g.is_finite() {
                *g = 0.0;
            }
        }
        if let (Some(step), Some(before)) = (self.learn.take(), &self.gradient) {
            let change = minus(&gradient, before);
            update(&mut self.inverse, &step, &change, self.is_first);
            self.is_first = false;
        }
        Ok(gradient)
    }
}

fn dot<'a>(a: impl IntoIterator<Item = &'a f64>, b: &[f64]) -> f64 {
    a.into_iter().zip(b).map(|(a, b)| a * b).sum()
}

fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// The BFGS update, where curvature along the step is positive; the first one finds the scale.
fn update(inverse: &mut Array2<f64>, step: &[f64], change: &[f64], is_first: bool) {
    let n = step.len();
    let along = dot(step, change);
    if along.is_nan() || along <= 0.0 {
        return;
    }
    if is_first {
        *inverse = Array2::eye(n) * (along / dot(change, change));
    }
    let rows = inverse.rows().into_iter();
    let times: Vec<f64> = rows.map(|row| dot(row.iter(), change)).collect();
    let square = dot(&times, change);
    for i in 0..n {
        for j in 0..n {
            inverse[[i, j]] += (1.0 + square / along) * step[i] * step[j] / along
                - (times[i] * step[j] + step[i] * times[j]) / along;
        }
    }
}

/// Evolution, for keys that take the values of a list: children of two of the best points, some of whose coordinates are
/// drawn anew or move to a neighbour.
pub(super) fn evolve(
    start: &[f64],
    listed: &[usize],
    runs: usize,
    seed: u64,
    evaluate: Evaluate,
) -> Result<()> {
    let n = start.len();
    let mut random = Random::new(seed);
    let drawn = (1..CHILDREN).map(|_| anew(&mut random, n));
    let first: Vec<Vec<f64>> = drawn.chain([start.to_vec()]).collect();
    let mut points: Vec<Vec<f64>> = first.into_iter().take(runs).collect();
    let mut left = runs;
    let mut parents: Vec<(f64, Vec<f64>)> = Vec::new();
    while !points.is_empty() {
        left -= points.len();
        parents.extend(evaluate(&points)?.into_iter().zip(points));
        parents.sort_by(|a, b| a.0.total_cmp(&b.0));
        parents.dedup_by(|a, b| a.1 == b.1);
        parents.truncate(PARENTS);
        let mut child = || {
            let mut pick =
                || &parents[(random.uniform() * parents.len() as f64) as usize % parents.len()].1;
            let [one, other] = [pick(), pick()];
            let mut child: Vec<f64> = Vec::with_capacity(n);
            for (i, pair) in one.iter().zip(other).enumerate() {
                let is_first = random.uniform() < 0.5;
                let inherited = if is_first { *pair.0 } else { *pair.1 };
                let step = match listed[i] {
                    0 => NEAR,
                    count => 1.0 / count as f64,
                };
                child.push(match random.uniform() * n as f64 {
                    draw if draw < 0.5 * CHANGED => random.uniform(),
                    draw if draw < CHANGED => (inherited + step * random.normal()).clamp(0.0, 1.0),
                    _ => inherited,
                });
            }
            child
        };
        points = (0..CHILDREN.min(left)).map(|_| child()).collect();
    }
    Ok(())
}

/// Points of a generation, those that the next descends from, coordinates that change in a child on average, and the
/// usual step of one that varies continuously.
const CHILDREN: usize = 24;
const PARENTS: usize = 6;
const CHANGED: f64 = 2.0;
const NEAR: f64 = 0.05;

#[cfg(test)]
mod tests {
    use super::*;

    /// The least value that a search finds, and where.
    fn found(
        search: impl Fn(Evaluate) -> Result<()>,
        of: impl Fn(&[f64]) -> f64,
    ) -> (f64, Vec<f64>, usize) {
        let mut best = (f64::INFINITY, Vec::new(), 0);
        let mut evaluate = |points: &[Vec<f64>]| {
            let values: Vec<f64> = points.iter().map(|x| of(x)).collect();
            best.2 += values.len();
            for (value, x) in values.iter().zip(points) {
                assert!(x.iter().all(|x| (0.0..=1.0).contains(x)), "{x:?}");
                if *value < best.0 {
                    best = (*value, x.clone(), best.2);
                }
            }
            Ok(values)
        };
        search(&mut evaluate).unwrap();
        best
    }

    /// Rosenbrock's valley, a kink, the edge of the cube, values of a list.
    #[test]
    fn val_closed_form_minima_are_found() {
        let valley = |x: &[f64]| {
            let y: Vec<f64> = x.iter().map(|x| 4.0 * x - 2.0).collect();
            let terms = y.windows(2);
            let terms = terms.map(|y| 100.0 * (y[1] - y[0] * y[0]).powi(2) + (1.0 - y[0]).powi(2));
            terms.sum()
        };
        let (value, x, runs) = found(|e| descend(&[0.1; 4], 3000, 1, e), valley);
        assert!(value < 1e-4, "{value:e} at {x:?} in {runs}");
        let kink = |x: &[f64]| x.iter().map(|x| (x - 0.3).abs()).fold(0.0, f64::max);
        let (value, ..) = found(|e| descend(&[0.9; 6], 3000, 2, e), kink);
        assert!(value < 1e-2, "{value:e}");
        let edge = |x: &[f64]| x.iter().sum::<f64>();
        let (value, ..) = found(|e| descend(&[0.5; 5], 300, 3, e), edge);
        assert_eq!(value, 0.0);
        let step = |x: &f64| ((x * 7.0).floor().min(6.0) - 5.0).powi(2);
        let steps = |x: &[f64]| x.iter().map(step).sum();
        let (value, ..) = found(|e| evolve(&[0.1; 8], &[7; 8], 1000, 4, e), steps);
        assert_eq!(value, 0.0);
        let (value, x, runs) = found(|e| bracket(60, e), |x| (x[0] - 0.377).powi(2));
        assert!(value < 1e-12 && runs <= 60, "{value:e} at {x:?} in {runs}");
    }
}
