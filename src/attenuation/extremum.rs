//! Locating extrema of a curve that is expensive to evaluate (one simulation per value).

use crate::Result;
use crate::numeric::golden_section;

/// Final width of the bracket of an extremum, relative to its initial width.
const LEFT: f64 = 1e-5;

/// A difference is significant if it exceeds this many errors plus this fraction of the value.
const DOUBT: f64 = 4.0;
const ROUNDING: f64 = 1e-10;

/// Nodes that a value is interpolated from, to see whether a curve is resolved there.
const NODES: usize = 4;

/// An interval is resolved where interpolation misses its ends by less than this part of the step between them.
const SMOOTH: f64 = 0.2;

/// Rounds in which intervals that may hide extrema are halved.
const ROUNDS: usize = 5;

/// Three neighbouring abscissas; the curve is highest or lowest at the middle one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extremum {
    pub(super) is_maximum: bool,
    pub(super) around: [f64; 3],
}

/// A point of a curve with the error of its value; `None` where the curve has no value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CurvePoint {
    pub(super) at: f64,
    pub(super) value: Option<f64>,
    pub(super) error: f64,
}

impl CurvePoint {
    /// What two values differ by without being different; infinite where there is none.
    fn doubt(&self, other: &CurvePoint) -> f64 {
        let [Some(own), Some(_)] = [self.value, other.value] else {
            return f64::INFINITY;
        };
        DOUBT * (self.error + other.error) + ROUNDING * own.abs()
    }

    /// By how much it is above another, if it is beyond doubt; 0 where it is not, or below.
    fn above(&self, other: &CurvePoint) -> f64 {
        let both = self.value.zip(other.value);
        let by = both.map_or(0.0, |(own, other)| own - other);
        if by > self.doubt(other) { by } else { 0.0 }
    }
}

/// The extrema of a curve given by its points in order. An extremum differs from both neighbours by
/// more than the errors, and all three points have values.
pub(super) fn extrema(places: &[CurvePoint]) -> Vec<Extremum> {
    let turns = places.windows(3).filter_map(|places| {
        let [a, b, c] = [&places[0], &places[1], &places[2]];
        let is_maximum = b.above(a) > 0.0 && b.above(c) > 0.0;
        let is_minimum = a.above(b) > 0.0 && c.above(b) > 0.0;
        (is_maximum || is_minimum).then_some(Extremum {
            is_maximum,
            around: [a.at, b.at, c.at],
        })
    });
    turns.collect()
}

/// Adds points, which `curve` gives for abscissas, in the middle of intervals that may hide extrema. The points in
/// order, and the intervals that still may.
///
/// # Errors
/// Those of `curve`.
pub(super) fn resolved(
    mut places: Vec<CurvePoint>,
    curve: &dyn Fn(&[f64]) -> Result<Vec<CurvePoint>>,
) -> Result<(Vec<CurvePoint>, Vec<[f64; 2]>)> {
    for _ in 0..ROUNDS {
        let open = unresolved(&places).into_iter();
        let middles: Vec<f64> = open.map(|[a, b]| 0.5 * (a + b)).collect();
        if middles.is_empty() {
            break;
        }
        places.extend(curve(&middles)?);
        places.sort_by(|a, b| a.at.total_cmp(&b.at));
    }
    let hidden = unresolved(&places);
    Ok((places, hidden))
}

/// The intervals between points, in order, in which a curve may have extrema that its points do not show: where a
/// polynomial through the points around misses one of the ends by as much as the curve rises or falls.
fn unresolved(places: &[CurvePoint]) -> Vec<[f64; 2]> {
    let n = places.len();
    let nodes = NODES.min(n.saturating_sub(1));
    if nodes < 2 {
        return Vec::new();
    }
    let missed = |i: usize| {
        // At the ends there are points on one side alone, from which nothing can be told.
        let i = i.clamp(1, n - 2);
        let first = i.saturating_sub(NODES / 2).min(n - 1 - nodes);
        let around = (first..=first + nodes).filter(|j| *j != i);
        let around: Vec<&CurvePoint> = around.map(|j| &places[j]).collect();
        Some((places[i].value? - interpolated(&around, places[i].at)?).abs())
    };
    let intervals = places.windows(2).enumerate().filter_map(|(i, ends)| {
        let [a, b] = [&ends[0], &ends[1]];
        let step = (a.value? - b.value?).abs();
        let missed = missed(i)?.max(missed(i + 1)?);
        (missed > a.doubt(b).max(SMOOTH * step)).then_some([a.at, b.at])
    });
    intervals.collect()
}

