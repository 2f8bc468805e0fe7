//! Measures of one spectrum: centroid, bandwidths, quantiles, band shares.

use super::bins::Bins;
use super::interleaved;
use crate::numeric::lanes::{LaneBlock, WIDTH};
use crate::numeric::sum;

/// The measures of one row; see [`crate::analyze::Moments`] for the equations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpectrumMoments {
    pub centroid: f64,
    pub bandwidth: f64,
    pub effective_bandwidth: f64,
    pub entropy: f64,
    pub participation: f64,
    pub median: f64,
    pub quantile_90: f64,
    pub low_share: f64,
    pub high_share: f64,
    /// Sum over bins.
    pub total: f64,
    /// Sum over bins in the top tenth of the axis.
    pub top: f64,
    /// Of bin 0.
    pub zero: f64,
}

/// The measures of eight one-sided spectra, interleaved, over `bins`.
///
/// Energy below `edge` is low; the bin that contains the edge is divided in proportion. Sums are
/// pairwise; a spectrum's bits do not depend on the others. A single bin has only an energy.
pub(crate) fn interleaved_moments(
    power: &[LaneBlock],
    bins: &Bins,
    edge: f64,
) -> [SpectrumMoments; WIDTH] {
    let axis = bins.centres;
    let count = bins.len();
    let top_from = axis.partition_point(|&q| q <= 0.9 * axis[count - 1]);
    let (below, top) = power.split_at(if count > 1 { top_from } else { count });
    let top = interleaved::total(top);
    let below = interleaved::total(below);
    let total = below + top;

    // The bin of the edge is summed separately, so that the smaller share keeps its digits.
    let (split, below_edge) = bins.split(if edge.is_nan() { 0.0 } else { edge });
    let mut leaves = Vec::with_capacity(count / interleaved::LEAF * 2 + 3);
    let mut part = |range| interleaved::shares((power, axis), range, &total, &mut leaves);
    let low = part(0..split);
    let cut = part(split..split + 1);
    let high = part(split + 1..count);
    let sums: [LaneBlock; 4] = std::array::from_fn(|k| low[k] + (cut[k] + high[k]));
    let [shares, first_moment, squares, entropy] = sums;
    let [low, cut, high] = [low[0], cut[0], high[0]];
    let centroid = first_moment / shares;
    let second_moment = interleaved::second_moment(&leaves, centroid);
    let levels = [0.5, 0.9];
    let [median, quantile_90] = interleaved::quantiles((power, bins), &total, &leaves, levels);
    let last_half = bins.ends_half().then_some(count - 1);
    std::array::from_fn(|i| {
        let [total, entropy] = [total.0[i], entropy.0[i]];
        let defined = total > 0.0 && total.is_finite() && count > 1;
        let or_nan = |value: f64| if defined { value } else { f64::NAN };
        // Bins of half the width hold their energy at twice the density.
        let halved = power[0].0[i] + last_half.map_or(0.0, |last| power[last].0[i]);
        let width = bins.step * (-std::f64::consts::LN_2 * halved / total).exp();
        let share = |value: f64| or_nan(if edge.is_nan() { f64::NAN } else { value });
        SpectrumMoments {
            centroid: or_nan(centroid.0[i]),
            bandwidth: or_nan(second_moment.0[i].sqrt()),
            effective_bandwidth: or_nan(width * entropy.exp()),
            entropy: or_nan(entropy / (count as f64).ln()),
            participation: or_nan(1.0 / squares.0[i]),
            median: or_nan(median[i]),
            quantile_90: or_nan(quantile_90[i]),
            low_share: share(low.0[i] + below_edge * cut.0[i]),
            high_share: share((1.0 - below_edge) * cut.0[i] + high.0[i]),
            total,
            top: top.0[i],
            zero: power[0].0[i],
        }
    })
}

/// The quantile `level` of the energy, from the cumulative energy at the ends of the bins, linear
/// in between; `None` without energy, and for a single bin.
pub(crate) fn quantile_of(power: &[f64], bins: &Bins, level: f64) -> Option<f64> {
    let total = total_of(power).filter(|_| bins.len() > 1)?;
    let shares = power.iter().map(|p| p / total);
    Some(bins.reached(0, shares, level))
}

/// The bin at or below which 90 % of the energy is; `None` without energy. For budgets, whose
/// fluxes are known only at bins.
pub(crate) fn edge_of(power: &[f64], axis: &[f64]) -> Option<f64> {
    let total = total_of(power)?;
    let mut below = 0.0;
    let reaches = |p: &f64| {
        below += p / total;
        below >= 0.9
    };
    let bin = power.iter().position(reaches);
    axis.get(bin.unwrap_or(axis.len() - 1)).copied()
}

