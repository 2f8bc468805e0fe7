//! Measures of one spectrum: centroid, bandwidth, entropy, quantiles, band shares.

use ndarray::ArrayView1;
use ndarray_stats::EntropyExt;

use crate::analyze::Moments;
use crate::sum::sum;

/// The measures of one row; see [`Moments`] for the equations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    pub centroid: f64,
    pub bandwidth: f64,
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
}

impl Moments {
    /// Rows gathered into columns; `measure` turns a sum over bins into an integral.
    pub(crate) fn gather(rows: &[Row], measure: f64) -> Moments {
        let column = |of: fn(&Row) -> f64| rows.iter().map(of).collect::<Vec<f64>>();
        Moments {
            centroid: column(|r| r.centroid),
            bandwidth: column(|r| r.bandwidth),
            entropy: column(|r| r.entropy),
            participation: column(|r| r.participation),
            median: column(|r| r.median),
            quantile_90: column(|r| r.quantile_90),
            low_share: column(|r| r.low_share),
            high_share: column(|r| r.high_share),
            energy: rows.iter().map(|r| r.total * measure).collect(),
        }
    }
}

/// The measures of the one-sided spectrum `power` over the bins `axis`.
///
/// Energy at or below `edge` is low.
pub(crate) fn moments_of(power: &[f64], axis: &[f64], edge: f64) -> Row {
    let total = sum(power);
    let top_from = axis.partition_point(|&q| q <= 0.9 * axis[axis.len() - 1]);
    let top = if axis.len() > 1 {
        sum(&power[top_from..])
    } else {
        0.0
    };
    let undefined = Row {
        centroid: f64::NAN,
        bandwidth: f64::NAN,
        entropy: f64::NAN,
        participation: f64::NAN,
        median: f64::NAN,
        quantile_90: f64::NAN,
        low_share: f64::NAN,
        high_share: f64::NAN,
        total,
        top,
    };
    if !(total > 0.0 && total.is_finite()) {
        return undefined;
    }
    let share: Vec<f64> = power.iter().map(|p| p / total).collect();
    let (centroid, bandwidth) = centroid_and_bandwidth(&share[1..], &axis[1..]);
    let entropy = ArrayView1::from(&share).entropy().unwrap_or(f64::NAN);
    let bins = share.len() as f64;
    let participation = 1.0 / crate::sum::sum_of_squares(&share);
    let (median, quantile_90) = (quantile(&share, axis, 0.5), quantile(&share, axis, 0.9));
    // An edge that misses its bin by rounding means that bin.
    let slack = 1e-9 * axis.get(1).copied().unwrap_or_default();
    let split = axis.partition_point(|&q| q <= edge + slack);
    let (low, high) = share.split_at(split);
    let known = edge.is_finite();
    Row {
        centroid,
        bandwidth,
        // One bin holds no disorder; 0 / ln 1 would not say so.
        entropy: if share.len() > 1 {
            entropy / bins.ln()
        } else {
            0.0
        },
        participation,
        median,
        quantile_90,
        low_share: if known { sum(low) } else { f64::NAN },
        high_share: if known { sum(high) } else { f64::NAN },
        ..undefined
    }
}

/// The bin at or below which 90 % of the energy lies; `None` without energy.
pub(crate) fn edge_of(power: &[f64], axis: &[f64]) -> Option<f64> {
    let total = sum(power);
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let share: Vec<f64> = power.iter().map(|p| p / total).collect();
    Some(quantile(&share, axis, 0.9))
}

fn centroid_and_bandwidth(share: &[f64], axis: &[f64]) -> (f64, f64) {
    let weight = sum(share);
    if weight <= 0.0 {
        return (f64::NAN, f64::NAN);
    }
    let bins = share.iter().zip(axis);
    let mut moment: Vec<f64> = bins.clone().map(|(p, q)| p * q).collect();
    let centroid = sum(&moment) / weight;
    moment.clear();
    moment.extend(bins.map(|(p, q)| p * (q - centroid) * (q - centroid)));
    (centroid, (sum(&moment) / weight).sqrt())
}

/// The first bin at which the cumulative share reaches `level`.
fn quantile(share: &[f64], axis: &[f64], level: f64) -> f64 {
    /// Bins whose sum is looked at before each of them is.
    const STRIDE: usize = 64;
    let mut below = 0.0;
    for (share, axis) in share.chunks(STRIDE).zip(axis.chunks(STRIDE)) {
        let through = below + sum(share);
        if through >= level {
            let mut cumulative = below;
            for (&p, &q) in share.iter().zip(axis) {
                cumulative += p;
                if cumulative >= level {
                    return q;
                }
            }
        }
        below = through;
    }
    axis[axis.len() - 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_spectrum_has_full_entropy_and_participation() {
        let axis: Vec<f64> = (0..11).map(f64::from).collect();
        let row = moments_of(&[2.0; 11], &axis, 4.0);
        assert!((row.entropy - 1.0).abs() < 1e-15);
        assert!((row.participation - 11.0).abs() < 1e-13);
        assert!((row.centroid - 5.5).abs() < 1e-15); // 1 ..= 10
        assert!((row.bandwidth - (99.0f64 / 12.0).sqrt()).abs() < 1e-14);
        assert_eq!((row.median, row.quantile_90), (5.0, 9.0));
        assert!((row.low_share - 5.0 / 11.0).abs() < 1e-15);
        assert!((row.low_share + row.high_share - 1.0).abs() < 1e-15);
    }

    #[test]
    fn no_energy_is_undefined_and_not_zero() {
        let row = moments_of(&[0.0; 4], &[0.0, 1.0, 2.0, 3.0], 1.0);
        assert!(row.centroid.is_nan() && row.entropy.is_nan() && row.high_share.is_nan());
        assert_eq!(row.total, 0.0);
    }

    #[test]
    fn a_constant_has_energy_but_no_centroid() {
        let row = moments_of(&[3.0, 0.0, 0.0], &[0.0, 1.0, 2.0], 1.0);
        assert!(row.centroid.is_nan());
        assert_eq!((row.median, row.entropy, row.low_share), (0.0, 0.0, 1.0));
    }
}
