//! Direct sums in twice the precision, to judge fast transforms by.

use num_complex::Complex;

/// Samples between twiddles that are computed anew.
const ANCHOR: usize = 256;

/// `sum_n x_n exp(-2 pi i m n / N)` for each bin m, in double-double arithmetic, rounded once at
/// the end: good to half an ulp unless the sum cancels beyond 1e-15 of its terms.
///
/// Takes `x.len()` complex products a bin, so it suits spot checks and tests.
pub fn direct_sums(x: &[f64], bins: &[usize]) -> Vec<Complex<f64>> {
    bins.iter().map(|&bin| direct_sum(x, bin)).collect()
}

fn direct_sum(x: &[f64], bin: usize) -> Complex<f64> {
    let n = x.len();
    let (mut re, mut im) = (Dd::from(0.0), Dd::from(0.0));
    let step = |at: usize| {
        // The phase is reduced in integers wide enough for any length.
        let phase = (at as u128 * bin as u128 % n as u128) as usize;
        cos_sin_turns(phase, n)
    };
    let (turn_cos, turn_sin) = if n > 0 {
        step(1)
    } else {
        return Complex::default();
    };
    for (i, piece) in x.chunks(ANCHOR).enumerate() {
        let (mut cos, mut sin) = step(i * ANCHOR);
        for &value in piece {
            let value = Dd::from(value);
            re = re.plus(cos.times(value));
            im = im.plus(sin.times(value).negated());
            let next = cos.times(turn_cos).plus(sin.times(turn_sin).negated());
            sin = sin.times(turn_cos).plus(cos.times(turn_sin));
            cos = next;
        }
    }
    Complex::new(re.high, im.high)
}

/// `high + low`, an unevaluated sum with `|low| <= ulp(high) / 2`.
///
/// Source: Dekker, Numer. Math. 18, 224 (1971); Joldes, Muller and Popescu, ACM TOMS 44, 15 (2017).
#[derive(Debug, Clone, Copy)]
struct Dd {
    high: f64,
    low: f64,
}

const TWO_PI: Dd = Dd {
    high: std::f64::consts::TAU,
    low: 2.4492935982947064e-16,
};

impl From<f64> for Dd {
    fn from(high: f64) -> Self {
        Dd { high, low: 0.0 }
    }
}

impl Dd {
    fn plus(self, other: Dd) -> Dd {
        let (high, low) = two_sum(self.high, other.high);
        let (tail, rest) = two_sum(self.low, other.low);
        let (high, low) = fast_two_sum(high, low + tail);
        let (high, low) = fast_two_sum(high, low + rest);
        Dd { high, low }
    }

    fn times(self, other: Dd) -> Dd {
        let (high, error) = two_product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        let (high, low) = fast_two_sum(high, error + cross);
        Dd { high, low }
    }

    fn over(self, divisor: f64) -> Dd {
        let quotient = self.high / divisor;
        let (back, error) = two_product(quotient, divisor);
        let rest = ((self.high - back) - error) + self.low;
        let (high, low) = fast_two_sum(quotient, rest / divisor);
        Dd { high, low }
    }

    fn negated(self) -> Dd {
        Dd {
            high: -self.high,
            low: -self.low,
        }
    }
}

fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// Dekker's product: exact, and faster than a fused multiply-add that has to be emulated.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let split = |x: f64| {
        let scaled = 134_217_729.0 * x; // 2^27 + 1
        let high = scaled - (scaled - x);
        (high, x - high)
    };
    let product = a * b;
    let ((a1, a2), (b1, b2)) = (split(a), split(b));
    (
        product,
        a2 * b2 - (((product - a1 * b1) - a2 * b1) - a1 * b2),
    )
}

fn fast_two_sum(large: f64, small: f64) -> (f64, f64) {
    let sum = large + small;
    (sum, small - (sum - large))
}

/// `cos(2 pi p / q)` and `sin(2 pi p / q)`, `p < q`, reduced to an eighth of a turn in integers.
fn cos_sin_turns(p: usize, q: usize) -> (Dd, Dd) {
    if 2 * p > q {
        let (cos, sin) = cos_sin_turns(q - p, q);
        (cos, sin.negated())
    } else if 4 * p > q {
        let (cos, sin) = cos_sin_turns(q - 2 * p, 2 * q);
        (cos.negated(), sin)
    } else if 8 * p > q {
        let (cos, sin) = cos_sin_turns(q - 4 * p, 4 * q);
        (sin, cos)
    } else {
        let angle = TWO_PI.times(Dd::from(p as f64)).over(q as f64);
        (taylor(angle, 0), taylor(angle, 1))
    }
}

/// `sum_k (-1)^k a^(2k + odd) / (2k + odd)!` by Horner's rule, for `a <= pi / 4`.
fn taylor(angle: Dd, odd: usize) -> Dd {
    let square = angle.times(angle).negated();
    let mut sum = Dd::from(1.0);
    for k in (1..=14).rev() {
        let degree = 2 * k + odd;
        let factor = square.over((degree * (degree - 1)) as f64);
        sum = sum.times(factor).plus(Dd::from(1.0));
    }
    if odd == 1 { sum.times(angle) } else { sum }
}
