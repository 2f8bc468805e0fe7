//! Chains whose bodies or contacts differ along x.

/// Bodies of a cell, at most.
const CELL: usize = 4;
/// Relative difference of values that are the same.
const SAME: f64 = 1e-9;

/// Whether values are those of a cell that is repeated; the first and the last may be others, those of a striker or a wall.
fn repeats(values: &[f64]) -> bool {
    let inner = values.get(1..values.len().saturating_sub(1)).unwrap_or(&[]);
    (1..=CELL).any(|cell| {
        let mut pairs = inner.iter().zip(inner.iter().skip(cell));
        pairs.all(|(a, b)| (a - b).abs() <= SAME * a.abs())
    })
}

/// Masses of a chain of which masses or coefficients are not those of a repeated cell.
pub(crate) fn graded_masses(masses: &[f64], coefficients: &[f64]) -> Option<Vec<f64>> {
    (!repeats(masses) || !repeats(coefficients)).then(|| masses.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_construction_cells_repeat() {
        let cells: Vec<f64> = (0..41).map(|j| [1.0, 0.5][j % 2]).collect();
        let ones = vec![1.0; 41];
        assert_eq!(graded_masses(&cells, &ones), None);
        let taper: Vec<f64> = (0..41).map(|j| 1.01f64.powi(j)).collect();
        assert_eq!(graded_masses(&taper, &ones), Some(taper.clone()));
        assert_eq!(graded_masses(&ones, &taper), Some(ones.clone()));
    }
}
