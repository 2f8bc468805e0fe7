//! The best sensors: of few choices all are tried; of many, sensors are added one by one and then exchanged.

use ndarray::Array2;

use super::information::sum;

/// Choices that are tried, at most.
const ALL: f64 = 20_000.0;

/// Rounds of exchanges, at most; each gains.
const ROUNDS: usize = 200;

/// What a choice must gain, of the score, to be better by more than rounding.
const GAIN: f64 = 1e-12;

/// Chosen candidates, in order.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chosen {
    pub bodies: Vec<usize>,
    /// Whether all choices were tried.
    pub is_exact: bool,
}

/// The candidates whose information scores most.
pub(super) fn choose(
    each: &[Array2<f64>],
    count: usize,
    score: &dyn Fn(&Array2<f64>) -> f64,
) -> Chosen {
    let choices = (0..count).fold(1.0, |c, i| c * (each.len() - i) as f64 / (i + 1) as f64);
    let of = |bodies: &[usize]| score(&sum(each, bodies));
    if choices <= ALL {
        let first: Vec<usize> = (0..count).collect();
        let mut best = (f64::NEG_INFINITY, first.clone());
        let all = std::iter::successors(Some(first), |chosen| following(chosen, each.len()));
        for bodies in all {
            let score = of(&bodies);
            if is_more(score, best.0) {
                best = (score, bodies);
            }
        }
        return Chosen {
            bodies: best.1,
            is_exact: true,
        };
    }
    let starts = [grown(each, count, &of), even(each.len(), count)];
    let [first, second] = starts.map(|start| exchanged(each.len(), start, &of));
    let is_second = is_more(second.0, first.0);
    Chosen {
        bodies: if is_second { second.1 } else { first.1 },
        is_exact: false,
    }
}

fn is_more(score: f64, than: f64) -> bool {
    match than.is_infinite() {
        true => score > than,
        false => score - than > GAIN * than.abs(),
    }
}

/// The next choice of as many candidates, in order; `None` behind the last.
fn following(chosen: &[usize], candidates: usize) -> Option<Vec<usize>> {
    let count = chosen.len();
    let at = (0..count).rfind(|i| chosen[*i] < candidates - count + i)?;
    let moved = (0..count - at).map(|more| chosen[at] + 1 + more);
    Some(chosen[..at].iter().copied().chain(moved).collect())
}

/// One after the other the sensor that adds most.
fn grown(each: &[Array2<f64>], count: usize, score: &dyn Fn(&[usize]) -> f64) -> Vec<usize> {
    let mut chosen: Vec<usize> = Vec::new();
    for _ in 0..count {
        let mut best = None;
        for next in (0..each.len()).filter(|i| !chosen.contains(i)) {
            let score = score(&[&chosen[..], &[next]].concat());
            if best.is_none_or(|(than, _)| is_more(score, than)) {
                best = Some((score, next));
            }
        }
        chosen.extend(best.map(|(_, next)| next));
    }
    chosen
}

/// The best exchange of one sensor against another, until none gains.
fn exchanged(
    candidates: usize,
    mut chosen: Vec<usize>,
    score: &dyn Fn(&[usize]) -> f64,
) -> (f64, Vec<usize>) {
    let mut now = score(&chosen);
    for _ in 0..ROUNDS {
        let mut best = None;
        for place in 0..chosen.len() {
            for other in (0..candidates).filter(|i| !chosen.contains(i)) {
                let mut next = chosen.clone();
                next[place] = other;
                let score = score(&next);
                if is_more(score, best.as_ref().map_or(now, |(than, _)| *than)) {
                    best = Some((score, next));
                }
            }
        }
        match best {
            Some(better) => (now, chosen) = better,
            None => break,
        }
    }
    chosen.sort_unstable();
    (now, chosen)
}

/// Evenly spaced candidates, half a distance from the ends.
pub(super) fn even(candidates: usize, count: usize) -> Vec<usize> {
    (0..count)
        .map(|i| (2 * i + 1) * candidates / (2 * count))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::information::{information, products, scaled};
    use super::*;
    use crate::fit::solver::cholesky;

    /// Information of a value of a polynomial of this degree at each of `count` places from -1 to 1.
    fn polynomial(degree: usize, count: usize) -> Vec<Array2<f64>> {
        let at = |i: usize| {
            let x = 2.0 * i as f64 / (count - 1) as f64 - 1.0;
            let mut powers: Vec<Vec<f64>> = (0..=degree).map(|k| vec![x.powi(k as i32)]).collect();
            powers.push(vec![0.0]);
            information(&products(&powers, 0..1), None, 1.0)
        };
        (0..count).map(at).collect()
    }

    fn volume(whole: &Array2<f64>) -> f64 {
        let whole = whole + &(Array2::<f64>::eye(whole.nrows()) * 1e-9);
        let lower = cholesky(&scaled(&whole, &vec![1.0; whole.nrows()]));
        let sum = |rows: Vec<Vec<f64>>| (0..rows.len()).map(|i| rows[i][i].ln()).sum();
        lower.map_or(f64::NEG_INFINITY, sum)
    }

    /// V. V. Fedorov (1972): the D-optimal places of a polynomial are the roots of `(1 - x^2) P_n'(x)`; of a cubic +-1 and
    /// +-1/sqrt(5) = +-0.447, of degree 4 also 0 and +-sqrt(3/7) = +-0.655.
    #[test]
    fn val_fedorov_optimal_places_of_polynomials() {
        let cubic = choose(&polynomial(3, 19), 4, &volume);
        assert!(cubic.is_exact);
        assert_eq!(cubic.bodies, [0, 5, 13, 18]);
        let exchanged = choose(&polynomial(4, 201), 5, &volume);
        assert!(!exchanged.is_exact);
        assert_eq!(exchanged.bodies, [0, 35, 100, 165, 200]);
        assert_eq!(even(12, 3), [2, 6, 10]);
    }
}
