//! Chains whose masses differ along x.

/// Bodies on each side over which the speed of a front is taken.
const BESIDE: usize = 8;

/// By what `v^2` of a body counts, one number a site: `m_j c_j`, c the speed of the front in bodies a sample. A front that keeps
/// its energy while masses and speeds change has the same sum of it over time at all bodies.
pub(super) fn weights(
    masses: &[f64],
    sites: &[usize],
    arrival: &dyn Fn(usize) -> usize,
) -> Vec<f64> {
    if sites.len() < 2 {
        return vec![1.0; masses.len()];
    }
    let mut all = vec![1.0; masses.len()];
    let mut sum = 0.0;
    for (i, &site) in sites.iter().enumerate() {
        let around = [i.saturating_sub(BESIDE), (i + BESIDE).min(sites.len() - 1)];
        let [a, b] = around.map(|i| sites[i]);
        let passes = arrival(b) as f64 - arrival(a) as f64;
        let speed = (b - a) as f64 / passes.abs().max(1.0);
        all[site] = masses[site] * speed;
        sum += all[site];
    }
    let mean = sum / sites.len() as f64;
    for &site in sites {
        all[site] /= mean;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of masses that fall to a quarter while the front becomes twice as fast, half.
    #[test]
    fn val_masses_count_with_the_speed_of_the_front() {
        let sites: Vec<usize> = (1..40).collect();
        let masses: Vec<f64> = (0..41).map(|j| if j < 20 { 1.0 } else { 0.25 }).collect();
        let arrival = |j: usize| 10 * j.min(20) + 5 * j.saturating_sub(20);
        let found = weights(&masses, &sites, &arrival);
        assert!((found[35] / found[5] - 0.5).abs() < 1e-12, "{found:?}");
    }
}
