//! Random columns, their transforms, and sums by the definition in integers, to judge transforms by.

// Each test uses a part of this.
#![allow(dead_code)]

use column_fft::{InstructionSet, Real, RealToComplexColumns, ShortTimeColumns};
use ndarray::{Array2, Array3, ArrayView2};
use num_complex::Complex;

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

/// Segments that follow each other by so much, weighed by square roots.
pub fn short_time<T: Real>(length: usize, hop: usize) -> ShortTimeColumns<T> {
    let window: Vec<f64> = (1..=length).map(|n| (n as f64).sqrt()).collect();
    ShortTimeColumns::new(&window, hop).unwrap()
}

/// Spectra of segments of columns.
pub fn segments<T: Real>(plan: &ShortTimeColumns<T>, values: ArrayView2<T>) -> Array3<Complex<T>> {
    let (times, columns) = values.dim();
    let mut found = Array3::default((plan.segments(times), plan.bins(), columns));
    plan.process_in_parallel(values, found.view_mut()).unwrap();
    found
}

/// Runs by so many threads.
pub fn by_threads<R: Send>(threads: usize, run: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().unwrap().install(run)
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

/// Complex numbers of 60 binary places, real part first.
type Fixed = [i128; 2];

const ONE: i128 = 1 << 60;

/// `2 pi`.
const TURN: i128 = 7_244_019_458_077_122_842;

/// Samples that are summed before their sum is turned: few enough that no product overflows.
const PIECE: usize = 128;

fn times(a: i128, b: i128) -> i128 {
    (a * b + ONE / 2) >> 60
}

fn product([a, b]: Fixed, [c, d]: Fixed) -> Fixed {
    [times(a, c) - times(b, d), times(a, d) + times(b, c)]
}

/// `exp(2 pi i p / q)`, `p < q`: the series of a quarter of the angle, squared twice.
fn root(p: usize, q: usize) -> Fixed {
    let [p, q] = [p as i128, q as i128];
    let p = if 2 * p > q { p - q } else { p };
    let angle = TURN * p / (4 * q);
    let mut sum = [ONE, 0];
    for k in (1..=21).rev() {
        sum = [ONE - times(angle, sum[1]) / k, times(angle, sum[0]) / k];
    }
    let half = product(sum, sum);
    product(half, half)
}

/// `sum_n x_n exp(-2 pi i m n / N)` for each bin m, of samples below 1 in size: to 2^-57 of its root mean square over bins,
/// by integers, rounded once at the end.
pub fn direct_sums(x: &[f64], bins: &[usize]) -> Vec<Complex<f64>> {
    let sum = |&bin: &usize| {
        let root_at = |n: usize| root(n * bin % x.len(), x.len());
        let roots: Vec<Fixed> = (0..PIECE).map(root_at).collect();
        let mut sum = [0; 2];
        for (i, piece) in x.chunks(PIECE).enumerate() {
            let mut part = [0; 2];
            for (value, root) in piece.iter().zip(&roots) {
                let value = (value * ONE as f64) as i128;
                part = [0, 1].map(|i| part[i] + times(value, root[i]));
            }
            let part = product(part, root_at(i * PIECE));
            sum = [sum[0] + part[0], sum[1] + part[1]];
        }
        Complex::new(sum[0] as f64, -sum[1] as f64) / ONE as f64
    };
    bins.iter().map(sum).collect()
}
