//! Polynomials of degree eight through values, rates and second derivatives at three nodes.
//!
//! With nodes at `-rho, 0, 1` in units of the last interval the error is that of
//! `g(u)^3 / 9!` times the ninth derivative, `g(u) = (u + rho) u (u - 1)`.

use crate::numeric::lanes::Number;

/// Where the rate of the polynomial is compared with the motion's: `g'` has no zero there, however
/// long the earlier interval.
const CHECKED: f64 = 0.75;

/// Weights of what the nodes deviate from the tangent at the middle one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weights {
    /// From the middle node.
    pub(super) dt: f64,
    /// Lengths of the two intervals.
    pub(super) lengths: [f64; 2],
    value: [f64; 7],
    rate: [f64; 7],
}

/// Two intervals between three times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Nodes {
    middle: f64,
    lengths: [f64; 2],
    each: [Node; 3],
}

/// A node, and what the other two make of it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Node {
    at: f64,
    others: [f64; 2],
    /// One over the distances of these.
    inverse: [f64; 2],
    /// The Taylor series of the inverse of their factors about this node.
    first: f64,
    second: f64,
}

impl Nodes {
    pub(super) fn new([before, start, end]: [f64; 3]) -> Nodes {
        let lengths = [start - before, end - start];
        let at = [-lengths[0] / lengths[1], 0.0, 1.0];
        let node = |i: usize| {
            let others = [at[(i + 1) % 3], at[(i + 2) % 3]];
            let inverse = others.map(|other| 1.0 / (at[i] - other));
            let first = 3.0 * (inverse[0] + inverse[1]);
            let squares = 3.0 * (inverse[0] * inverse[0] + inverse[1] * inverse[1]);
            Node {
                at: at[i],
                others,
                inverse,
                first,
                second: first * first + squares,
            }
        };
        Nodes {
            middle: start,
            lengths,
            each: [node(0), node(1), node(2)],
        }
    }

    /// Where the polynomial is checked, and the largest error of a value in the last interval over
    /// the error of its rate there.
    pub(super) fn check(&self) -> (f64, f64) {
        let [before, h] = self.lengths;
        let rho = before / h;
        let g = |u: f64| (u + rho) * u * (u - 1.0);
        let slope = |u: f64| u * (3.0 * u + 2.0 * (rho - 1.0)) - rho;
        let summit = (1.0 - rho + ((rho - 1.0).powi(2) + 3.0 * rho).sqrt()) / 3.0;
        let largest = g(summit).abs().powi(3);
        let rate = 3.0 * g(CHECKED).powi(2) * slope(CHECKED);
        (self.middle + CHECKED * h, h * largest / rate)
    }

    /// Weights at time t, those of the rate where it is wanted.
    pub(super) fn at(&self, t: f64, rate: bool) -> Weights {
        let h = self.lengths[1];
        let dt = t - self.middle;
        let u = dt / h;
        let mut values = [[0.0; 3]; 3];
        let mut rates = [[0.0; 3]; 3];
        for (i, node) in self.each.iter().enumerate() {
            let (inverse, first, second) = (node.inverse, node.first, node.second);
            let d = u - node.at;
            let share = [0, 1].map(|k| (u - node.others[k]) * inverse[k]);
            let product = share[0] * share[1];
            let factor = product * product * product;
            let mut unit = 1.0;
            let terms = [
                (1.0 - d * (first - 0.5 * second * d), second * d - first),
                (d * (1.0 - first * d), 1.0 - 2.0 * first * d),
                (0.5 * d * d, d),
            ];
            for (k, (p, dp)) in terms.into_iter().enumerate() {
                values[i][k] = unit * factor * p;
                if rate {
                    let bend = share[0] * inverse[1] + share[1] * inverse[0];
                    let slope = 3.0 * product * product * bend;
                    rates[i][k] = unit / h * (slope * p + factor * dp);
                }
                unit *= h;
            }
        }
        let pick = |w: [[f64; 3]; 3]| {
            [
                w[0][0], w[2][0], w[0][1], w[2][1], w[0][2], w[1][2], w[2][2],
            ]
        };
        Weights {
            dt,
            lengths: self.lengths,
            value: pick(values),
            rate: pick(rates),
        }
    }
}

impl Weights {
    /// The value, of values, rates and second derivatives at the nodes.
    #[inline(always)]
    pub(super) fn value<N: Number>(&self, p: [N; 3], d: [N; 3], s: [N; 3]) -> N {
        let tangent = p[1] + N::splat(self.dt) * d[1];
        tangent + self.sum(&self.value, p, d, s)
    }

    /// The rate.
    #[inline(always)]
    pub(super) fn rate<N: Number>(&self, p: [N; 3], d: [N; 3], s: [N; 3]) -> N {
        d[1] + self.sum(&self.rate, p, d, s)
    }

    #[inline(always)]
    fn sum<N: Number>(&self, w: &[f64; 7], p: [N; 3], d: [N; 3], s: [N; 3]) -> N {
        let [back, h] = self.lengths.map(N::splat);
        let w = w.map(N::splat);
        let off = [
            p[0] - p[1] + back * d[1],
            p[2] - p[1] - h * d[1],
            d[0] - d[1],
            d[2] - d[1],
        ];
        let far = w[0] * off[0] + w[2] * off[2] + w[4] * s[0];
        let near = w[1] * off[1] + w[3] * off[3] + w[6] * s[2];
        near + (far + w[5] * s[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Powers up to the eighth are their own interpolants; the ninth has the error stated.
    #[test]
    fn val_closed_form_powers() {
        let times = [0.3, 0.42, 0.6];
        let nodes = Nodes::new(times);
        let (checked, ratio) = nodes.check();
        for power in 0..=9 {
            let f = |t: f64| t.powi(power);
            let d = |t: f64| f64::from(power) * t.powi(power - 1);
            let s = |t: f64| f64::from(power * (power - 1)) * t.powi(power - 2);
            let [p, q, r] = [times.map(f), times.map(d), times.map(s)];
            let error = |t: f64| nodes.at(t, false).value(p, q, r) - f(t);
            let worst = (0..=1000)
                .map(|i| error(0.42 + 0.18 * f64::from(i) / 1000.0).abs())
                .fold(0.0, f64::max);
            let off = (nodes.at(checked, true).rate(p, q, r) - d(checked)).abs();
            if power == 9 {
                assert!(
                    (off * ratio / worst - 1.0).abs() < 1e-4,
                    "{off:e} {worst:e}"
                );
                assert!(worst > 1e-9);
            } else {
                assert!(worst < 4e-15 && off < 1e-13, "{power}: {worst:e} {off:e}");
            }
        }
    }
}
