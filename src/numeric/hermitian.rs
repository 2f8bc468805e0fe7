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
    let scale = scale_of(matrix);
    let mut reduced = Reduced::of(Planes::of(matrix, scale), true);
    let mut rows: Vec<Vec<f64>> = (0..n).map(|i| unit_vector(n, i)).collect();
    diagonalize(&mut reduced.diagonal, &mut reduced.beside, &mut rows);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| reduced.diagonal[*b].total_cmp(&reduced.diagonal[*a]));
    Eigen {
        values: order.iter().map(|i| reduced.diagonal[*i] * scale).collect(),
        vectors: order.iter().map(|i| reduced.back(&rows[*i])).collect(),
    }
}

/// The eigenvalues, descending, of up to eight matrices of the same order as those of [`eigen`]; those of one do not
/// depend on the others.
pub(crate) fn eigenvalues(matrices: &[Array2<Complex<f64>>]) -> Vec<Vec<f64>> {
    let n = matrices.first().map_or(0, Array2::nrows);
    let mut diagonal = vec![LaneBlock::default(); n];
    let mut beside = vec![LaneBlock::default(); n];
    let mut scales = [1.0; WIDTH];
    for (lane, (matrix, scale)) in matrices.iter().zip(&mut scales).enumerate() {
        *scale = scale_of(matrix);
        let reduced = Reduced::of(Planes::of(matrix, *scale), false);
        for (to, value) in diagonal.iter_mut().zip(reduced.diagonal) {
            to.0[lane] = value;
        }
        for (to, value) in beside.iter_mut().zip(reduced.beside) {
            to.0[lane] = value;
        }
    }
    widest(Diagonalize {
        d: &mut diagonal,
        e: &mut beside,
    });
    let of = |(lane, scale): (usize, &f64)| {
        let mut values: Vec<f64> = diagonal.iter().map(|d| d.0[lane] * scale).collect();
        values.sort_by(|a, b| b.total_cmp(a));
        values
    };
    scales
        .iter()
        .enumerate()
        .take(matrices.len())
        .map(of)
        .collect()
}

/// The trace, or 1 where it is not positive.
fn scale_of(matrix: &Array2<Complex<f64>>) -> f64 {
    let trace: f64 = matrix.diag().iter().map(|z| z.re).sum();
    if trace > 0.0 { trace } else { 1.0 }
}

/// [`diagonalize`] of eight matrices at once, one a lane.
struct Diagonalize<'a> {
    d: &'a mut [LaneBlock],
    e: &'a mut [LaneBlock],
}

impl SimdKernel for Diagonalize<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Diagonalize { d, e } = self;
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

fn unit_vector(n: usize, i: usize) -> Vec<f64> {
    let mut row = vec![0.0; n];
    row[i] = 1.0;
    row
}

/// `H_1 H_2 ... D T D* ... H_2 H_1` with T real and tridiagonal, D diagonal of modulus 1.
struct Reduced {
    diagonal: Vec<f64>,
    /// `T_(k+1, k)`, and a 0.
    beside: Vec<f64>,
    phases: Vec<Complex<f64>>,
    /// `H_k = 1 - factor v v*`, on the elements from k + 1.
    reflections: Vec<(f64, Vec<Complex<f64>>)>,
}

