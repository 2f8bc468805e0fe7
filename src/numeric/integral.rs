//! Integrals of functions of one variable, to rounding.

/// Nodes of Kronrod's rule on -1..1 from the middle on, with its weights and those of Gauss's rule within it.
///
/// Source: R. Piessens et al., *QUADPACK* (1983), rule 7-15.
const RULE: [[f64; 3]; 8] = [
    [0.0, 0.209_482_141_084_727_83, 0.417_959_183_673_469_4],
    [0.207_784_955_007_898_47, 0.204_432_940_075_298_9, 0.0],
    [
        0.405_845_151_377_397_2,
        0.190_350_578_064_785_42,
        0.381_830_050_505_118_9,
    ],
    [0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0],
    [
        0.741_531_185_599_394_4,
        0.140_653_259_715_525_92,
        0.279_705_391_489_276_64,
    ],
    [0.864_864_423_359_769_1, 0.104_790_010_322_250_19, 0.0],
    [
        0.949_107_912_342_758_5,
        0.063_092_092_629_978_56,
        0.129_484_966_168_869_7,
    ],
    [0.991_455_371_120_812_6, 0.022_935_322_010_529_224, 0.0],
];

/// By how much a half must be known better than the whole, else what is left is noise of the function, if it is below this
/// many tolerances: of a function with many turns the first halves are known no better, either.
const GAIN: f64 = 0.45;
const NOISE: f64 = 1e6;

/// Halves that are made at most; an integral that needs more is not a number.
const MOST: u32 = 4096;

/// The integral over `from..to` of a function that is smooth between these breaks, in the order from `from` to `to`.
pub(crate) fn integral(from: f64, to: f64, breaks: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    let ends = breaks.iter().copied().chain([to]);
    let mut start = from;
    ends.map(|end| {
        let whole = rule([start, end], &f);
        let mut search = Search {
            f: &f,
            tolerance: 4.0 * f64::EPSILON * whole[2],
            left: MOST,
        };
        let piece = search.adapted([start, end], whole, f64::INFINITY);
        start = end;
        piece
    })
    .sum()
}

struct Search<'f, F> {
    f: &'f F,
    tolerance: f64,
    left: u32,
}

impl<F: Fn(f64) -> f64> Search<'_, F> {
    /// By halves until the difference of both rules is below the tolerance.
    fn adapted(&mut self, [from, to]: [f64; 2], [value, error, _]: [f64; 3], before: f64) -> f64 {
        let is_noise = error >= GAIN * before && error < NOISE * self.tolerance;
        if !error.is_finite() || error <= self.tolerance || is_noise {
            return value;
        }
        let Some(left) = self.left.checked_sub(1) else {
            return f64::NAN;
        };
        self.left = left;
        let middle = 0.5 * (from + to);
        let mut half = |ends| self.adapted(ends, rule(ends, self.f), error);
        half([from, middle]) + half([middle, to])
    }
}

/// The integral by Kronrod's rule, how far Gauss's is from it, and the integral of the magnitude.
fn rule([from, to]: [f64; 2], f: &impl Fn(f64) -> f64) -> [f64; 3] {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let [mut value, mut coarse, mut size] = [0.0; 3];
    for [node, fine, gauss] in RULE {
        let sides: &[f64] = if node == 0.0 { &[0.0] } else { &[-1.0, 1.0] };
        for side in sides {
            let here = f(middle + side * node * half);
            value += fine * here;
            coarse += gauss * here;
            size += fine * here.abs();
        }
    }
    [
        half * value,
        (half * (value - coarse)).abs(),
        (half * size).abs(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smooth, steep, with a kink, with a root at an end, and with many turns.
    #[test]
    fn val_closed_form_integrals_to_rounding() {
        let close = |found: f64, known: f64| {
            assert!((found / known - 1.0).abs() < 1e-15 * 4.0, "{found} {known}")
        };
        close(integral(0.0, 2.0, &[], f64::exp), 2.0f64.exp_m1());
        close(integral(0.0, -0.9, &[], |x| (1.0 + x).powi(-3)), -49.5);
        close(integral(0.0, 1.0, &[0.3], |x| x.min(0.3)), 0.255);
        close(integral(0.0, 4.0, &[], |x| x * x.sqrt()), 12.8);
        let squares = 100.0 - 400.0f64.sin() / 4.0;
        close(integral(0.0, 200.0, &[], |x| x.sin().powi(2)), squares);
        assert!(integral(0.0, 1.0, &[], |x| (1e9 * x).sin()).is_nan());
    }
}
