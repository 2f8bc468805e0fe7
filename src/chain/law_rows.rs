//! Contact laws of many contacts at once.

use super::law::Law;
use crate::numeric::lanes::{Lanes, Number, SimdKernel, widest};

impl Law {
    /// Forces and energies of many contacts at these overlaps beyond the static ones, if any.
    pub(crate) fn forces_and_energies(
        &self,
        [coefficient, r]: [&[f64]; 2],
        static_overlap: Option<&[f64]>,
        [force, energy]: [&mut [f64]; 2],
    ) {
        if matches!(self, Law::Hertz) && static_overlap.is_none() {
            return widest(HertzEnergies {
                contacts: [coefficient, r],
                out: [force, energy],
            });
        }
        let out = force.iter_mut().zip(energy);
        let contacts = coefficient.iter().zip(r).enumerate();
        for ((force, energy), (i, (&c, &r))) in out.zip(contacts) {
            let d0 = static_overlap.map_or(0.0, |d0| d0[i]);
            *force = self.force(c, d0, r);
            *energy = self.energy(c, d0, r);
        }
    }

    /// [`Law::root_energy`] of many contacts.
    pub(crate) fn root_energies(
        &self,
        [coefficient, r]: [&[f64]; 2],
        static_overlap: Option<&[f64]>,
        [phi, slope]: [&mut [f64]; 2],
    ) {
        if matches!(self, Law::Hertz) && static_overlap.is_none() {
            return widest(HertzRoots {
                contacts: [coefficient, r],
                out: [phi, slope],
            });
        }
        let out = phi.iter_mut().zip(slope);
        let contacts = coefficient.iter().zip(r).enumerate();
        for ((phi, slope), (i, (&c, &r))) in out.zip(contacts) {
            let d0 = static_overlap.map_or(0.0, |d0| d0[i]);
            (*phi, *slope) = self.root_energy(c, d0, r);
        }
    }
}

/// [`Law::forces_and_energies`] of Hertz contacts that just touch.
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

/// [`Law::root_energies`] of Hertz contacts that just touch.
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
    use super::*;

    /// Rows against contacts one by one, which differ in the order of their factors alone.
    #[test]
    fn val_rows_equal_contacts_one_by_one() {
        let r: Vec<f64> = (0..19).map(|i| 0.3 * (1.7 * f64::from(i)).sin()).collect();
        let c: Vec<f64> = (0..19).map(|i| 1.0 + 0.2 * f64::from(i)).collect();
        let (mut a, mut b) = (vec![0.0; 19], vec![0.0; 19]);
        for law in [Law::Hertz, Law::Power { exponent: 2.5 }] {
            for d0 in [0.0, 0.2] {
                let row = [d0; 19];
                let pressed = (d0 > 0.0).then_some(&row[..]);
                let close = |found: f64, expected: f64| {
                    assert!(
                        (found - expected).abs() <= 1e-15 * expected.abs(),
                        "{law:?}"
                    );
                };
                law.forces_and_energies([&c, &r], pressed, [&mut a, &mut b]);
                for i in 0..19 {
                    close(a[i], law.force(c[i], d0, r[i]));
                    close(b[i], law.energy(c[i], d0, r[i]));
                }
                law.root_energies([&c, &r], pressed, [&mut a, &mut b]);
                for i in 0..19 {
                    let (phi, slope) = law.root_energy(c[i], d0, r[i]);
                    close(a[i], phi);
                    close(b[i], slope);
                }
            }
        }
    }
}
