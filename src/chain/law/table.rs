//! A measured law: forces at overlaps.

use super::ContactLaw;
use crate::chain::lattice::all_are;
use crate::error::{Error, Result};
use crate::numeric::{Jet, Real};

/// A cubic between neighbouring points that is monotone where they are, with a continuous slope, and lines beyond the ends.
///
/// Source: F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300-304.
#[derive(Debug)]
pub(super) struct Table {
    /// The line before the first point, and a piece from each point on, of which the last is a line.
    pieces: Vec<Piece>,
}

/// A cubic of the distance from a point.
#[derive(Debug, Clone, Copy)]
struct Piece {
    point: f64,
    terms: [f64; 4],
    /// Integral of the force from 0 to the point.
    energy: f64,
}

impl Piece {
    fn force(&self, delta: Jet) -> Jet {
        let s = delta - Jet::constant(self.point);
        let [a, b, c, d] = self.terms.map(Jet::constant);
        a + s * (b + s * (c + s * d))
    }

    fn energy(&self, delta: f64) -> f64 {
        let (s, [a, b, c, d]) = (delta - self.point, self.terms);
        self.energy + s * (a + s * (b / 2.0 + s * (c / 3.0 + s * d / 4.0)))
    }
}

impl Table {
    pub(super) fn new(overlap: Vec<f64>, force: Vec<f64>) -> Result<Table> {
        let n = overlap.len();
        let found = format!("{n} overlaps and {} forces", force.len());
        let expected = "a table of two rows or more, overlap and force";
        Error::require(n == force.len() && n >= 2, "law", expected, found)?;
        let finite = ("law", "a table of finite numbers");
        all_are(finite, overlap.iter().chain(&force), f64::is_finite)?;
        if let Some(pair) = overlap.windows(2).find(|pair| pair[1] <= pair[0]) {
            let found = format!("{} after {}", pair[1], pair[0]);
            return Err(Error::request(
                "law",
                "a table of overlaps that grow",
                found,
            ));
        }
        let zero = overlap.iter().position(|delta| *delta == 0.0);
        let Some(zero) = zero.filter(|zero| force[*zero] == 0.0) else {
            let found = zero.map_or("no such row".into(), |zero| force[zero].to_string());
            let expected = "a table with no force at the overlap 0";
            return Err(Error::request("law", expected, found));
        };
        let slope = slopes(&overlap, &force);
        let line = |i: usize| Piece {
            point: overlap[i],
            terms: [force[i], slope[i], 0.0, 0.0],
            energy: 0.0,
        };
        let cubic = |i: usize| {
            let h = overlap[i + 1] - overlap[i];
            let rise = (force[i + 1] - force[i]) / h;
            let [d, e] = [slope[i], slope[i + 1]];
            let terms = [
                force[i],
                d,
                (3.0 * rise - 2.0 * d - e) / h,
                (d + e - 2.0 * rise) / (h * h),
            ];
            Piece { terms, ..line(i) }
        };
        let mut pieces = vec![line(0)];
        pieces.extend((0..n - 1).map(cubic));
        pieces.push(line(n - 1));
        for i in 2..=n {
            pieces[i].energy = pieces[i - 1].energy(pieces[i].point);
        }
        let at_rest = pieces[zero + 1].energy;
        pieces.iter_mut().for_each(|piece| piece.energy -= at_rest);
        Ok(Table { pieces })
    }

    /// The piece in which an overlap is.
    fn at(&self, delta: f64) -> &Piece {
        let points = &self.pieces[1..];
        &self.pieces[points.partition_point(|piece| piece.point <= delta)]
    }
}

/// Slopes at the points: a harmonic mean where the force goes on, 0 where it turns.
fn slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    let step = |i: usize| x[i + 1] - x[i];
    let rise = |i: usize| (y[i + 1] - y[i]) / step(i);
    if n == 2 {
        return vec![rise(0); 2];
    }
    // Three-point formula of an end, kept monotone.
    let end = |h: [f64; 2], d: [f64; 2]| {
        let slope = ((2.0 * h[0] + h[1]) * d[0] - h[0] * d[1]) / (h[0] + h[1]);
        if slope * d[0] <= 0.0 {
            0.0
        } else if d[0] * d[1] < 0.0 && slope.abs() > 3.0 * d[0].abs() {
            3.0 * d[0]
        } else {
            slope
        }
    };
    let inner = |i: usize| {
        let (before, after) = (rise(i - 1), rise(i));
        if before * after <= 0.0 {
            return 0.0;
        }
        let (first, second) = (2.0 * step(i) + step(i - 1), step(i) + 2.0 * step(i - 1));
        (first + second) / (first / before + second / after)
    };
    let mut slopes = vec![end([step(0), step(1)], [rise(0), rise(1)])];
    slopes.extend((1..n - 1).map(inner));
    slopes.push(end([step(n - 2), step(n - 3)], [rise(n - 2), rise(n - 3)]));
    slopes
}

impl ContactLaw for Table {
    fn text(&self) -> String {
        let rows = self.pieces[1..].iter();
        let rows = rows.map(|at| format!("{} {}", at.point, at.terms[0]));
        let rows: Vec<String> = rows.collect();
        format!("table {}", rows.join(", "))
    }

    fn force(&self, delta: Jet) -> Jet {
        self.at(delta.value).force(delta)
    }

    fn range(&self) -> [f64; 2] {
        [
            self.pieces[0].point,
            self.pieces[self.pieces.len() - 1].point,
        ]
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        let piece = self.at(d0);
        if !std::ptr::eq(piece, self.at(d0 + r)) {
            return self.force_at(d0 + r) - self.force_at(d0);
        }
        let Jet { slope, bend, .. } = piece.force(Jet::variable(d0));
        r * (slope + r * (bend / 2.0 + r * piece.terms[3]))
    }

    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        let [piece, far] = [d0, d0 + r].map(|delta| self.at(delta));
        if !std::ptr::eq(piece, far) {
            return far.energy(d0 + r) - piece.energy(d0) - self.force_at(d0) * r;
        }
        let Jet { slope, bend, .. } = piece.force(Jet::variable(d0));
        r * r * (slope / 2.0 + r * (bend / 6.0 + r * piece.terms[3] / 4.0))
    }
}