impl Reduced {
    /// Keeps the reflections if they are wanted.
    fn of(mut a: Planes, keeps: bool) -> Reduced {
        let n = a.n;
        let one = Complex::new(1.0, 0.0);
        let mut found = Reduced {
            diagonal: Vec::with_capacity(n),
            beside: Vec::with_capacity(n),
            phases: Vec::with_capacity(if keeps { n } else { 0 }),
            reflections: Vec::with_capacity(if keeps { n } else { 0 }),
        };
        let mut phase = one;
        let mut v: Vec<Complex<f64>> = Vec::with_capacity(n);
        let mut room = ReflectRoom::new(a.blocks);
        for k in 0..n {
            found.diagonal.push(a.at(k, k).re);
            if keeps {
                found.phases.push(phase);
            }
            if k + 1 == n {
                found.beside.push(0.0);
                break;
            }
            v.clear();
            v.extend((k + 1..n).map(|i| a.at(i, k)));
            let rest: f64 = v[1..].iter().map(Complex::norm_sqr).sum();
            let mut beside = v[0];
            let mut factor = 0.0;
            if rest > 0.0 {
                let norm = (rest + v[0].norm_sqr()).sqrt();
                let direction = match v[0].norm() {
                    0.0 => one,
                    size => v[0] / size,
                };
                beside = -direction * norm;
                v[0] -= beside;
                let length: f64 = v.iter().map(Complex::norm_sqr).sum();
                factor = 2.0 / length;
                room.set(k + 1, &v);
                widest(Reflect {
                    a: &mut a,
                    from: k + 1,
                    factor,
                    room: &mut room,
                });
            }
            let size = beside.norm();
            phase *= if size > 0.0 { beside / size } else { one };
            found.beside.push(size);
            if keeps {
                found.reflections.push((factor, v.clone()));
            }
        }
        found
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

/// A Hermitian matrix row by row, real and imaginary parts apart, rows padded with zeros to whole blocks. What is
/// right of the block of the diagonal is read nowhere.
struct Planes {
    n: usize,
    blocks: usize,
    re: Vec<LaneBlock>,
    im: Vec<LaneBlock>,
}

impl Planes {
    /// Of the lower triangle of a Hermitian matrix, over `scale`.
    fn of(matrix: &Array2<Complex<f64>>, scale: f64) -> Planes {
        let n = matrix.nrows();
        let blocks = n.div_ceil(WIDTH);
        let mut planes = Planes {
            n,
            blocks,
            re: vec![LaneBlock::default(); n * blocks],
            im: vec![LaneBlock::default(); n * blocks],
        };
        for (i, row) in matrix.outer_iter().enumerate() {
            for (j, z) in row.iter().enumerate().take(i + 1) {
                planes.set(i, j, z / scale);
                if i / WIDTH == j / WIDTH {
                    planes.set(j, i, z.conj() / scale);
                }
            }
        }
        planes
    }

    fn set(&mut self, i: usize, j: usize, z: Complex<f64>) {
        let place = i * self.blocks + j / WIDTH;
        self.re[place].0[j % WIDTH] = z.re;
        self.im[place].0[j % WIDTH] = z.im;
    }

    fn at(&self, i: usize, j: usize) -> Complex<f64> {
        let place = i * self.blocks + j / WIDTH;
        Complex::new(self.re[place].0[j % WIDTH], self.im[place].0[j % WIDTH])
    }
}

/// Vectors of a reflection, in blocks like a row.
struct ReflectRoom {
    v: [Vec<LaneBlock>; 2],
    p: [Vec<LaneBlock>; 2],
    dots: [Vec<LaneBlock>; 2],
}

impl ReflectRoom {
    fn new(blocks: usize) -> ReflectRoom {
        let zeros = || vec![LaneBlock::default(); blocks];
        ReflectRoom {
            v: [zeros(), zeros()],
            p: [zeros(), zeros()],
            dots: [zeros(), zeros()],
        }
    }

    /// The vector with these elements from `from` on.
    fn set(&mut self, from: usize, v: &[Complex<f64>]) {
        for part in &mut self.v {
            part.fill(LaneBlock::default());
        }
        for (i, z) in (from..).zip(v) {
            self.v[0][i / WIDTH].0[i % WIDTH] = z.re;
            self.v[1][i / WIDTH].0[i % WIDTH] = z.im;
        }
    }
}

/// `B <- H B H`, of the part B of a Hermitian matrix from `from` on, with `H = 1 - factor v v*`.
///
/// With `p = factor B v` and `q = p - factor/2 (v* p) v`, that is `B - v q* - q v*`. What is left of `from` is
/// not read again.
struct Reflect<'a> {
    a: &'a mut Planes,
    from: usize,
    factor: f64,
    room: &'a mut ReflectRoom,
}

impl SimdKernel for Reflect<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Reflect {
            a,
            from,
            factor,
            room,
        } = self;
        let (n, blocks, first) = (a.n, a.blocks, from / WIDTH);
        let ReflectRoom {
            v: [v_re, v_im],
            p: [p_re, p_im],
            dots,
        } = room;
        let zero = L::splat(0.0);
        for b in first..blocks {
            zero.store(&mut p_re[b]);
            zero.store(&mut p_im[b]);
            zero.store(&mut dots[0][b]);
            zero.store(&mut dots[1][b]);
        }
        // p = B v: a row of the lower triangle times v, and what its conjugate adds to the rows above.
        for j in from..n {
            let (r, i) = (element::<L>(v_re, j), element::<L>(v_im, j));
            let minus = zero - r;
            let (mut dot_re, mut dot_im) = (zero, zero);
            let row = j * blocks;
            for b in first..j / WIDTH {
                let (re, im) = (L::load(&a.re[row + b]), L::load(&a.im[row + b]));
                let (x, y) = (L::load(&v_re[b]), L::load(&v_im[b]));
                dot_re = re.fused(x, (zero - im).fused(y, dot_re));
                dot_im = re.fused(y, im.fused(x, dot_im));
                r.fused(re, i.fused(im, L::load(&p_re[b])))
                    .store(&mut p_re[b]);
                i.fused(re, minus.fused(im, L::load(&p_im[b])))
                    .store(&mut p_im[b]);
            }
            // The block of the diagonal holds all elements.
            let b = j / WIDTH;
            let (re, im) = (L::load(&a.re[row + b]), L::load(&a.im[row + b]));
            r.fused(re, i.fused(im, L::load(&p_re[b])))
                .store(&mut p_re[b]);
            i.fused(re, minus.fused(im, L::load(&p_im[b])))
                .store(&mut p_im[b]);
            dots[0][b].0[j % WIDTH] = dot_re.sum();
            dots[1][b].0[j % WIDTH] = dot_im.sum();
        }
        for b in first..blocks {
            (L::load(&p_re[b]) + L::load(&dots[0][b])).store(&mut p_re[b]);
            (L::load(&p_im[b]) + L::load(&dots[1][b])).store(&mut p_im[b]);
        }
        for lane in 0..from % WIDTH {
            (p_re[first].0[lane], p_im[first].0[lane]) = (0.0, 0.0);
        }
        let scale = L::splat(factor);
        let mut along = zero;
        for b in first..blocks {
            let (re, im) = (L::load(&p_re[b]) * scale, L::load(&p_im[b]) * scale);
            along = L::load(&v_re[b]).fused(re, L::load(&v_im[b]).fused(im, along));
            re.store(&mut p_re[b]);
            im.store(&mut p_im[b]);
        }
        let less = L::splat(-0.5 * factor * along.sum());
        for b in first..blocks {
            L::load(&v_re[b])
                .fused(less, L::load(&p_re[b]))
                .store(&mut p_re[b]);
            L::load(&v_im[b])
                .fused(less, L::load(&p_im[b]))
                .store(&mut p_im[b]);
        }
        for i in from..n {
            let (v_r, v_i) = (zero - element::<L>(v_re, i), zero - element::<L>(v_im, i));
            let (p_r, p_i) = (zero - element::<L>(p_re, i), zero - element::<L>(p_im, i));
            let (plus_v, plus_p) = (element::<L>(v_re, i), element::<L>(p_re, i));
            for b in first..=i / WIDTH {
                let at = i * blocks + b;
                let (vr, vi) = (L::load(&v_re[b]), L::load(&v_im[b]));
                let (pr, pi) = (L::load(&p_re[b]), L::load(&p_im[b]));
                let re = v_i.fused(pi, v_r.fused(pr, L::load(&a.re[at])));
                let im = plus_v.fused(pi, v_i.fused(pr, L::load(&a.im[at])));
                p_i.fused(vi, p_r.fused(vr, re)).store(&mut a.re[at]);
                plus_p.fused(vi, p_i.fused(vr, im)).store(&mut a.im[at]);
            }
        }
    }
}

