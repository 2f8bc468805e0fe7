//! Many Hertz contacts at once.

use crate::numeric::lanes::{Lanes, Number, SimdKernel, widest};

/// Forces and energies of Hertz contacts that just touch, from coefficients and overlaps.
pub(crate) fn hertz_energies(contacts: [&[f64]; 2], out: [&mut [f64]; 2]) {
    widest(HertzEnergies { contacts, out });
}

/// The roots of their energies and the slopes of these, as [`root_energy`](super::Law::root_energy).
pub(crate) fn hertz_roots(contacts: [&[f64]; 2], out: [&mut [f64]; 2]) {
    widest(HertzRoots { contacts, out });
}

struct HertzEnergies<'a> {
    /// Coefficients and overlaps.
    contacts: [&'a [f64]; 2],
    out: [&'a mut [f64]; 2],
}

impl SimdKernel for HertzEnergies<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let ([c, r], [force, energy]) = (self.contacts, self.out);
        for ((force, energy), (c, r)) in force.iter_mut().zip(energy).zip(c.iter().zip(r)) {
            let d = r.positive();
            *force = c * (d * d.sqrt());
            *energy = 0.4 * *force * d;
        }
    }
}

struct HertzRoots<'a> {
    /// Coefficients and overlaps.
    contacts: [&'a [f64]; 2],
    out: [&'a mut [f64]; 2],
}

impl SimdKernel for HertzRoots<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let ([c, r], [phi, slope]) = (self.contacts, self.out);
        let (a, b) = (0.4f64.sqrt(), 0.5 * 2.5f64.sqrt());
        for ((phi, slope), (c, r)) in phi.iter_mut().zip(slope).zip(c.iter().zip(r)) {
            let d = r.positive();
            let root = c.sqrt() * d.sqrt().sqrt();
            *phi = a * (d * root);
            *slope = b * root;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Law;
    use super::*;

    /// Rows against contacts one by one, which differ in the order of their factors alone.
    #[test]
    fn val_rows_equal_contacts_one_by_one() {
        let r: Vec<f64> = (0..19).map(|i| 0.3 * (1.7 * f64::from(i)).sin()).collect();
        let c: Vec<f64> = (0..19).map(|i| 1.0 + 0.2 * f64::from(i)).collect();
        let (mut a, mut b) = (vec![0.0; 19], vec![0.0; 19]);
        let close = |found: f64, expected: f64| {
            assert!((found - expected).abs() <= 1e-15 * expected.abs());
        };
        hertz_energies([&c, &r], [&mut a, &mut b]);
        for i in 0..19 {
            close(a[i], Law::Hertz.force(c[i], 0.0, r[i]));
            close(b[i], Law::Hertz.energy(c[i], 0.0, r[i]));
        }
        hertz_roots([&c, &r], [&mut a, &mut b]);
        for i in 0..19 {
            let (phi, slope) = Law::Hertz.root_energy(c[i], 0.0, r[i]);
            close(a[i], phi);
            close(b[i], slope);
        }
    }
}
