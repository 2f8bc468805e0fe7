//! Peaks of neighbouring cuts joined to branches.

use super::RidgeCut;
use super::peaks::Peak;
use crate::numeric::{dot, eliminated, gram};

/// Cuts that a branch may miss.
const GAP: usize = 2;
/// Points before and after one through which its slope is taken.
const ABOUT: usize = 5;

/// Share of its row below which a pivot of equations that are exact to rounding is none.
const SINGULAR: f64 = 1e-13;
/// Most that a point lies beside its cut, in bins.
const BESIDE: f64 = 2.0;
/// Part of the width of their cuts that points cover at least, or they are those of one line.
const RESOLVED: f64 = 0.5;

/// A point of a branch, in bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    pub cut: RidgeCut,
    pub peak: Peak,
    /// Its place in frequency and in wavenumber; across the cuts where the power is that the cut shows there.
    pub at: [f64; 2],
    /// Change of the place from one cut to the next, and its standard error.
    pub slope: f64,
    pub slope_error: f64,
}

/// Branches of the peaks of each cut over `places` bins.
///
/// A branch goes on with the peak nearest to where its last points lead. A peak is taken by one branch, the
/// nearest one first.
pub(super) fn joined(peaks: &[Vec<Peak>], places: usize) -> Vec<Vec<Peak>> {
    let mut open: Vec<Vec<Peak>> = Vec::new();
    let mut closed: Vec<Vec<Peak>> = Vec::new();
    for (cut, found) in peaks.iter().enumerate() {
        let is_ended = |branch: &mut Vec<Peak>| cut - branch[branch.len() - 1].cut > GAP + 1;
        closed.extend(open.extract_if(.., is_ended));
        let mut pairs = Vec::new();
        for (b, branch) in open.iter().enumerate() {
            let (expected, reach) = continued(branch, cut, places);
            for (p, peak) in found.iter().enumerate() {
                let distance = (peak.at - expected).abs();
                if distance <= reach {
                    // Long branches are sure where they go.
                    pairs.push((distance / reach.sqrt(), b, p));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut goes_on = vec![false; open.len()];
        let mut taken = vec![false; found.len()];
        for (_, b, p) in pairs {
            if !goes_on[b] && !taken[p] {
                (goes_on[b], taken[p]) = (true, true);
                open[b].push(found[p]);
            }
        }
        let new = found.iter().zip(&taken).filter(|(_, taken)| !**taken);
        open.extend(new.map(|(peak, _)| vec![*peak]));
    }
    closed.extend(open);
    closed.sort_by(|a, b| a[0].cut.cmp(&b[0].cut).then(a[0].at.total_cmp(&b[0].at)));
    closed
}

/// Where a branch is expected at a cut, and how far from there it may be, in bins.
fn continued(branch: &[Peak], cut: usize, places: usize) -> (f64, f64) {
    let count = branch.len();
    let last = branch[count - 1];
    let steps = (cut - last.cut) as f64;
    let least = 2.0_f64.max(3.0 * last.error).max(last.width);
    if count == 1 {
        return (last.at, least.max(places as f64 / 10.0) * steps);
    }
    let from = branch[count.saturating_sub(3)];
    let slope = (last.at - from.at) / (last.cut - from.cut) as f64;
    let reach = least.max(0.5 * slope.abs()) * steps;
    (last.at + slope * steps, reach)
}

/// Where the power is that the peaks of a branch show: a cut holds what the window spreads into it, most of it from the side on
/// which the branch is stronger. By Tweedie's formula the mean of what is spread there lies at `cut + variance d ln S / d
/// cut`, with the variance of the window's lobe across the cuts. It is exact for a Gaussian lobe.
///
/// Source: B. Efron, J. Am. Stat. Assoc. 106, 1602 (2011).
fn across(branch: &[Peak], variance: f64) -> Vec<f64> {
    let last = branch.len().saturating_sub(1);
    let place = |i: usize| {
        let [before, after] = [i.saturating_sub(1), (i + 1).min(last)].map(|i| branch[i]);
        let growth = (after.height - before.height) / (after.cut - before.cut).max(1) as f64;
        let beside = (variance * growth).clamp(-BESIDE, BESIDE);
        branch[i].cut as f64 + if beside.is_finite() { beside } else { 0.0 }
    };
    (0..branch.len()).map(place).collect()
}

/// The points of a branch with their slopes: least squares of a parabola about each, of a line where there are
/// few. Errors are at least the spread about it. `variance`: of the window's lobe across the cuts, in squares of bins.
pub(super) fn smooth(branch: &[Peak], cut: RidgeCut, variance: f64) -> Vec<Point> {
    let across = across(branch, variance);
    let of = |i: usize| {
        // As many on both sides, as far as there are.
        let about = i.saturating_sub(ABOUT)..branch.len().min(i + ABOUT + 1);
        let peaks = &branch[about.clone()];
        let width = (peaks[peaks.len() - 1].cut - peaks[0].cut) as f64;
        let covered = across[about.end - 1] - across[about.start];
        // A line leaks to its cuts: they tell one place of it, and no slope.
        let place = |j: usize| match covered < RESOLVED * width {
            true => branch[j].cut as f64,
            false => across[j],
        };
        let middle = place(i);
        let points: Vec<(f64, f64)> = about.map(|j| (place(j) - middle, branch[j].at)).collect();
        let order = if points.len() >= 6 { 3 } else { 2 };
        // Without a slope the error of the place is its own.
        let (value, variance) = polynomial(&points, order).unwrap_or(([f64::NAN; 3], f64::NAN));
        let off = |(u, v): &(f64, f64)| v - value[0] - u * (value[1] + u * value[2]);
        let squares: f64 = points.iter().map(|point| off(point).powi(2)).sum();
        let spread = (squares / (points.len() as f64 - order as f64)).sqrt();
        let formal = peaks.iter().map(|peak| peak.error.powi(2)).sum::<f64>() / peaks.len() as f64;
        let mut peak = branch[i];
        peak.error = peak.error.max(spread);
        Point {
            cut,
            peak,
            at: cut.sorted([middle, peak.at]),
            slope: value[1],
            slope_error: (spread * spread).max(formal).sqrt() * variance.sqrt(),
        }
    };
    (0..branch.len()).map(of).collect()
}

/// Coefficients of a polynomial of `order` 2 or 3 terms, and the variance of its slope at 0 for unit errors.
fn polynomial(points: &[(f64, f64)], order: usize) -> Option<([f64; 3], f64)> {
    if points.len() <= order {
        return None;
    }
    let power = |of: usize| points.iter().map(|(u, _)| [1.0, *u, u * u][of]).collect();
    let columns: Vec<Vec<f64>> = (0..order).map(power).collect();
    let values: Vec<f64> = points.iter().map(|(_, v)| *v).collect();
    let mut normal = gram(&columns);
    for (term, (row, column)) in normal.iter_mut().zip(&columns).enumerate() {
        // A second right side is the unit vector of the slope: its solution there is the variance.
        row.extend([dot(column, &values), f64::from(term == 1)]);
    }
    let solved = eliminated(normal, SINGULAR)?;
    let value = |term: usize| solved.get(term).map_or(0.0, |row| row[0]);
    Some((std::array::from_fn(value), solved[1][1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn peak(cut: usize, at: f64) -> Peak {
        Peak {
            cut,
            at,
            error: 0.01,
            width: 1.4,
            ..Peak::default()
        }
    }

    #[test]
    fn crossing_branches_go_straight_on() {
        let mut cuts = Vec::new();
        for cut in 0..40 {
            let t = cut as f64;
            let mut both = vec![peak(cut, 10.0 + 1.5 * t), peak(cut, 68.2 - 1.4 * t)];
            if cut == 11 {
                both.remove(0);
            }
            both.sort_by(|a, b| a.at.total_cmp(&b.at));
            cuts.push(both);
        }
        let found = joined(&cuts, 100);
        assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), [39, 40]);
        assert!((found[0][38].at - 68.5).abs() < 1e-12);
    }
}
