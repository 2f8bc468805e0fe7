//! Random columns, their transforms, and sums by the definition in twice the precision, to judge transforms by.

// Each test uses a part of this.
#![allow(dead_code)]

use column_fft::{InstructionSet, Real, RealToComplexColumns};
use ndarray::{Array2, ArrayView2};
use num_complex::Complex;

/// Bins that are summed together.
const LANES: usize = 8;

/// Samples between twiddle factors that are computed anew.
const ANCHOR: usize = 256;

/// `|z|^2`.
pub fn power(z: Complex<f64>) -> f64 {
    z.re * z.re + z.im * z.im
}

/// Uniform in -1/2 .. 1/2.
pub fn noise<T: Real>(shape: (usize, usize), mut state: u64) -> Array2<T> {
    Array2::from_shape_simple_fn(shape, || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        T::rounded((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
    })
}

/// A plan of each instruction set that the processor has.
pub fn plans<T: Real>(length: usize) -> impl Iterator<Item = RealToComplexColumns<T>> {
    let sets = InstructionSet::available().into_iter();
    sets.map(move |set| RealToComplexColumns::with_instruction_set(length, set).unwrap())
}

/// Spectra of columns, by buffers of exactly the size that is needed.
pub fn spectra<T: Real>(
    plan: &RealToComplexColumns<T>,
    values: ArrayView2<T>,
) -> Array2<Complex<T>> {
    let columns = values.ncols();
    let mut spectra = Array2::default((plan.bins(), columns));
    plan.process_with_scratch(values, spectra.view_mut(), &mut plan.make_scratch(columns))
        .unwrap();
    spectra
}

pub fn double<T: Real>(z: Complex<T>) -> Complex<f64> {
    Complex::new(z.re.to_f64(), z.im.to_f64())
}

/// Root mean square difference, relative to the root mean square of the second.
pub fn apart<'a, T: Real>(
    found: impl IntoIterator<Item = &'a Complex<T>>,
    truth: impl IntoIterator<Item = Complex<f64>>,
) -> f64 {
    let pairs = found.into_iter().zip(truth);
    let (off, all) = pairs.fold((0.0, 0.0), |(off, all), (f, t)| {
        (off + power(double(*f) - t), all + power(t))
    });
    (off / all).sqrt()
}

/// `sum_n x_n exp(-2 pi i m n / N)` for each bin m, in double-double arithmetic, rounded once at the end.
pub fn direct_sums(x: &[f64], bins: &[usize]) -> Vec<Complex<f64>> {
    bins.chunks(LANES).flat_map(|bins| sums(x, bins)).collect()
}

fn sums(x: &[f64], bins: &[usize]) -> Vec<Complex<f64>> {
    let n = x.len();
    let roots = |at: usize| {
        let (mut cos, mut sin) = (Dd::default(), Dd::default());
        for (l, &bin) in bins.iter().enumerate() {
            let phase = (at as u128 * bin as u128 % n as u128) as usize;
            let (c, s) = cos_sin(phase, n);
            (cos.0[l], cos.1[l]) = c;
            (sin.0[l], sin.1[l]) = s;
        }
        (cos, sin)
    };
    let (mut re, mut im) = (Dd::default(), Dd::default());
    let (step_cos, step_sin) = roots(1 % n);
    for (i, piece) in x.chunks(ANCHOR).enumerate() {
        let (mut cos, mut sin) = roots(i * ANCHOR);
        for &value in piece {
            let value = Dd([value; LANES], [0.0; LANES]);
            re = re.plus(cos.times(value));
            im = im.plus(sin.times(value).negated());
            let next = cos.times(step_cos).plus(sin.times(step_sin).negated());
            sin = sin.times(step_cos).plus(cos.times(step_sin));
            cos = next;
        }
    }
    (0..bins.len())
        .map(|l| Complex::new(re.0[l], im.0[l]))
        .collect()
}

