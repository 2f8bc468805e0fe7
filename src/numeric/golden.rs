//! Golden-section search for the maximum of a function with one hump.
//!
//! Source: J. Kiefer, Proc. Amer. Math. Soc. 4, 502 (1953).

/// An interval that holds the maximum, and the values at two points inside it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GoldenSection<V> {
    pub(crate) ends: [f64; 2],
    pub(crate) inner: [(f64, V); 2],
}

fn ratio() -> f64 {
    0.5 * (5f64.sqrt() - 1.0)
}

impl<V: Copy> GoldenSection<V> {
    /// Evaluates `f` at the two inner points of an interval.
    pub(crate) fn new<E>(
        [a, b]: [f64; 2],
        mut f: impl FnMut(f64) -> Result<V, E>,
    ) -> Result<Self, E> {
        let part = ratio() * (b - a);
        let (c, d) = (b - part, a + part);
        Ok(GoldenSection {
            ends: [a, b],
            inner: [(c, f(c)?), (d, f(d)?)],
        })
    }

    pub(crate) fn width(&self) -> f64 {
        self.ends[1] - self.ends[0]
    }

    /// Drops the part of the interval beyond the worse inner point.
    pub(crate) fn narrow<E>(
        &mut self,
        first_is_better: bool,
        mut f: impl FnMut(f64) -> Result<V, E>,
    ) -> Result<(), E> {
        let [c, d] = self.inner;
        if first_is_better {
            self.ends[1] = d.0;
            let x = self.ends[1] - ratio() * self.width();
            self.inner = [(x, f(x)?), c];
        } else {
            self.ends[0] = c.0;
            let x = self.ends[0] + ratio() * self.width();
            self.inner = [d, (x, f(x)?)];
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    #[test]
    fn val_closed_form_maximum_of_a_parabola() {
        let f = |x: f64| Ok::<f64, Infallible>(-(x - 0.3).powi(2));
        let Ok(mut search) = GoldenSection::new([0.0, 1.0], f);
        while search.width() > 1e-7 {
            let [c, d] = search.inner;
            let Ok(()) = search.narrow(c.1 > d.1, f);
        }
        let [a, b] = search.ends;
        assert!(a <= 0.3 && 0.3 <= b && search.width() > 5e-8);
    }
}