/// An element of a vector, in all lanes.
#[inline(always)]
fn element<L: Lanes>(of: &[LaneBlock], i: usize) -> L {
    L::splat(of[i / WIDTH].0[i % WIDTH])
}

/// Turns the diagonal into eigenvalues, and rotates `rows` into eigenvectors.
fn diagonalize(d: &mut [f64], e: &mut [f64], rows: &mut [Vec<f64>]) {
    let n = d.len();
    for l in 0..n {
        for _ in 0..STEPS {
            let is_split =
                |m: &usize| e[*m].abs() <= f64::EPSILON * (d[*m].abs() + d[m + 1].abs()) + FLOOR;
            let m = (l..n - 1).find(is_split).unwrap_or(n - 1);
            if m == l {
                break;
            }
            // Squares are far inside the number range: the trace is 1.
            let mut g = (d[l + 1] - d[l]) / (2.0 * e[l]);
            let r = (g * g + 1.0).sqrt();
            g = d[m] - d[l] + e[l] / (g + r.copysign(g));
            let (mut s, mut c, mut p) = (1.0, 1.0, 0.0);
            let mut is_whole = true;
            for i in (l..m).rev() {
                let (f, b) = (s * e[i], c * e[i]);
                let r = (f * f + g * g).sqrt();
                e[i + 1] = r;
                if r == 0.0 {
                    d[i + 1] -= p;
                    is_whole = false;
                    break;
                }
                (s, c) = (f / r, g / r);
                g = d[i + 1] - p;
                let r = (d[i] - g) * s + 2.0 * c * b;
                p = s * r;
                d[i + 1] = g + p;
                g = c * r - b;
                rotate(rows, i, s, c);
            }
            if is_whole {
                d[l] -= p;
                e[l] = g;
            }
            e[m] = 0.0;
        }
    }
}

fn rotate(rows: &mut [Vec<f64>], i: usize, s: f64, c: f64) {
    let Some([low, high]) = rows.get_mut(i..i + 2) else {
        return;
    };
    for (a, b) in low.iter_mut().zip(high) {
        (*a, *b) = (c * *a - s * *b, s * *a + c * *b);
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
        for (n, rank) in [
            (1, 1),
            (2, 2),
            (3, 1),
            (8, 8),
            (15, 4),
            (40, 40),
            (40, 3),
            (6, 0),
        ] {
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
                    assert!(
                        (product - vector[i] * value).norm() <= near,
                        "{n} {rank} {k}"
                    );
                }
                for (l, other) in found.vectors.iter().enumerate() {
                    let product: Complex<f64> =
                        vector.iter().zip(other).map(|(a, b)| a.conj() * b).sum();
                    let expected = if k == l { 1.0 } else { 0.0 };
                    assert!((product - expected).norm() < 1e-13, "{n} {rank} {k} {l}");
                }
            }
        }
    }
}
