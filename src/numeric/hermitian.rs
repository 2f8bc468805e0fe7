//! Eigenvalues and eigenvectors of small Hermitian matrices.

use ndarray::Array2;
use num_complex::Complex;

use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, WIDTH, widest};

/// Eigenvalues, descending, with the eigenvectors as rows.
pub(crate) struct Eigen {
    pub values: Vec<f64>,
    pub vectors: Vec<Vec<Complex<f64>>>,
}

/// Steps of the QL iteration an eigenvalue; two or three are usual.
const STEPS: usize = 60;
/// Off-diagonal elements below this share of the trace are rounding.
const FLOOR: f64 = 1e-3 * f64::EPSILON;

/// The eigenvalues of a positive semidefinite Hermitian matrix, of which the lower triangle is read, to a
/// few times the rounding of its trace, and its eigenvectors, of unit length.
///
/// Reduced to a real tridiagonal matrix by reflections, then diagonalized by implicit QL steps. Cost: `4/3
/// n^3` complex operations for the values, three times that with the vectors.
///
/// Source: R. S. Martin, C. Reinsch, J. H. Wilkinson, Numer. Math. 11, 181 (1968); A. Dubrulle, R. S. Martin,
/// J. H. Wilkinson, Numer. Math. 12, 377 (1968).
pub(crate) fn eigen(matrix: &Array2<Complex<f64>>) -> Eigen {
    let n = matrix.nrows();
    let reduced = [Reduced::of(matrix)];
    let unit = |i: usize| (0..n).map(|j| f64::from(i == j)).collect();
    let mut rows: Vec<Vec<f64>> = (0..n).map(unit).collect();
    let diagonal = diagonalized(&reduced, &mut rows);
    let [reduced] = reduced;
    let value = |i: &usize| diagonal[*i].0[0];
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| value(b).total_cmp(&value(a)));
    Eigen {
        values: order.iter().map(|i| value(i) * reduced.scale).collect(),
        vectors: order.iter().map(|i| reduced.back(&rows[*i])).collect(),
    }
}

/// The eigenvalues, descending, of up to eight matrices of the same order as those of [`eigen`]; those of one do not
/// depend on the others.
pub(crate) fn eigenvalues(matrices: &[Array2<Complex<f64>>]) -> Vec<Vec<f64>> {
    let reduced: Vec<Reduced> = matrices.iter().map(Reduced::of).collect();
    let diagonal = diagonalized(&reduced, &mut []);
    let of = |(lane, reduced): (usize, &Reduced)| {
        let mut values: Vec<f64> = diagonal.iter().map(|d| d.0[lane] * reduced.scale).collect();
        values.sort_by(|a, b| b.total_cmp(a));
        values
    };
    reduced.iter().enumerate().map(of).collect()
}

/// The eigenvalues of up to eight tridiagonal matrices, one a lane. Rows of the first are rotated into its eigenvectors.
fn diagonalized(matrices: &[Reduced], rows: &mut [Vec<f64>]) -> Vec<LaneBlock> {
    let n = matrices.first().map_or(0, |first| first.diagonal.len());
    let [mut d, mut e] = [(); 2].map(|()| vec![LaneBlock::default(); n]);
    for (lane, matrix) in matrices.iter().enumerate() {
        for i in 0..n {
            (d[i].0[lane], e[i].0[lane]) = (matrix.diagonal[i], matrix.beside[i]);
        }
    }
    widest(Diagonalize {
        d: &mut d,
        e: &mut e,
        rows,
    });
    d
}

/// See [`diagonalized`].
struct Diagonalize<'a> {
    d: &'a mut [LaneBlock],
    e: &'a mut [LaneBlock],
    rows: &'a mut [Vec<f64>],
}

