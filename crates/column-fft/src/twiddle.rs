//! Twiddle factors to little more than half a unit in the last place.

/// `cos(2 pi p / q)` and `sin(2 pi p / q)`: the angle is reduced to an eighth of a cycle in integers and
/// kept in twice the precision. `q` is at least 1 and at most `2^53`.
///
/// Quarter cycles are exact, and the symmetries of cosine and sine hold bit for bit.
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
