//! Direct sums in twice the precision, to judge fast transforms by.

use num_complex::Complex;

use crate::numeric::lanes::{LaneBlock, Lanes, Number, SimdKernel, WIDTH, widest};

/// Samples between twiddles that are computed anew.
const ANCHOR: usize = 256;

/// `sum_n x_n exp(-2 pi i m n / N)` for each bin m, in double-double arithmetic, rounded once at
/// the end: good to half an ulp unless the sum cancels beyond 1e-15 of its terms.
///
/// Costs `x.len()` complex products per bin (eight bins in one vector), so it suits spot checks and
/// tests.
pub fn direct_sums(x: &[f64], bins: &[usize]) -> Vec<Complex<f64>> {
    let together = bins.chunks(WIDTH);
    let sums = together.flat_map(|bins| {
        let [re, im] = widest(DirectSums { x, bins });
        (0..bins.len()).map(move |l| Complex::new(re.0[l], im.0[l]))
    });
    sums.collect()
}

/// Of up to eight bins.
struct DirectSums<'a> {
    x: &'a [f64],
    bins: &'a [usize],
}

impl SimdKernel for DirectSums<'_> {
    type Output = [LaneBlock; 2];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [LaneBlock; 2] {
        let n = self.x.len();
        let mut sums = [LaneBlock::default(); 2];
        if n == 0 {
            return sums;
        }
        let turns = |at: usize| {
            // [cos, sin][high, low] of each bin.
            let mut turns = [[LaneBlock::default(); 2]; 2];
            for (l, &bin) in self.bins.iter().enumerate() {
                // The phase is reduced in integers wide enough for any length.
                let phase = (at as u128 * bin as u128 % n as u128) as usize;
                let (cos, sin) = cos_sin_turns(phase, n);
                for (to, from) in turns.iter_mut().zip([cos, sin]) {
                    (to[0].0[l], to[1].0[l]) = (from.high, from.low);
                }
            }
            turns.map(|[high, low]| Dd {
                high: L::load(&high),
                low: L::load(&low),
            })
        };
        let (mut re, mut im) = (Dd::<L>::from_f64(0.0), Dd::<L>::from_f64(0.0));
        let [turn_cos, turn_sin] = turns(1);
        for (i, piece) in self.x.chunks(ANCHOR).enumerate() {
            let [mut cos, mut sin] = turns(i * ANCHOR);
            for &value in piece {
                let value = Dd::from_f64(value);
                re = re.plus(cos.times(value));
                im = im.plus(sin.times(value).negated());
                let next = cos.times(turn_cos).plus(sin.times(turn_sin).negated());
                sin = sin.times(turn_cos).plus(cos.times(turn_sin));
                cos = next;
            }
        }
        for (sum, part) in sums.iter_mut().zip([re, im]) {
            part.high.store(sum);
        }
        sums
    }
}

/// `high + low`, an unevaluated sum with `|low| <= ulp(high) / 2`; of a number, or of several side
/// by side.
///
/// Source: Dekker, Numer. Math. 18, 224 (1971); Joldes, Muller and Popescu, ACM TOMS 44, 15 (2017).
#[derive(Debug, Clone, Copy)]
struct Dd<N = f64> {
    high: N,
    low: N,
}

const TWO_PI: Dd = Dd {
    high: std::f64::consts::TAU,
    low: 2.4492935982947064e-16,
};

impl<N: Number> Dd<N> {
    #[inline(always)]
    fn from_f64(high: f64) -> Self {
        let (high, low) = (N::splat(high), N::splat(0.0));
        Dd { high, low }
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        let (high, low) = two_sum(self.high, other.high);
        let (tail, rest) = two_sum(self.low, other.low);
        let Dd { high, low } = fast_two_sum(high, low + tail);
        fast_two_sum(high, low + rest)
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        let (high, error) = two_product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        fast_two_sum(high, error + cross)
    }

    #[inline(always)]
    fn over(self, divisor: N) -> Self {
        let quotient = self.high / divisor;
        let (back, error) = two_product(quotient, divisor);
        let rest = ((self.high - back) - error) + self.low;
        fast_two_sum(quotient, rest / divisor)
    }

    #[inline(always)]
    fn negated(self) -> Self {
        let zero = N::splat(0.0);
        let (high, low) = (zero - self.high, zero - self.low);
        Dd { high, low }
    }
}

#[inline(always)]
fn two_sum<N: Number>(a: N, b: N) -> (N, N) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// Dekker's product: exact, and faster than a fused multiply-add that has to be emulated.
#[inline(always)]
fn two_product<N: Number>(a: N, b: N) -> (N, N) {
    let split = |x: N| {
        let scaled = N::splat(134_217_729.0) * x; // 2^27 + 1
        let high = scaled - (scaled - x);
        (high, x - high)
    };
    let product = a * b;
    let ((a1, a2), (b1, b2)) = (split(a), split(b));
    let error = a2 * b2 - (((product - a1 * b1) - a2 * b1) - a1 * b2);
    (product, error)
}

#[inline(always)]
fn fast_two_sum<N: Number>(large: N, small: N) -> Dd<N> {
    let high = large + small;
    let low = small - (high - large);
    Dd { high, low }
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
        let angle = TWO_PI.times(Dd::from_f64(p as f64)).over(q as f64);
        (taylor(angle, 0), taylor(angle, 1))
    }
}

/// `sum_k (-1)^k a^(2k + odd) / (2k + odd)!` by Horner's rule, for `a <= pi / 4`.
fn taylor(angle: Dd, odd: usize) -> Dd {
    let square = angle.times(angle).negated();
    let mut sum = Dd::from_f64(1.0);
    for k in (1..=14).rev() {
        let degree = 2 * k + odd;
        let factor = square.over((degree * (degree - 1)) as f64);
        sum = sum.times(factor).plus(Dd::from_f64(1.0));
    }
    if odd == 1 { sum.times(angle) } else { sum }
}
