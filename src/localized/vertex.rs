//! Closing in on a minimum between three points.

/// Three points of a function, the value of the middle one less than those of the others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bracket {
    points: [(f64, f64); 3],
    /// Points in a row that brought little.
    poor: usize,
    /// Width before these.
    since: f64,
}

impl Bracket {
    pub(super) fn new(points: [(f64, f64); 3]) -> Bracket {
        Bracket {
            points,
            poor: 0,
            since: points[2].0 - points[0].0,
        }
    }

    pub(super) fn best(&self) -> (f64, f64) {
        self.points[1]
    }

    pub(super) fn ends(&self) -> [(f64, f64); 2] {
        [self.points[0], self.points[2]]
    }

    pub(super) fn width(&self) -> f64 {
        self.points[2].0 - self.points[0].0
    }

    /// Where to look next for the least value of a function whose square root `s`, the magnitude of an
    /// amplitude that passes zero, is close to a line on either side.
    ///
    /// The zero is on one side of the best point or on the other. In either case the line through the
    /// two points on the far side leads to it, and the slope from there to the third point is about the
    /// same in the right case.
    pub(super) fn next_of_amplitudes(&self) -> f64 {
        let [(a, _), (b, _), (c, _)] = self.points;
        let [sa, sb, sc] = self.points.map(|point| point.1.max(0.0).sqrt());
        let zero = |near: f64, far: f64, s_far: f64, other: f64, s_other: f64| {
            let slope = (s_far - sb) / (far - near).abs();
            let at = near + (near - far).signum() * sb / slope;
            let beyond = s_other / (other - at).abs();
            let between = at != near && (at - near).abs() < (other - near).abs();
            (slope > 0.0 && between).then(|| (at, (beyond / slope).ln().abs()))
        };
        let left = zero(b, c, sc, a, sa);
        let right = zero(b, a, sa, c, sc);
        let likely = [left, right].into_iter().flatten();
        let likely = likely.min_by(|a, b| a.1.total_cmp(&b.1));
        match likely.filter(|_| self.poor < PATIENCE) {
            Some((at, _)) => at.clamp(a + EDGE * (b - a), c - EDGE * (c - b)),
            None => self.middle(),
        }
    }

    /// Where to look next for the least value: at the vertex of the parabola through the three points, but
    /// no closer to the best point than `aside`, so that the bracket closes.
    pub(super) fn next_of_parabola(&self, aside: f64) -> f64 {
        let [(a, fa), (b, fb), (c, fc)] = self.points;
        let (left, right) = ((b - a) * (fb - fc), (b - c) * (fb - fa));
        let vertex = b - 0.5 * ((b - a) * left - (b - c) * right) / (left - right);
        if !vertex.is_finite() || self.poor >= PATIENCE {
            return self.middle();
        }
        let longer = if c - b > b - a { 1.0 } else { -1.0 };
        let at = match (vertex - b).abs() < aside {
            true => b + longer * aside,
            false => vertex,
        };
        at.clamp(a + EDGE * (b - a), c - EDGE * (c - b))
    }

    /// The middle of the longer part.
    fn middle(&self) -> f64 {
        let [(a, _), (b, _), (c, _)] = self.points;
        0.5 * (b + if c - b > b - a { c } else { a })
    }

    /// Takes a point between the ends; tells whether it is the best. A value that is not a number is none.
    pub(super) fn narrow(&mut self, point: (f64, f64)) -> bool {
        let [a, b, c] = self.points;
        let better = point.1 < b.1;
        self.points = match (point.0 < b.0, better) {
            (true, true) => [a, point, b],
            (false, true) => [b, point, c],
            (true, false) => [point, b, c],
            (false, false) => [a, b, point],
        };
        let much = (0.0..0.25 * b.1).contains(&point.1);
        self.poor += 1;
        if much || self.width() < 0.5 * self.since || self.poor > PATIENCE {
            (self.poor, self.since) = (0, self.width());
        }
        better
    }
}

/// Points in a row that may bring little before the longer part is halved.
const PATIENCE: usize = 3;
/// Closest distance to an end, as a share of the part.
const EDGE: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;

    fn closed(f: impl Fn(f64) -> f64, next: impl Fn(&Bracket) -> f64) -> (f64, usize) {
        let mut bracket = Bracket::new([-1.0, 0.1, 1.0].map(|x| (x, f(x))));
        let mut calls = 0;
        while bracket.width() > 1e-7 && f(bracket.best().0).abs() > 1e-14 && calls < 100 {
            let x = next(&bracket);
            bracket.narrow((x, f(x)));
            calls += 1;
        }
        (bracket.best().0, calls)
    }

    #[test]
    fn val_known_zeros_of_powers_with_uneven_sides() {
        for (power, steeper, zero) in [(2.0, 1.0, 0.3), (2.2, 3.0, -0.45), (2.5, 2.0, 0.05)] {
            let side = |x: f64| if x > zero { steeper } else { 1.0 };
            let f = |x: f64| side(x) * (x - zero).abs().powf(power);
            let (at, calls) = closed(f, Bracket::next_of_amplitudes);
            let is_near = (at - zero).abs() < 3e-6;
            assert!(is_near && calls <= 26, "{power}: {at} after {calls}");
        }
    }

    #[test]
    fn val_known_maximum() {
        let f = |x: f64| -(-(x - 0.37f64).powi(2)).exp() - 0.1 * x;
        let (at, calls) = closed(f, |b| b.next_of_parabola(3e-8));
        let slope = 0.1 - 2.0 * (at - 0.37) * (-(at - 0.37f64).powi(2)).exp();
        assert!(slope.abs() < 1e-6 && calls <= 16, "{at} after {calls}");
    }
}
