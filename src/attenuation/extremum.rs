//! Locating extrema of a curve that is expensive to evaluate (one simulation per value).

use crate::Result;
use crate::numeric::GoldenSection;

/// Final width of the bracket of an extremum, relative to its initial width.
const LEFT: f64 = 1e-5;

/// A difference is significant if it exceeds this many errors plus this fraction of the value.
const DOUBT: f64 = 4.0;
const ROUNDING: f64 = 1e-10;

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

/// The extrema of a curve given by its points in order. An extremum differs from both neighbours by
/// more than the errors, and all three points have values.
pub(super) fn extrema(places: &[CurvePoint]) -> Vec<Extremum> {
    let turns = places.windows(3).filter_map(|places| {
        let [a, b, c] = [&places[0], &places[1], &places[2]];
        let (ya, yb, yc) = (a.value?, b.value?, c.value?);
        let above = |y: f64, other: &CurvePoint| {
            yb - y > DOUBT * (b.error + other.error) + ROUNDING * yb.abs()
        };
        let below = |y: f64, other: &CurvePoint| {
            y - yb > DOUBT * (b.error + other.error) + ROUNDING * yb.abs()
        };
        let is_maximum = above(ya, a) && above(yc, c);
        let is_minimum = below(ya, a) && below(yc, c);
        (is_maximum || is_minimum).then_some(Extremum {
            is_maximum,
            around: [a.at, b.at, c.at],
        })
    });
    turns.collect()
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
        let search = || {
            let mut search = GoldenSection::new([a, b], height)?;
            let enough = LEFT * search.width();
            while search.width() > enough {
                let [c, d] = search.inner;
                search.narrow(c.1 > d.1, height)?;
            }
            let [c, d] = search.inner;
            let best = if c.1 > d.1 { c.0 } else { d.0 };
            Ok((best, 0.5 * search.width()))
        };
        match search() {
            Ok(found) => Ok(Some(found)),
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
        let places = |curve: &dyn Fn(f64) -> f64| -> Vec<CurvePoint> {
            (0..=10)
                .map(|i| 0.1 * f64::from(i))
                .map(|x| place(x, curve(x)))
                .collect()
        };
        for (curve, is_maximum, truth) in [
            (&smooth as &dyn Fn(f64) -> f64, false, 0.31),
            (&kink, true, 0.62),
        ] {
            let turns = extrema(&places(curve));
            assert_eq!(turns.len(), 1);
            assert_eq!(turns[0].is_maximum, is_maximum);
            let (x, error) = turns[0].locate(&|x| Ok(Some(curve(x)))).unwrap().unwrap();
            assert!(
                (x - truth).abs() <= 2.0 * error && error <= 1e-6,
                "{x} {error}"
            );
        }
        let rising = [place(0.0, 1.0), place(1.0, 2.0), place(2.0, 3.0)];
        assert!(extrema(&rising).is_empty());
        let noise = [place(0.0, 1.0), place(1.0, 1.0 + 1e-12), place(2.0, 1.0)];
        assert!(extrema(&noise).is_empty());
        let mut gap = [place(0.0, 1.0), place(1.0, 2.0), place(2.0, 1.0)];
        assert_eq!(extrema(&gap).len(), 1);
        gap[1].error = 0.5;
        assert!(extrema(&gap).is_empty());
        gap[1] = CurvePoint {
            value: None,
            ..gap[1]
        };
        assert!(extrema(&gap).is_empty());
    }
}