/// The polynomial through points, by Lagrange's formula; `None` where one has no value.
fn interpolated(points: &[&CurvePoint], at: f64) -> Option<f64> {
    let terms = points.iter().enumerate().map(|(i, point)| {
        let others = points.iter().enumerate().filter(|(j, _)| *j != i);
        let weight = others.map(|(_, other)| (at - other.at) / (point.at - other.at));
        Some(point.value? * weight.product::<f64>())
    });
    terms.sum()
}

impl Extremum {
    /// The abscissa of the extremum and half the width of its bracket, by golden-section search.
    /// This needs no smoothness: at some extrema the force is the larger of two peaks. `None` where
    /// the curve has no value.
    pub(super) fn locate(
        &self,
        curve: &dyn Fn(f64) -> Result<Option<f64>>,
    ) -> Result<Option<(f64, f64)>> {
        let [a, _, b] = self.around;
        // A missing value ends the search without an error.
        let height = |x: f64| match curve(x) {
            Ok(Some(y)) => Ok(if self.is_maximum { y } else { -y }),
            Ok(None) => Err(None),
            Err(error) => Err(Some(error)),
        };
        match golden_section([a, b], LEFT * (b - a), usize::MAX, height) {
            Ok(([a, b], best)) => Ok(Some((best.0, 0.5 * (b - a)))),
            Err(None) => Ok(None),
            Err(Some(error)) => Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(at: f64, value: f64) -> CurvePoint {
        CurvePoint {
            at,
            value: Some(value),
            error: 0.0,
        }
    }

    #[test]
    fn val_an_extreme_of_a_smooth_curve_and_of_a_kink() {
        let smooth = |x: f64| (x - 0.31).powi(2);
        let kink = |x: f64| 1.0 - (x - 0.62).abs();
        type Curve<'a> = &'a dyn Fn(f64) -> f64;
        for (curve, is_maximum, truth) in [(&smooth as Curve, false, 0.31), (&kink, true, 0.62)] {
            let at = (0..=10).map(|i| 0.1 * f64::from(i));
            let places: Vec<CurvePoint> = at.map(|x| place(x, curve(x))).collect();
            let turns = extrema(&places);
            assert_eq!((turns.len(), turns[0].is_maximum), (1, is_maximum));
            let (x, error) = turns[0].locate(&|x| Ok(Some(curve(x)))).unwrap().unwrap();
            let off = (x - truth).abs();
            assert!(off <= 2.0 * error && error <= 1e-6, "{x} {error}");
        }
        let none = |middle: f64, last: f64, error: f64| {
            let middle = CurvePoint {
                error,
                ..place(1.0, middle)
            };
            extrema(&[place(0.0, 1.0), middle, place(2.0, last)]).is_empty()
        };
        // Rising, noise, within its error, not known.
        assert!(none(2.0, 3.0, 0.0) && none(1.0 + 1e-12, 1.0, 0.0) && none(2.0, 1.0, 0.5));
        assert!(!none(2.0, 1.0, 0.0));
    }

    /// A minimum at 3.7 and a maximum at 4.45 that no point shows are found, with few further points.
    #[test]
    fn val_extremes_that_points_step_over() {
        let curve = |x: f64| -x + 2.0 * (-((x - 4.5) / 0.5).powi(2)).exp();
        let points = |at: &[f64]| -> Result<Vec<CurvePoint>> {
            Ok(at.iter().map(|x| place(*x, curve(*x))).collect())
        };
        let at: Vec<f64> = (0..=10).map(f64::from).collect();
        let coarse = points(&at).unwrap();
        assert!(extrema(&coarse).is_empty());
        let (fine, hidden) = resolved(coarse, &points).unwrap();
        let turns: Vec<f64> = extrema(&fine).iter().map(|turn| turn.around[1]).collect();
        let is_near = (turns[0] - 3.7).abs() < 0.1 && (turns[1] - 4.45).abs() < 0.1;
        assert!(is_near && turns.len() == 2, "{turns:?}");
        assert!(hidden.is_empty() && fine.len() < 40, "{fine:?}");
        let level = [0.0, 1.0, 2.0, 3.0].map(|x| place(x, 2.0));
        assert!(unresolved(&level).is_empty());
    }
}
