//! A measured law: forces at overlaps.

use super::ContactLaw;
use crate::chain::lattice::refuse;
use crate::error::Result;

/// A cubic between neighbouring points that is monotone where they are, with a continuous slope, and lines beyond the ends.
///
/// Source: F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300-304.
#[derive(Debug)]
pub(super) struct Table {
    overlap: Vec<f64>,
    force: Vec<f64>,
    slope: Vec<f64>,
    /// Integral of the force from the first point to each, less that to 0.
    energy: Vec<f64>,
}

impl Table {
    pub(super) fn new(overlap: Vec<f64>, force: Vec<f64>) -> Result<Table> {
        if overlap.len() != force.len() || overlap.len() < 2 {
            let found = format!("{} overlaps and {} forces", overlap.len(), force.len());
            return Err(refuse(
                "law",
                "a table of two rows or more, overlap and force",
                found,
            ));
        }
        if let Some(value) = overlap
            .iter()
            .chain(&force)
            .find(|value| !value.is_finite())
        {
            return Err(refuse("law", "a table of finite numbers", value));
        }
        if let Some(pair) = overlap.windows(2).find(|pair| pair[1] <= pair[0]) {
            let found = format!("{} after {}", pair[1], pair[0]);
            return Err(refuse("law", "a table of overlaps that grow", found));
        }
        let Some(zero) = overlap.iter().position(|&delta| delta == 0.0) else {
            return Err(refuse("law", "a table with a row at the overlap 0", "none"));
        };
        if force[zero] != 0.0 {
            return Err(refuse(
                "law",
                "a table with no force at the overlap 0",
                force[zero],
            ));
        }
        let slope = slopes(&overlap, &force);
        let mut table = Table {
            energy: vec![0.0; overlap.len()],
            overlap,
            force,
            slope,
        };
        let mut sum = 0.0;
        for i in 1..table.overlap.len() {
            sum += table
                .piece(i - 1)
                .integral(table.overlap[i] - table.overlap[i - 1]);
            table.energy[i] = sum;
        }
        let at_rest = table.energy[zero];
        table
            .energy
            .iter_mut()
            .for_each(|energy| *energy -= at_rest);
        Ok(table)
    }

    /// The piece from point i on.
    fn piece(&self, i: usize) -> Piece {
        let h = self.overlap[i + 1] - self.overlap[i];
        let rise = (self.force[i + 1] - self.force[i]) / h;
        let [d, e] = [self.slope[i], self.slope[i + 1]];
        Piece([
            self.force[i],
            d,
            (3.0 * rise - 2.0 * d - e) / h,
            (d + e - 2.0 * rise) / (h * h),
        ])
    }

    /// The piece in which an overlap is, the point that it begins at, and how far into it.
    fn at(&self, delta: f64) -> (Piece, usize, f64) {
        let last = self.overlap.len() - 1;
        let line = |i: usize| {
            (
                Piece([self.force[i], self.slope[i], 0.0, 0.0]),
                i,
                delta - self.overlap[i],
            )
        };
        match self.overlap.partition_point(|&point| point <= delta) {
            0 => line(0),
            i if i > last => line(last),
            i => (self.piece(i - 1), i - 1, delta - self.overlap[i - 1]),
        }
    }
}

/// A cubic of the distance from its first point.
#[derive(Debug, Clone, Copy)]
struct Piece([f64; 4]);

impl Piece {
    fn integral(self, s: f64) -> f64 {
        let [a, b, c, d] = self.0;
        s * (a + s * (b / 2.0 + s * (c / 3.0 + s * d / 4.0)))
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
        let rows = self.overlap.iter().zip(&self.force);
        let rows: Vec<String> = rows.map(|(d, f)| format!("{d} {f}")).collect();
        format!("table {}", rows.join(", "))
    }

    fn force(&self, delta: f64) -> f64 {
        let (Piece([a, b, c, d]), _, s) = self.at(delta);
        a + s * (b + s * (c + s * d))
    }

    fn stiffness(&self, delta: f64) -> f64 {
        let (Piece([_, b, c, d]), _, s) = self.at(delta);
        b + s * (2.0 * c + s * 3.0 * d)
    }

    fn bend(&self, delta: f64) -> f64 {
        let (Piece([_, _, c, d]), _, s) = self.at(delta);
        2.0 * c + 6.0 * d * s
    }

    fn energy(&self, delta: f64) -> f64 {
        let (piece, i, s) = self.at(delta);
        self.energy[i] + piece.integral(s)
    }

    fn range(&self) -> [f64; 2] {
        [self.overlap[0], self.overlap[self.overlap.len() - 1]]
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        let (Piece([_, b, c, d]), i, s) = self.at(d0);
        let (_, other, _) = self.at(d0 + r);
        if i != other {
            return self.force(d0 + r) - self.force(d0);
        }
        r * (b + s * (2.0 * c + s * 3.0 * d) + r * (c + 3.0 * d * s + r * d))
    }

    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        let (Piece([_, b, c, d]), i, s) = self.at(d0);
        let (_, other, _) = self.at(d0 + r);
        if i != other {
            return self.energy(d0 + r) - self.energy(d0) - self.force(d0) * r;
        }
        let slope = b + s * (2.0 * c + s * 3.0 * d);
        r * r * (slope / 2.0 + r * ((c + 3.0 * d * s) / 3.0 + r * d / 4.0))
    }
}