/// The sum over bins, if there is energy.
fn total_of(power: &[f64]) -> Option<f64> {
    Some(sum(power)).filter(|total| *total > 0.0 && total.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::ArrayView1;
    use ndarray_stats::{EntropyExt, SummaryStatisticsExt};

    /// Of a transform of even length, but where there is a single bin.
    fn moments_of(power: &[f64], axis: &[f64], edge: f64) -> SpectrumMoments {
        let across: Vec<LaneBlock> = power
            .iter()
            .map(|&p| LaneBlock([0.0, p, p, 0.0, 2.0 * p, p, p, p]))
            .collect();
        let step = axis.get(1).copied().unwrap_or(1.0);
        let length = (2 * (axis.len() - 1)).max(1);
        let rows = interleaved_moments(&across, &Bins::new(axis, length, step), edge);
        let bits = |row: &SpectrumMoments| format!("{row:?}");
        assert_eq!(bits(&rows[1]), bits(&rows[7]));
        assert_eq!(rows[4].entropy.to_bits(), rows[1].entropy.to_bits());
        assert!(rows[0].total == 0.0 && rows[0].entropy.is_nan());
        rows[1]
    }

    #[test]
    fn a_constant_lies_at_zero_and_a_lone_bin_has_no_content() {
        let row = moments_of(&[3.0, 0.0, 0.0], &[0.0, 1.0, 2.0], 1.0);
        assert_eq!((row.centroid, row.bandwidth, row.entropy), (0.0, 0.0, 0.0));
        assert_eq!((row.median, row.effective_bandwidth), (0.25, 0.5));
        assert_eq!((row.low_share, row.high_share), (1.0, 0.0));
        let lone = moments_of(&[3.0], &[0.0], 1.0);
        assert!(lone.centroid.is_nan() && lone.median.is_nan() && lone.high_share.is_nan());
        assert_eq!(lone.total, 3.0);
    }

    /// Against `ndarray-stats` and plain sums, over six orders of magnitude and a few zeros; in the
    /// middle of a leaf of bins, at its end, and in others.
    #[test]
    fn val_ndarray_stats_entropy_and_sums_written_out() {
        for bins in [2_usize, 31, 32, 33, 1000] {
            let q: Vec<f64> = (0..bins).map(|m| 0.25 * m as f64).collect();
            let is_some = |m: usize| f64::from(u8::from(m % 7 != 3));
            let power = (0..bins).map(|m| is_some(m) * 10f64.powf(3.0 * (m as f64).sin()));
            let power: Vec<f64> = power.collect();
            // At two fifths of bin `at`, or of its upper half.
            let at = bins / 3;
            let (low, high) = ((q[at] - 0.125).max(0.0), q[at] + 0.125);
            let row = moments_of(&power, &q, low + 0.4 * (high - low));
            let total: f64 = power.iter().sum();
            let share: Vec<f64> = power.iter().map(|p| p / total).collect();
            let entropy = ArrayView1::from(&share).entropy().unwrap();
            let weights = ArrayView1::from(&share);
            let centroid = ArrayView1::from(&q).weighted_mean(&weights).unwrap();
            let bandwidth = ArrayView1::from(&q).weighted_std(&weights, 0.0).unwrap();
            let low = share[..at].iter().sum::<f64>() + 0.4 * share[at];
            let squares: f64 = share.iter().map(|s| s * s).sum();
            let width = 0.25 * 0.5f64.powf(share[0] + share[bins - 1]);
            let below = |level: f64| {
                let (mut sum, mut end) = (0.0, 0.0);
                for (m, s) in share.iter().enumerate() {
                    let half = if m == 0 || m + 1 == bins { 0.125 } else { 0.25 };
                    if sum + s >= level {
                        return end + half * (level - sum) / s;
                    }
                    sum += s;
                    end += half;
                }
                end
            };
            for (found, right) in [
                (row.entropy, entropy / (bins as f64).ln()),
                (row.effective_bandwidth, width * entropy.exp()),
                (row.centroid, centroid),
                (row.bandwidth, bandwidth),
                (row.median, below(0.5)),
                (row.quantile_90, below(0.9)),
                (row.participation, 1.0 / squares),
                (row.low_share, low),
                (row.high_share, 1.0 - low),
                (row.total, total),
                (row.zero, power[0]),
            ] {
                let error = (found - right).abs() / right.max(1e-3);
                assert!(error < 3e-13, "{bins} bins: {found:e} for {right:e}");
            }
            let bins = Bins::new(&q, 2 * (bins - 1), 0.25);
            let alone = quantile_of(&power, &bins, 0.9).unwrap();
            assert!((alone / row.quantile_90 - 1.0).abs() < 1e-12);
        }
    }

    /// Narrow lines far from zero, and two lines in far leaves, whose moments are known: nothing
    /// cancels.
    #[test]
    fn val_spread_of_narrow_lines_keeps_its_digits() {
        let axis: Vec<f64> = (0..8193).map(|m| 0.1 * f64::from(m)).collect();
        let lines = |at: &[(usize, f64)]| {
            let mut power = vec![0.0; axis.len()];
            at.iter().for_each(|&(m, p)| power[m] = p);
            moments_of(&power, &axis, 400.0)
        };
        let one = lines(&[(8100, 3.0)]);
        assert_eq!((one.centroid, one.bandwidth), (axis[8100], 0.0));
        // Bins 8100 and 8101 with 1 and 3: sqrt(3) / 4 of a bin.
        let narrow = lines(&[(8100, 1.0), (8101, 3.0)]);
        let right = 0.1 * 3f64.sqrt() / 4.0;
        // The centroid is rounded to 1e-13.
        assert!((narrow.bandwidth / right - 1.0).abs() < 1e-11);
        let far = lines(&[(40, 1.0), (8000, 1.0)]);
        assert!((far.bandwidth / 398.0 - 1.0).abs() < 1e-15);
        // Half of the energy: the end of the first bin; nine tenths: 0.8 of the second.
        assert!((far.median - 4.05).abs() < 1e-14);
        assert!((far.quantile_90 - (799.95 + 0.08)).abs() < 1e-12);
        assert_eq!((far.low_share, far.high_share), (0.5, 0.5));
    }
}
