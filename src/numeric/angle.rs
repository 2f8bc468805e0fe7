//! Cosines and sines of rational parts of a turn.

use std::f64::consts::PI;

/// `cos(2 pi p / q)`, reduced to an eighth of a turn in integers.
///
/// Quarter turns are exact, and the symmetries of the cosine hold bit for bit.
/// `q` is at least 1 and at most `2^60`.
pub(crate) fn cos_turns(p: u64, q: u64) -> f64 {
    let p = p % q;
    let p = p.min(q - p);
    let angle = |num: u64, den: u64| PI * (num as f64 / den as f64);
    if 8 * p <= q {
        angle(2 * p, q).cos()
    } else if 4 * p <= q {
        angle(q - 4 * p, 2 * q).sin()
    } else if 8 * p < 3 * q {
        -angle(4 * p - q, 2 * q).sin()
    } else {
        -angle(q - 2 * p, q).cos()
    }
}

/// `sin(2 pi p / q)`, as [`cos_turns`] a quarter of a turn earlier; `q` is at most `2^58`.
pub(crate) fn sin_turns(p: u64, q: u64) -> f64 {
    cos_turns(4 * (p % q) + 3 * q, 4 * q)
}

/// `cos(2 pi p / q)` and `sin(2 pi p / q)` to little more than half a unit in the last place: the
/// angle is kept in twice the precision. `q` is at least 1 and at most `2^53`.
///
/// Quarter turns and the symmetries are those of [`cos_turns`].
pub(crate) fn cos_sin_exact(p: u64, q: u64) -> (f64, f64) {
    let p = p % q;
    if 2 * p > q {
        let (cos, sin) = cos_sin_exact(q - p, q);
        (cos, -sin)
    } else if 4 * p > q {
        let (cos, sin) = cos_sin_exact(q - 2 * p, 2 * q);
        (-cos, sin)
    } else if 8 * p > q {
        let (cos, sin) = cos_sin_exact(q - 4 * p, 4 * q);
        (sin, cos)
    } else {
        const TAU: f64 = std::f64::consts::TAU;
        const TAU_REST: f64 = 2.449_293_598_294_706_4e-16;
        let (p, q) = (p as f64, q as f64);
        let part = p / q;
        let part_rest = (-part).mul_add(q, p) / q;
        let angle = TAU * part;
        let rest = TAU.mul_add(part, -angle) + (TAU * part_rest + TAU_REST * part);
        let (sin, cos) = angle.sin_cos();
        (cos - rest * sin, sin + rest * cos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact_and_symmetries_hold_bitwise() {
        for q in 1..200 {
            assert_eq!(cos_turns(0, q), 1.0);
            assert_eq!(sin_turns(0, q), 0.0);
            for p in 0..=q {
                assert_eq!(cos_turns(p, q), cos_turns(q - p, q));
                assert_eq!(sin_turns(p, q), -sin_turns(q - p, q));
                assert_eq!(cos_turns(p, 2 * q), -cos_turns(q - p, 2 * q));
                assert_eq!(cos_turns(3 * p, 3 * q), cos_turns(p, q));
            }
            assert_eq!(cos_turns(q, 4 * q), 0.0);
            assert_eq!(sin_turns(q, 4 * q), 1.0);
        }
    }

    #[test]
    fn values_agree_with_the_standard_library_in_every_octant() {
        for p in 0..4096 {
            let angle = 2.0 * PI * (p as f64 / 4096.0);
            assert!((cos_turns(p, 4096) - angle.cos()).abs() < 7e-16);
            assert!((sin_turns(p, 4096) - angle.sin()).abs() < 7e-16);
        }
    }
}
