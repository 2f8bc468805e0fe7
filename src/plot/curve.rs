//! The path of a curve through a frame.

use super::panel::Panel;
use super::scene::Point;

/// Samples from which on a curve has more of them than pixels, and is thinned.
const DENSE: usize = 2000;

/// A sample in the figure, and how many before it have no place.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Placed {
    at: Point,
    missing: usize,
}

/// The unbroken parts of a curve inside a panel's frame; gaps are where either coordinate cannot be
/// placed.
pub(super) fn paths(points: &[Point], panel: &Panel) -> Vec<Vec<Point>> {
    let mut missing = 0;
    let mut placed = Vec::new();
    for &(x, y) in points {
        match (panel.place_x(x), panel.place_y(y)) {
            (Some(x), Some(y)) => placed.push(Placed {
                at: (x, y),
                missing,
            }),
            _ => missing += 1,
        }
    }
    runs(placed, points.len() >= DENSE)
        .into_iter()
        .flat_map(|run| panel.rect.clip_path(run))
        .collect()
}

/// Whether a path is too short to be visible as a line.
pub(super) fn is_a_dot(path: &[Point]) -> bool {
    path.iter()
        .all(|p| (p.0 - path[0].0).abs().max((p.1 - path[0].1).abs()) < 1.0)
}

/// The unbroken parts of a curve, in order.
///
/// Of a dense one, only the first, the two extremes and the last of the samples in a pixel column
/// (or, for curves along the vertical, a pixel row) are kept, which looks the same; and a gap is
/// one where a whole column is empty.
fn runs(placed: Vec<Placed>, dense: bool) -> Vec<Vec<(f64, f64)>> {
    let extent = |part: fn(&Placed) -> f64| match placed[..] {
        [ref first, .., ref last] => (part(last) - part(first)).abs(),
        _ => 0.0,
    };
    let upright = extent(|p| p.at.1) > extent(|p| p.at.0);
    let column = |p: &Placed| if upright { p.at.1 } else { p.at.0 }.floor();
    let value = |p: &Placed| if upright { p.at.0 } else { p.at.1 };
    let kept = match dense {
        true => thin(&placed, column, value),
        false => placed,
    };
    let joined = |a: &Placed, b: &Placed| {
        a.missing == b.missing || (dense && (column(b) - column(a)).abs() <= 1.0)
    };
    kept.chunk_by(joined)
        .map(|run| run.iter().map(|p| p.at).collect())
        .collect()
}

fn thin(
    placed: &[Placed],
    column: impl Fn(&Placed) -> f64,
    value: impl Fn(&Placed) -> f64,
) -> Vec<Placed> {
    let mut kept = Vec::new();
    for group in placed.chunk_by(|a, b| column(a) == column(b)) {
        let by_value = |&a: &usize, &b: &usize| value(&group[a]).total_cmp(&value(&group[b]));
        let least = (0..group.len()).min_by(by_value);
        let most = (0..group.len()).max_by(by_value);
        let mut indices: Vec<usize> = [Some(0), least, most, Some(group.len() - 1)]
            .into_iter()
            .flatten()
            .collect();
        indices.sort_unstable();
        indices.dedup();
        kept.extend(indices.into_iter().map(|index| group[index]));
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every sample of a wave of `n` that `missing` does not leave out, over 1000 pixels.
    fn wave(n: usize, missing: impl Fn(usize) -> bool) -> Vec<Placed> {
        let mut gaps = 0;
        let mut placed = Vec::new();
        for m in 0..n {
            let x = 1000.0 * m as f64 / n as f64;
            match missing(m) {
                true => gaps += 1,
                false => placed.push(Placed {
                    at: (x, (0.1 * x).sin()),
                    missing: gaps,
                }),
            }
        }
        placed
    }

    #[test]
    fn sparse_curves_show_each_gap() {
        let whole = runs(wave(200, |m| m == 50), false);
        assert_eq!(whole.iter().map(Vec::len).collect::<Vec<_>>(), [50, 149]);
    }

    #[test]
    fn dense_curves_show_gaps_of_a_pixel_and_more() {
        let runs = runs(
            wave(100_000, |m| m % 2 == 1 || (500..900).contains(&m)),
            true,
        );
        assert_eq!(runs.len(), 2);
        assert!(runs.iter().map(Vec::len).sum::<usize>() <= 4000);
        let last = runs[0].last().expect("a run has points");
        assert!(last.0 < 5.0 && runs[1][0].0 >= 9.0);
    }

    #[test]
    fn thousands_of_gaps_make_no_thousands_of_lines() {
        for n in [2000, 3000, 10_000] {
            for period in [2, 3, 7, 20] {
                let runs = runs(wave(n, |m| m % period == 0), true);
                assert!(runs.len() <= 500, "{n} by {period}: {}", runs.len());
            }
        }
    }

    #[test]
    fn nothing_to_draw_is_no_run() {
        assert!(runs(Vec::new(), true).is_empty());
        assert!(runs(Vec::new(), false).is_empty());
    }
}
