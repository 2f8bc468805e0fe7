//! Bins and the edges of bands.

/// Relative distance within which an edge is taken to be a bin: edges are typed or computed, and
/// miss their bin by rounding.
const EDGE_TOLERANCE: f64 = 1e-9;

/// Whether a bin lies at or below the upper edge of a band.
pub(crate) fn at_or_below(bin: f64, edge: f64) -> bool {
    bin <= edge + EDGE_TOLERANCE * edge.abs()
}

/// Whether a bin lies in a band, both edges included.
pub(crate) fn in_band(bin: f64, band: (f64, f64)) -> bool {
    at_or_below(-bin, -band.0) && at_or_below(bin, band.1)
}

/// Number of bins of an ascending axis at or below the edge.
pub(crate) fn count_at_or_below(axis: &[f64], edge: f64) -> usize {
    axis.partition_point(|&bin| at_or_below(bin, edge))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_that_miss_their_bin_by_rounding_include_it() {
        // 0.1 * 3 is above 0.3 by one unit in the last place.
        let axis: Vec<f64> = (0..8).map(|n| 0.1 * n as f64).collect();
        assert!(axis[3] > 0.3);
        assert_eq!(count_at_or_below(&axis, 0.3), 4);
        assert_eq!(count_at_or_below(&axis, 0.2999), 3);
        assert!(in_band(axis[3], (0.0, 0.3)));
        assert!(in_band(0.3, (axis[3], 1.0)));
        assert!(in_band(-axis[3], (-0.3, 0.0)));
        assert!(!in_band(axis[3], (0.3001, 1.0)));
        assert!(!in_band(axis[3], (0.0, 0.2999)));
        assert_eq!(count_at_or_below(&axis, f64::INFINITY), 8);
        assert_eq!(count_at_or_below(&axis, f64::NAN), 0);
    }
}
