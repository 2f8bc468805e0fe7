//! What several tests share: a transform in twice the precision, to judge the fast ones by.

/// `(sum_n x_n cos(2 pi p n / N), -sum_n x_n sin(2 pi p n / N))` for each bin p, in double-double
/// arithmetic, rounded once at the end: good to half an ulp unless the sum cancels beyond 1e-15.
pub fn dft_dd(x: &[f64], bins: &[usize]) -> Vec<(f64, f64)> {
    let n = x.len();
    let twiddles: Vec<(Dd, Dd)> = (0..n).map(|p| cos_sin_turns(p, n)).collect();
    let transform = |&bin: &usize| {
        let (mut re, mut im) = (Dd::from(0.0), Dd::from(0.0));
        let mut phase = 0;
        for &value in x {
            let (cos, sin) = twiddles[phase];
            re = re.plus(cos.times(Dd::from(value)));
            im = im.plus(sin.times(Dd::from(-value)));
            phase = (phase + bin) % n;
        }
        (re.high, im.high)
    };
    bins.iter().map(transform).collect()
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
        let high = self.high * other.high;
        let error = self.high.mul_add(other.high, -high);
        let cross = self.high.mul_add(other.low, self.low * other.high);
        let (high, low) = fast_two_sum(high, error + cross);
        Dd { high, low }
    }

    fn over(self, divisor: f64) -> Dd {
        let quotient = self.high / divisor;
        let rest = (-quotient).mul_add(divisor, self.high) + self.low;
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
