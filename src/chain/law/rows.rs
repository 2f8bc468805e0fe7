//! Many Hertz contacts at once.

use crate::numeric::lanes::{Lanes, Number, SimdKernel, widest};

/// Forces and energies of Hertz contacts that just touch, from coefficients and overlaps.
pub(crate) fn hertz_energies(contacts: [&[f64]; 2], out: [&mut [f64]; 2]) {
    let each = |c: f64, d: f64| {
        let force = c * (d * d.sqrt());
        [force, 0.4 * force * d]
    };
    widest(Rows {
        contacts,
        out,
        each,
    });
}

/// The roots of their energies and the slopes of these, as [`root_energy`](super::Law::root_energy).
pub(crate) fn hertz_roots(contacts: [&[f64]; 2], out: [&mut [f64]; 2]) {
    let (a, b) = (0.4f64.sqrt(), 0.5 * 2.5f64.sqrt());
    let each = |c: f64, d: f64| {
        let root = c.sqrt() * d.sqrt().sqrt();
        [a * (d * root), b * root]
    };
    widest(Rows {
        contacts,
        out,
        each,
    });
}

struct Rows<'a, F> {
    /// Coefficients and overlaps.
    contacts: [&'a [f64]; 2],
    out: [&'a mut [f64]; 2],
    /// Both values of a contact, from its coefficient and its overlap where it presses.
    each: F,
}

impl<F: Fn(f64, f64) -> [f64; 2]> SimdKernel for Rows<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let ([c, r], [first, second]) = (self.contacts, self.out);
        for ((first, second), (c, r)) in first.iter_mut().zip(second).zip(c.iter().zip(r)) {
            [*first, *second] = (self.each)(*c, r.positive());
        }
    }
}
