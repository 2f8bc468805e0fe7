//! Arrival of the wave at a site, and the quiet part of its record before.
//!
//! The record up to its largest deviation is split where the likelihood of two independent normal
//! samples of different variances is largest: where `k ln var_1 + (n - k) ln var_2` is least. The
//! foot of a wave is below the noise, so the quiet part ends earlier: by twice the time from the
//! split to half of the largest deviation, or four times the time from there to the largest.
//!
//! Source: N. Maeda, *A method for reading and checking phase times in auto-processing system of
//! seismic wave data*, Zisin 38 (1985) 365.

/// Samples below which a part has no variance to speak of.
const LEAST_PART: usize = 8;

/// Gain of log-likelihood, times two, that a cut must bring; chance brings about 10.
const LEAST_GAIN: f64 = 40.0;

/// The quiet part of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct QuietPart {
    /// Sample at which the wave arrives; `None` where it does not.
    pub(super) arrival: Option<usize>,
    /// Samples before its foot.
    pub(super) samples: usize,
}

impl QuietPart {
    /// Of a site that moves from the start.
    pub(super) const NONE: QuietPart = QuietPart {
        arrival: Some(0),
        samples: 0,
    };
}

pub(super) fn quiet_part(record: &[f64]) -> QuietPart {
    let n = record.len();
    let mut sorted = record.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.get(n / 2).copied().unwrap_or(0.0);
    let off = |i: usize| (record[i] - middle).abs();
    let peak = (0..n).fold(0, |best, i| if off(i) > off(best) { i } else { best });
    let none = QuietPart {
        arrival: None,
        samples: n,
    };
    if n == 0 || off(peak) == 0.0 {
        return none;
    }
    // So early a peak is indistinguishable from the motion of a site that is struck at once.
    if peak < 2 * LEAST_PART {
        return QuietPart::NONE;
    }
    let scale = off(peak);
    // Short pulses show as such with what follows them; a site in flight is off most before it is
    // stopped.
    let windows = [peak + 1, (peak + 4 * LEAST_PART).min(n), n];
    let changes = |end: &usize| cut(&record[..*end], middle, scale) != Cut::None;
    let mut end = windows.into_iter().find(changes).unwrap_or(n);
    let mut arrival = None;
    // Of several waves the strongest is found first, then those before it.
    loop {
        match cut(&record[..arrival.unwrap_or(end)], middle, scale) {
            Cut::Quieter(earlier) => {
                end = arrival.unwrap_or(end);
                arrival = Some(earlier);
            }
            Cut::Louder if arrival.is_none() => return QuietPart::NONE,
            Cut::Louder | Cut::None => break,
        }
    }
    arrival.map_or(none, |at| QuietPart {
        arrival,
        samples: at.saturating_sub(foot(record, at, end)),
    })
}

/// Samples by which a wave that is found at `arrival`, and over by `end`, may have begun before.
fn foot(record: &[f64], arrival: usize, end: usize) -> usize {
    let level = record[..arrival].iter().sum::<f64>() / arrival as f64;
    let off = |i: usize| (record[i] - level).abs();
    let peak = (arrival..end).fold(arrival, |best, i| if off(i) > off(best) { i } else { best });
    let rises = |i: &usize| off(*i) < 0.5 * off(peak);
    let rise = (arrival..peak).take_while(rises).count();
    // Strong noise hides the front except its top; the top's length is then used.
    let top = (2 * (peak - arrival - rise)).min(arrival / 4);
    2 * rise.max(top).max(1)
}

/// The more likely description of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cut {
    /// That its variance does not change.
    None,
    /// That it rises here.
    Quieter(usize),
    /// That it falls.
    Louder,
}

