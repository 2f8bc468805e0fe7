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