impl SimdKernel for Diagonalize<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Diagonalize { d, e, rows } = self;
        let n = d.len();
        let (zero, one, two) = (L::splat(0.0), L::splat(1.0), L::splat(2.0));
        for l in 0..n {
            for _ in 0..STEPS {
                // Where each splits.
                let mut split = [(n - 1) as f64; WIDTH];
                let mut open = u8::MAX;
                for m in l..n - 1 {
                    let size = L::load(&d[m]).abs() + L::load(&d[m + 1]).abs();
                    let least = size * L::splat(f64::EPSILON) + L::splat(FLOOR);
                    let above = (L::load(&e[m]).abs() - least).positive_mask();
                    let found = open & !above;
                    for (lane, split) in split.iter_mut().enumerate() {
                        if found >> lane & 1 == 1 {
                            *split = m as f64;
                        }
                    }
                    open &= above;
                    if open == 0 {
                        break;
                    }
                }
                let last = split.iter().fold(0.0, |most: f64, m| most.max(*m)) as usize;
                if last == l {
                    break;
                }
                let mut ends = [0.0; WIDTH];
                for (lane, (end, m)) in ends.iter_mut().zip(&split).enumerate() {
                    *end = d[*m as usize].0[lane];
                }
                let split_at = L::read(&split);
                let works = split_at - L::splat(l as f64);
                // In lanes that do not work numbers may be anything; they are not kept.
                let low = L::load(&e[l]);
                let g = (L::load(&d[l + 1]) - L::load(&d[l])) / (two * low);
                let r = (g * g + one).sqrt();
                let signed = g + g.choose(r, (zero - g).choose(zero - r, r));
                let mut g = L::read(&ends) - L::load(&d[l]) + low / signed;
                let (mut s, mut c, mut p) = (one, one, zero);
                for i in (l..last).rev() {
                    let here = split_at - L::splat(i as f64);
                    let (old_d, old_e) = (L::load(&d[i + 1]), L::load(&e[i + 1]));
                    let beside = L::load(&e[i]);
                    let (f, b) = (s * beside, c * beside);
                    let r = (f * f + g * g).sqrt();
                    here.choose(r, old_e).store(&mut e[i + 1]);
                    // Nothing to rotate where both are 0.
                    let inverse = one / r;
                    let (sin, cos) = (r.choose(f * inverse, zero), r.choose(g * inverse, one));
                    let rest = old_d - p;
                    let rotated = (L::load(&d[i]) - rest) * sin + two * cos * b;
                    let moved = sin * rotated;
                    here.choose(rest + moved, old_d).store(&mut d[i + 1]);
                    s = here.choose(sin, s);
                    c = here.choose(cos, c);
                    p = here.choose(moved, p);
                    rotate(rows, i, sin, cos);
                    g = here.choose(cos * rotated - b, g);
                }
                let old = L::load(&d[l]);
                works.choose(old - p, old).store(&mut d[l]);
                works.choose(g, low).store(&mut e[l]);
                for (lane, m) in split.iter().enumerate() {
                    e[*m as usize].0[lane] = 0.0;
                }
            }
        }
    }
}

/// Rotates two rows, if there are any, by the angle of the first lane.
#[inline(always)]
fn rotate<L: Lanes>(rows: &mut [Vec<f64>], i: usize, sin: L, cos: L) {
    if let Some([low, high]) = rows.get_mut(i..i + 2) {
        let [sin, cos] = [sin, cos].map(|lanes| lanes.numbers()[0]);
        for (a, b) in low.iter_mut().zip(high) {
            (*a, *b) = (cos * *a - sin * *b, sin * *a + cos * *b);
        }
    }
}

/// The matrix over its trace as `H_1 H_2 ... D T D* ... H_2 H_1` with T real and tridiagonal, D diagonal of modulus 1.
struct Reduced {
    /// The trace, or 1 where it is not positive.
    scale: f64,
    diagonal: Vec<f64>,
    /// `T_(k+1, k)`, and a 0.
    beside: Vec<f64>,
    phases: Vec<Complex<f64>>,
    /// `H_k = 1 - factor v v*`, on the elements from k + 1.
    reflections: Vec<(f64, Vec<Complex<f64>>)>,
}

impl Reduced {
    fn of(matrix: &Array2<Complex<f64>>) -> Reduced {
        let n = matrix.nrows();
        let trace: f64 = matrix.diag().iter().map(|z| z.re).sum();
        let scale = if trace > 0.0 { trace } else { 1.0 };
        let mut a = Rows::of(matrix, scale);
        let mut room = [(); 3].map(|()| zeros(a.blocks));
        let (mut diagonal, mut beside) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let (mut phases, mut reflections) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let one = Complex::new(1.0, 0.0);
        let mut phase = one;
        for k in 0..n {
            diagonal.push(a.at(k, k).re);
            phases.push(phase);
            let mut v: Vec<Complex<f64>> = (k + 1..n).map(|i| a.at(i, k)).collect();
            let Some((&first, others)) = v.split_first() else {
                beside.push(0.0);
                break;
            };
            let rest: f64 = others.iter().map(Complex::norm_sqr).sum();
            let (mut below, mut factor) = (first, 0.0);
            if rest > 0.0 {
                let norm = (rest + first.norm_sqr()).sqrt();
                let direction = match first.norm() {
                    0.0 => one,
                    size => first / size,
                };
                below = -direction * norm;
                v[0] -= below;
                factor = 2.0 / v.iter().map(Complex::norm_sqr).sum::<f64>();
                room[0]
                    .iter_mut()
                    .for_each(|part| part.fill(LaneBlock::default()));
                v.iter()
                    .enumerate()
                    .for_each(|(i, z)| set(&mut room[0], k + 1 + i, *z));
                let (a, room) = (&mut a, &mut room);
                widest(Reflect {
                    a,
                    from: k + 1,
                    factor,
                    room,
                });
            }
            let size = below.norm();
            phase *= if size > 0.0 { below / size } else { one };
            beside.push(size);
            reflections.push((factor, v));
        }
        Reduced {
            scale,
            diagonal,
            beside,
            phases,
            reflections,
        }
    }