/// The most likely change of variance about a straight line.
fn cut(record: &[f64], middle: f64, scale: f64) -> Cut {
    let n = record.len();
    // Running sums of the values, of their squares, and of their products with the index.
    let mut sums = vec![[0.0; 3]; n + 1];
    for (i, value) in record.iter().enumerate() {
        let x = (value - middle) / scale;
        let [sum, squares, moments] = sums[i];
        sums[i + 1] = [sum + x, squares + x * x, moments + x * i as f64];
    }
    let cost = |from: usize, to: usize| {
        let count = (to - from) as f64;
        let [sum, squares, moment] = [0, 1, 2].map(|k| sums[to][k] - sums[from][k]);
        let lever = moment - sum * (0.5 * (from + to - 1) as f64);
        let spread = count * (count * count - 1.0) / 12.0;
        let left = squares - sum * sum / count - lever * lever / spread;
        // A variance below the rounding of the sums cannot be resolved.
        count * (left / count).max(1e-14).ln()
    };
    let of = |k: usize| cost(0, k) + cost(k, n);
    let mean = |from: usize, to: usize| cost(from, to) / (to - from) as f64;
    let gain = |k: usize| cost(0, n) - of(k);
    let places =
        || (LEAST_PART..n.saturating_sub(LEAST_PART) + 1).filter(|k| gain(*k) > LEAST_GAIN);
    let quieter = places().filter(|k| mean(0, *k) < mean(*k, n));
    match quieter.max_by(|a, b| gain(*a).total_cmp(&gain(*b))) {
        Some(best) => Cut::Quieter(best),
        None if places().next().is_some() => Cut::Louder,
        None => Cut::None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Random;

    fn record(noise: f64, arrival: usize, seed: u64) -> Vec<f64> {
        let mut random = Random::new(seed);
        (0..800)
            .map(|i| {
                let t = (i as f64 - arrival as f64) / 12.0;
                0.3 + 2e-4 * i as f64 + (-(t - 4.0) * (t - 4.0)).exp() + noise * random.normal()
            })
            .collect()
    }

    #[test]
    fn val_construction_the_quiet_part_ends_before_the_pulse() {
        let mut given_up = 0;
        for noise in [0.0, 1e-6, 1e-3, 0.01, 0.1, 0.2] {
            for seed in 0..20 {
                let found = quiet_part(&record(noise, 500, seed));
                // Strong noise may leave nothing to be sure of, which is no wrong answer.
                if noise >= 0.1 && found == QuietPart::NONE {
                    given_up += 1;
                    continue;
                }
                // At the sample 500 the pulse is at 1e-7 of its peak, at 536 at a third.
                let arrival = found.arrival.unwrap();
                assert!((470..545).contains(&arrival), "{noise} {seed} {found:?}");
                let foot = (found.samples as f64 - 500.0) / 12.0 - 4.0;
                let hidden = (-foot * foot).exp() < 0.1 * noise + 1e-6;
                assert!(found.samples > 300 && hidden, "{noise} {seed} {found:?}");
            }
        }
        assert!(given_up <= 4, "{given_up} of 40");
    }

    #[test]
    fn val_construction_noise_alone_and_records_without_a_quiet_part() {
        let mut random = Random::new(3);
        for _ in 0..200 {
            let mut noise: Vec<f64> = (0..400).map(|_| random.normal()).collect();
            noise[300] = 5.0;
            assert_eq!(quiet_part(&noise).arrival, None);
        }
        let moving: Vec<f64> = (0..400).map(|i| (-0.05 * f64::from(i)).exp()).collect();
        assert_eq!(quiet_part(&moving), QuietPart::NONE);
        let level = |i: i32| if i < 150 { 1.0 } else { 0.0 };
        let flight = (0..400).map(|i| level(i) + 1e-3 * random.normal());
        let flight: Vec<f64> = flight.collect();
        let arrival = quiet_part(&flight).arrival;
        assert!(arrival.is_some_and(|i| (140..160).contains(&i)));
        for samples in [0, 9] {
            let arrival = None;
            assert_eq!(
                quiet_part(&vec![0.0; samples]),
                QuietPart { arrival, samples }
            );
        }
    }
}
