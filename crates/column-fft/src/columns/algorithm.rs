//! The algorithm of a length and its radices, chosen before anything is planned.

use super::{cyclic, mixed_radix};

/// Radices of the first and the second half.
pub type Halves = (Vec<usize>, Vec<usize>);

/// The algorithm of a length, and the radices of its passes.
#[derive(Debug, Clone)]
pub enum Decomposition {
    MixedRadix(Halves),
    /// Bluestein's convolution, of as many points as the radices multiply to.
    Bluestein(Halves),
    Fallback,
}

/// The algorithm of a length.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Algorithm {
    /// By the four-step algorithm: two halves, each of passes of these radices.
    FourStep {
        /// Radices of the first half.
        first: Vec<usize>,
        /// Radices of the second half.
        second: Vec<usize>,
    },
    /// By a convolution, Bluestein's.
    Bluestein {
        /// Of the convolution.
        points: usize,
    },
    /// Column by column, by `realfft`: the shortest.
    ByColumn,
}

impl Decomposition {
    /// For a length of at least 1.
    pub fn of(length: usize) -> Decomposition {
        match halves(length) {
            Some(halves) => Decomposition::MixedRadix(halves),
            None if length <= 8 => Decomposition::Fallback,
            None => Decomposition::Bluestein(convolution(length + length / 2)),
        }
    }

    pub fn algorithm(&self) -> Algorithm {
        let points = |halves| {
            let [first, second] = lengths(halves);
            first * second
        };
        match self {
            Decomposition::MixedRadix((first, second)) => Algorithm::FourStep {
                first: first.clone(),
                second: second.clone(),
            },
            Decomposition::Bluestein(halves) => Algorithm::Bluestein {
                points: points(halves),
            },
            Decomposition::Fallback => Algorithm::ByColumn,
        }
    }

    /// Numbers of scratch for tiles of `width` columns.
    #[inline]
    pub fn scratch_len(&self, width: usize) -> usize {
        match self {
            Decomposition::MixedRadix(halves) => mixed_radix::scratch_len(lengths(halves), width),
            Decomposition::Bluestein(halves) => cyclic::scratch_len(lengths(halves), width),
            Decomposition::Fallback => 0,
        }
    }

    /// Root mean square error of white noise's bins over `EPSILON sqrt(log2 N)` of them all.
    pub fn rounding(&self) -> f64 {
        match self {
            Decomposition::MixedRadix(_) => 0.35,
            Decomposition::Bluestein(_) => 0.6,
            Decomposition::Fallback => 1.0,
        }
    }
}

#[inline]
fn lengths((first, second): &Halves) -> [usize; 2] {
    [first, second].map(|radices| radices.iter().product())
}

/// Radices of the first and the second half of a transform of `length` points; `None` where the
/// length has other prime factors than 2, 3, 5 and 7, or fewer than two in all.
fn halves(length: usize) -> Option<Halves> {
    let radices = radices(length)?;
    if radices.len() < 2 {
        return None;
    }
    // All subsets of a dozen radices at most.
    let mut best: Option<(f64, u32)> = None;
    for subset in 1..(1_u32 << radices.len()) - 1 {
        let part = |wanted: u32| {
            let chosen = radices.iter().enumerate();
            chosen.filter(move |(i, _)| subset >> i & 1 == wanted)
        };
        let first: usize = part(1).map(|(_, r)| r).product();
        let smallest = part(1).map(|(_, r)| *r).min().unwrap_or(0);
        let ratio = (first as f64).powi(2) / length as f64;
        // Halves alike, the first rather longer; the last pass of the first holds two groups of
        // numbers, so a small radix suits it.
        let mut cost = (ratio.log2() - 1.0).abs();
        if smallest > 5 {
            cost += 1.5;
        }
        if best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, subset));
        }
    }
    let (_, subset) = best?;
    let of = |wanted: u32| -> Vec<usize> {
        let chosen = radices.iter().enumerate();
        chosen
            .filter(|(i, _)| subset >> i & 1 == wanted)
            .map(|(_, &r)| r)
            .collect()
    };
    Some((of(1), of(0)))
}

/// The halves of the cheapest convolution of at least `least` points.
fn convolution(least: usize) -> Halves {
    // Lengths of small factors lie close; 16, 18, 20, 24, .. are those of two radices.
    let least = least.max(16);
    let lengths = smooth(least, least + least / 4 + 2).into_iter();
    let candidates = lengths.filter_map(|points| {
        let work: f64 = radices(points)?.into_iter().map(work).sum();
        Some((points as f64 * (work + 2.0), points))
    });
    let cheapest = candidates.min_by(|a, b| a.0.total_cmp(&b.0));
    let points = cheapest.map_or_else(|| least.next_power_of_two(), |(_, points)| points);
    halves(points).unwrap_or_else(|| (vec![4], vec![4]))
}

/// All numbers without other prime factors than 2, 3, 5 and 7 from `least` to `most`, in order.
fn smooth(least: usize, most: usize) -> Vec<usize> {
    let mut numbers = vec![1];
    for prime in [2, 3, 5, 7] {
        let mut at = 0;
        // Products are met again, so that all powers come.
        while at < numbers.len() {
            if numbers[at] <= most / prime {
                numbers.push(numbers[at] * prime);
            }
            at += 1;
        }
    }
    numbers.retain(|&number| number >= least);
    numbers.sort_unstable();
    numbers
}

/// Cost of a pass, a point.
fn work(radix: usize) -> f64 {
    match radix {
        2 => 1.5,
        3 => 2.1,
        4 => 2.2,
        5 => 3.2,
        7 => 4.8,
        _ => 3.1,
    }
}

/// Large radices first; `None` for other prime factors.
fn radices(length: usize) -> Option<Vec<usize>> {
    let mut rest = length;
    let mut count = |prime: usize| {
        let mut times = 0;
        while rest > 1 && rest.is_multiple_of(prime) {
            rest /= prime;
            times += 1;
        }
        times
    };
    let twos = count(2);
    let others = [(7, count(7)), (5, count(5)), (3, count(3))];
    if rest != 1 {
        return None;
    }
    // 8 x 2 is better done as 4 x 4.
    let (eights, fours, two) = match (twos / 3, twos % 3) {
        (0, 1) => (0, 0, 1),
        (eights, 0) => (eights, 0, 0),
        (eights, 1) => (eights - 1, 2, 0),
        (eights, _) => (eights, 1, 0),
    };
    let mut radices = vec![8; eights];
    for (radix, times) in others.into_iter().take(2) {
        radices.extend(vec![radix; times]);
    }
    radices.extend(vec![4; fours]);
    radices.extend(vec![3; others[2].1]);
    radices.extend(vec![2; two]);
    Some(radices)
}