    /// The eigenvector of the matrix that belongs to one of T.
    fn back(&self, row: &[f64]) -> Vec<Complex<f64>> {
        let mut vector: Vec<Complex<f64>> =
            row.iter().zip(&self.phases).map(|(z, d)| d * z).collect();
        for (k, (factor, v)) in self.reflections.iter().enumerate().rev() {
            let part = &mut vector[k + 1..];
            let along: Complex<f64> = v.iter().zip(&*part).map(|(v, u)| v.conj() * u).sum();
            for (u, v) in part.iter_mut().zip(v) {
                *u -= v * along * factor;
            }
        }
        vector
    }
}

/// Complex numbers, real and imaginary parts apart.
type Parts = [Vec<LaneBlock>; 2];

fn zeros(blocks: usize) -> Parts {
    [(); 2].map(|()| vec![LaneBlock::default(); blocks])
}

fn set(of: &mut Parts, i: usize, z: Complex<f64>) {
    of[0][i / WIDTH].0[i % WIDTH] = z.re;
    of[1][i / WIDTH].0[i % WIDTH] = z.im;
}

#[inline(always)]
fn get(of: &Parts, i: usize) -> Complex<f64> {
    let [re, im] = of.each_ref().map(|part| part[i / WIDTH].0[i % WIDTH]);
    Complex::new(re, im)
}

/// A Hermitian matrix row by row, rows padded with zeros to whole blocks. What is right of the block of the diagonal is read
/// nowhere.
struct Rows {
    n: usize,
    /// Of a row.
    blocks: usize,
    cells: Parts,
}

impl Rows {
    /// Of the lower triangle of a Hermitian matrix, over `scale`.
    fn of(matrix: &Array2<Complex<f64>>, scale: f64) -> Rows {
        let n = matrix.nrows();
        let blocks = n.div_ceil(WIDTH);
        let mut cells = zeros(n * blocks);
        let rows = matrix.outer_iter().enumerate();
        let lower = rows.flat_map(|(i, row)| (0..=i).map(move |j| (i, j, row[j] / scale)));
        for (i, j, z) in lower {
            set(&mut cells, i * blocks * WIDTH + j, z);
            if i / WIDTH == j / WIDTH {
                set(&mut cells, j * blocks * WIDTH + i, z.conj());
            }
        }
        Rows { n, blocks, cells }
    }

    fn at(&self, i: usize, j: usize) -> Complex<f64> {
        get(&self.cells, i * self.blocks * WIDTH + j)
    }
}

/// `B <- H B H`, of the part B of a Hermitian matrix from `from` on, with `H = 1 - factor v v*`.
///
/// With `p = factor B v` and `q = p - factor/2 (v* p) v`, that is `B - v q* - q v*`. What is left of `from` is
/// not read again.
struct Reflect<'a> {
    a: &'a mut Rows,
    from: usize,
    factor: f64,
    /// v, and room for p and for what rows add to it.
    room: &'a mut [Parts; 3],
}

impl SimdKernel for Reflect<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Reflect {
            a,
            from,
            factor,
            room: [v, p, dots],
        } = self;
        let Rows { n, blocks, cells } = a;
        let (blocks, first) = (*blocks, from / WIDTH);
        p.iter_mut()
            .chain(&mut *dots)
            .for_each(|part| part.fill(LaneBlock::default()));
        // p = B v: a row of the lower triangle times v, and what its conjugate adds to the rows above.
        for j in from..*n {
            let factor = Each::<L>::splat(get(v, j));
            let mut dot = Each::splat(Complex::default());
            let diagonal = j / WIDTH;
            for b in first..diagonal {
                let cell = Each::load(cells, j * blocks + b);
                dot = dot.plus(cell, Each::load(v, b));
                Each::load(p, b).plus_conjugate(factor, cell).store(p, b);
            }
            // The block of the diagonal holds all elements.
            let cell = Each::load(cells, j * blocks + diagonal);
            Each::load(p, diagonal)
                .plus_conjugate(factor, cell)
                .store(p, diagonal);
            set(dots, j, Complex::new(dot.re.sum(), dot.im.sum()));
        }
        (first * WIDTH..from).for_each(|i| set(p, i, Complex::default()));
        let scale = L::splat(factor);
        let mut along = L::splat(0.0);
        for b in first..blocks {
            let (v, here) = (Each::<L>::load(v, b), Each::<L>::load(p, b));
            let dot = Each::<L>::load(dots, b);
            let (re, im) = ((here.re + dot.re) * scale, (here.im + dot.im) * scale);
            along = v.re.fused(re, v.im.fused(im, along));
            Each { re, im }.store(p, b);
        }
        let less = L::splat(-0.5 * factor * along.sum());
        for b in first..blocks {
            let (v, here) = (Each::<L>::load(v, b), Each::<L>::load(p, b));
            let (re, im) = (v.re.fused(less, here.re), v.im.fused(less, here.im));
            Each { re, im }.store(p, b);
        }
        for i in from..*n {
            let minus_v = Each::<L>::splat(-get(v, i));
            let minus_p = Each::<L>::splat(-get(p, i));
            for b in first..=i / WIDTH {
                let cell = Each::load(cells, i * blocks + b);
                let cell = cell.plus_conjugate(minus_v, Each::load(p, b));
                let cell = cell.plus_conjugate(minus_p, Each::load(v, b));
                cell.store(cells, i * blocks + b);
            }
        }
    }
}

