//! Names of the bins.

use std::f64::consts::TAU;

/// Frequencies `m / (n dt)`, `m = 0 ..= n / 2`, in cycles.
pub fn frequencies(n: usize, dt: f64) -> Vec<f64> {
    let length = n as f64 * dt;
    (0..=n / 2).map(|m| m as f64 / length).collect()
}

/// Wavenumbers `2 pi m / (n dx)`, `m = 0 ..= n / 2`, in rad.
pub fn wavenumbers(n: usize, dx: f64) -> Vec<f64> {
    let length = n as f64 * dx;
    (0..=n / 2).map(|m| TAU * m as f64 / length).collect()
}

/// Wavenumbers of both signs, ascending, in rad: `m = -(n / 2) .. n - n / 2`.
pub fn wavenumbers_signed(n: usize, dx: f64) -> Vec<f64> {
    let length = n as f64 * dx;
    let lowest = -((n / 2) as i64);
    let bins = lowest..n as i64 + lowest;
    bins.map(|m| TAU * m as f64 / length).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_numpy_fftfreq_odd_and_even() {
        assert_eq!(frequencies(5, 0.5), [0.0, 0.4, 0.8]);
        assert_eq!(frequencies(4, 0.5), [0.0, 0.5, 1.0]);
        let k = wavenumbers_signed(4, TAU);
        assert_eq!(k, [-0.5, -0.25, 0.0, 0.25]);
        let k = wavenumbers_signed(5, TAU);
        assert_eq!(k, [-0.4, -0.2, 0.0, 0.2, 0.4]);
        assert_eq!(wavenumbers_signed(1, 1.0), [0.0]);
    }
}