/// Unevaluated sums of a high and a low part.
///
/// Source: Dekker, Numer. Math. 18, 224 (1971); Joldes, Muller and Popescu, ACM TOMS 44, 15 (2017).
#[derive(Debug, Clone, Copy, Default)]
struct Dd([f64; LANES], [f64; LANES]);

type Pair = (f64, f64);

impl Dd {
    #[inline(always)]
    fn by_lane(self, other: Dd, of: impl Fn(Pair, Pair) -> Pair) -> Dd {
        let mut result = Dd::default();
        for l in 0..LANES {
            (result.0[l], result.1[l]) = of((self.0[l], self.1[l]), (other.0[l], other.1[l]));
        }
        result
    }

    #[inline(always)]
    fn plus(self, other: Dd) -> Dd {
        self.by_lane(other, plus)
    }

    #[inline(always)]
    fn times(self, other: Dd) -> Dd {
        self.by_lane(other, times)
    }

    #[inline(always)]
    fn negated(self) -> Dd {
        self.by_lane(self, |(high, low), _| (-high, -low))
    }
}

#[inline(always)]
fn two_sum(a: f64, b: f64) -> Pair {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

#[inline(always)]
fn fast_two_sum(large: f64, small: f64) -> Pair {
    let sum = large + small;
    (sum, small - (sum - large))
}

/// Dekker's product: exact.
#[inline(always)]
fn two_product(a: f64, b: f64) -> Pair {
    let split = |x: f64| {
        let scaled = 134_217_729.0 * x; // 2^27 + 1
        let high = scaled - (scaled - x);
        (high, x - high)
    };
    let product = a * b;
    let ((a1, a2), (b1, b2)) = (split(a), split(b));
    let error = a2 * b2 - (((product - a1 * b1) - a2 * b1) - a1 * b2);
    (product, error)
}

#[inline(always)]
fn plus(a: Pair, b: Pair) -> Pair {
    let (high, low) = two_sum(a.0, b.0);
    let (tail, rest) = two_sum(a.1, b.1);
    let (high, low) = fast_two_sum(high, low + tail);
    fast_two_sum(high, low + rest)
}

#[inline(always)]
fn times(a: Pair, b: Pair) -> Pair {
    let (high, error) = two_product(a.0, b.0);
    fast_two_sum(high, error + (a.0 * b.1 + a.1 * b.0))
}

fn over(a: Pair, divisor: f64) -> Pair {
    let quotient = a.0 / divisor;
    let (back, error) = two_product(quotient, divisor);
    let rest = ((a.0 - back) - error) + a.1;
    fast_two_sum(quotient, rest / divisor)
}

fn negated((high, low): Pair) -> Pair {
    (-high, -low)
}

/// `cos(2 pi p / q)` and `sin(2 pi p / q)`, `p < q`, reduced to an eighth of a cycle in integers.
fn cos_sin(p: usize, q: usize) -> (Pair, Pair) {
    if 2 * p > q {
        let (cos, sin) = cos_sin(q - p, q);
        (cos, negated(sin))
    } else if 4 * p > q {
        let (cos, sin) = cos_sin(q - 2 * p, 2 * q);
        (negated(cos), sin)
    } else if 8 * p > q {
        let (cos, sin) = cos_sin(q - 4 * p, 4 * q);
        (sin, cos)
    } else {
        let two_pi = (std::f64::consts::TAU, 2.449_293_598_294_706_4e-16);
        let angle = over(times(two_pi, (p as f64, 0.0)), q as f64);
        (taylor(angle, 0), taylor(angle, 1))
    }
}

/// `sum_k (-1)^k a^(2k + odd) / (2k + odd)!` by Horner's rule, for `a <= pi / 4`.
fn taylor(angle: Pair, odd: usize) -> Pair {
    let square = negated(times(angle, angle));
    let mut sum = (1.0, 0.0);
    for k in (1..=14).rev() {
        let degree = 2 * k + odd;
        let factor = over(square, (degree * (degree - 1)) as f64);
        sum = plus(times(sum, factor), (1.0, 0.0));
    }
    if odd == 1 { times(sum, angle) } else { sum }
}
