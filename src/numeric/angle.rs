//! Cosines of rational parts of a turn.

use std::f64::consts::PI;

/// `cos(2 pi p / q)`, reduced to an eighth of a cycle in integers.
///
/// Quarter cycles are exact, and the symmetries of the cosine hold bit for bit. `q` is at least 1
/// and at most `2^60`.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact_and_symmetries_hold_bitwise() {
        for q in 1..200 {
            assert_eq!(cos_turns(0, q), 1.0);
            for p in 0..=q {
                assert_eq!(cos_turns(p, q), cos_turns(q - p, q));
                assert_eq!(cos_turns(p, 2 * q), -cos_turns(q - p, 2 * q));
                assert_eq!(cos_turns(3 * p, 3 * q), cos_turns(p, q));
            }
            assert_eq!(cos_turns(q, 4 * q), 0.0);
        }
        for p in 0..4096 {
            let angle = 2.0 * PI * (p as f64 / 4096.0);
            assert!((cos_turns(p, 4096) - angle.cos()).abs() < 7e-16);
        }
    }
}
