//! Golden-section search for the maximum of a function with one hump.
//!
//! Source: J. Kiefer, Proc. Amer. Math. Soc. 4, 502 (1953).

/// The interval around the maximum of `f` that is left of `ends`, no wider than `enough` unless that takes more than `most`
/// evaluations, and the better of the two points evaluated inside it.
pub(crate) fn golden_section<E>(
    [mut a, mut b]: [f64; 2],
    enough: f64,
    most: usize,
    mut f: impl FnMut(f64) -> Result<f64, E>,
) -> Result<([f64; 2], (f64, f64)), E> {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let mut at = |x: f64| Ok((x, f(x)?));
    let part = ratio * (b - a);
    let (mut c, mut d) = (at(b - part)?, at(a + part)?);
    for _ in 2..most {
        if b - a <= enough {
            break;
        }
        if c.1 > d.1 {
            b = d.0;
            (c, d) = (at(b - ratio * (b - a))?, c);
        } else {
            a = c.0;
            (c, d) = (d, at(a + ratio * (b - a))?);
        }
    }
    Ok(([a, b], if c.1 > d.1 { c } else { d }))
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    #[test]
    fn val_closed_form_maximum_of_a_parabola() {
        let f = |x: f64| Ok::<f64, Infallible>(-(x - 0.3).powi(2));
        let Ok(([a, b], _)) = golden_section([0.0, 1.0], 1e-7, usize::MAX, f);
        assert!(a <= 0.3 && 0.3 <= b && b - a > 5e-8);
    }
}