/// Eight complex numbers.
#[derive(Clone, Copy)]
struct Each<L> {
    re: L,
    im: L,
}

impl<L: Lanes> Each<L> {
    #[inline(always)]
    fn splat(z: Complex<f64>) -> Each<L> {
        let (re, im) = (L::splat(z.re), L::splat(z.im));
        Each { re, im }
    }

    #[inline(always)]
    fn load([re, im]: &Parts, b: usize) -> Each<L> {
        let (re, im) = (L::load(&re[b]), L::load(&im[b]));
        Each { re, im }
    }

    #[inline(always)]
    fn store(self, [re, im]: &mut Parts, b: usize) {
        self.re.store(&mut re[b]);
        self.im.store(&mut im[b]);
    }

    /// `self + a b`.
    #[inline(always)]
    fn plus(self, a: Each<L>, b: Each<L>) -> Each<L> {
        let minus = L::splat(0.0) - a.im;
        let re = a.re.fused(b.re, minus.fused(b.im, self.re));
        let im = a.re.fused(b.im, a.im.fused(b.re, self.im));
        Each { re, im }
    }

    /// `self + a b*`.
    #[inline(always)]
    fn plus_conjugate(self, a: Each<L>, b: Each<L>) -> Each<L> {
        let minus = L::splat(0.0) - a.re;
        let re = a.re.fused(b.re, a.im.fused(b.im, self.re));
        let im = a.im.fused(b.re, minus.fused(b.im, self.im));
        Each { re, im }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Random;

    /// Of random matrices of all ranks: `A u = lambda u`, orthonormal vectors, and the trace.
    #[test]
    fn val_closed_form_residuals_and_trace() {
        let mut random = Random::new(5);
        let orders = [1, 2, 3, 8, 15, 40, 40, 6];
        for (n, rank) in orders.into_iter().zip([1, 2, 1, 8, 4, 40, 3, 0]) {
            let factors = Array2::from_shape_fn((rank, n), |_| {
                Complex::new(random.normal(), random.normal())
            });
            let a = Array2::from_shape_fn((n, n), |(i, j)| {
                let pair = |r: usize| factors[[r, i]].conj() * factors[[r, j]];
                (0..rank).map(pair).sum::<Complex<f64>>()
            });
            let found = eigen(&a);
            let alone = &eigenvalues(std::slice::from_ref(&a))[0];
            // Beside others of the same order.
            let others = [a.mapv(|z| z * 3.0), a.clone(), Array2::zeros((n, n))];
            assert_eq!(eigenvalues(&others)[1], *alone);
            let trace: f64 = (0..n).map(|i| a[[i, i]].re).sum();
            let near = 1e-14 * trace;
            assert!((found.values.iter().sum::<f64>() - trace).abs() <= near);
            assert!(found.values.is_sorted_by(|a, b| a >= b));
            for (k, (value, vector)) in found.values.iter().zip(&found.vectors).enumerate() {
                assert!((value - alone[k]).abs() <= near, "{n} {rank} {k}");
                assert!(k < rank || value.abs() <= near, "{k} {value:e}");
                for i in 0..n {
                    let product: Complex<f64> = (0..n).map(|j| a[[i, j]] * vector[j]).sum();
                    let off = (product - vector[i] * value).norm();
                    assert!(off <= near, "{n} {rank} {k}");
                }
                for (l, other) in found.vectors.iter().enumerate() {
                    let pairs = vector.iter().zip(other);
                    let product: Complex<f64> = pairs.map(|(a, b)| a.conj() * b).sum();
                    let off = (product - f64::from(k == l)).norm();
                    assert!(off < 1e-13, "{n} {rank} {k} {l}");
                }
            }
        }
    }
}
