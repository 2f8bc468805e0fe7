//! Eigenvalues and eigenvectors of small Hermitian matrices.

use ndarray::Array2;
use num_complex::Complex;

use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, WIDTH, widest};
use crate::numeric::sorted;

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
    let mut reduced = Reduced::of(matrix);
    let unit = |i: usize| (0..n).map(|j| f64::from(u8::from(i == j))).collect();
    let mut rows: Vec<Vec<f64>> = (0..n).map(unit).collect();
    let turn = |f: f64, g: f64, r: f64| (f / r, g / r);
    diagonalize(&mut reduced.diagonal, &mut reduced.beside, &mut rows, turn);
    let values = &reduced.diagonal;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    let scale = scale_of(matrix);
    Eigen {
        values: order.iter().map(|i| values[*i] * scale).collect(),
        vectors: order.iter().map(|i| reduced.back(&rows[*i])).collect(),
    }
}

/// The eigenvalues alone, descending.
pub(crate) fn eigenvalues(matrix: &Array2<Complex<f64>>) -> Vec<f64> {
    let mut reduced = Reduced::of(matrix);
    let turn = |f: f64, g: f64, r: f64| {
        let inverse = r.recip();
        (f * inverse, g * inverse)
    };
    diagonalize(&mut reduced.diagonal, &mut reduced.beside, &mut [], turn);
    let scale = scale_of(matrix);
    let mut values = sorted(reduced.diagonal.iter().map(|value| value * scale));
    values.reverse();
    values
}

/// The trace, or 1 where it is not positive.
fn scale_of(matrix: &Array2<Complex<f64>>) -> f64 {
    let trace: f64 = matrix.diag().iter().map(|z| z.re).sum();
    if trace > 0.0 { trace } else { 1.0 }
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
    /// Of a matrix over its scale.
    fn of(matrix: &Array2<Complex<f64>>) -> Reduced {
        let n = matrix.nrows();
        let mut a = Triangle::of(matrix, scale_of(matrix));
        let one = Complex::new(1.0, 0.0);
        let mut found = Reduced {
            diagonal: Vec::with_capacity(n),
            beside: Vec::with_capacity(n),
            phases: Vec::with_capacity(n),
            reflections: Vec::with_capacity(n),
        };
        let mut phase = one;
        let mut room = [(); 3].map(|()| vec![Cell::default(); a.blocks]);
        for k in 0..n {
            found.diagonal.push(a.at(k, k).re);
            found.phases.push(phase);
            let mut v: Vec<Complex<f64>> = (k + 1..n).map(|i| a.at(i, k)).collect();
            let Some(&first) = v.first() else {
                found.beside.push(0.0);
                break;
            };
            let rest: f64 = v[1..].iter().map(Complex::norm_sqr).sum();
            let (mut beside, mut factor) = (first, 0.0);
            if rest > 0.0 {
                let norm = (rest + first.norm_sqr()).sqrt();
                let direction = match first.norm() {
                    0.0 => one,
                    size => first / size,
                };
                beside = -direction * norm;
                v[0] -= beside;
                let length: f64 = v.iter().map(Complex::norm_sqr).sum();
                factor = 2.0 / length;
                let [reflected, p, dots] = &mut room;
                for part in [&mut *reflected, p, dots] {
                    part.fill(Cell::default());
                }
                (k + 1..).zip(&v).for_each(|(i, z)| set(reflected, i, *z));
                widest(Reflect {
                    a: &mut a,
                    from: k + 1,
                    factor,
                    v: reflected,
                    p,
                    dots,
                });
            }
            let size = beside.norm();
            phase *= if size > 0.0 { beside / size } else { one };
            found.beside.push(size);
            found.reflections.push((factor, v));
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

/// Real and imaginary parts of eight numbers of a vector or a row.
type Cell = [LaneBlock; 2];

fn get(cells: &[Cell], i: usize) -> Complex<f64> {
    let [re, im] = &cells[i / WIDTH];
    Complex::new(re.0[i % WIDTH], im.0[i % WIDTH])
}

fn set(cells: &mut [Cell], i: usize, z: Complex<f64>) {
    let [re, im] = &mut cells[i / WIDTH];
    (re.0[i % WIDTH], im.0[i % WIDTH]) = (z.re, z.im);
}

/// The lower triangle of a Hermitian matrix row by row, rows padded with zeros. Cells of the diagonal are whole; what is
/// right of them is read nowhere.
struct Triangle {
    blocks: usize,
    cells: Vec<Cell>,
}

impl Triangle {
    /// Of a matrix over `scale`.
    fn of(matrix: &Array2<Complex<f64>>, scale: f64) -> Triangle {
        let n = matrix.nrows();
        let blocks = n.div_ceil(WIDTH);
        let mut cells = vec![Cell::default(); n * blocks];
        for (i, row) in matrix.outer_iter().enumerate() {
            for (j, z) in row.iter().enumerate().take(i + 1) {
                set(&mut cells[i * blocks..], j, z / scale);
                if i / WIDTH == j / WIDTH {
                    set(&mut cells[j * blocks..], i, z.conj() / scale);
                }
            }
        }
        Triangle { blocks, cells }
    }

    fn at(&self, i: usize, j: usize) -> Complex<f64> {
        get(&self.cells[i * self.blocks..], j)
    }
}

/// `B <- H B H`, of the part B of a Hermitian matrix from `from` on, with `H = 1 - factor v v*`.
///
/// With `p = factor B v` and `q = p - factor/2 (v* p) v`, that is `B - v q* - q v*`. What is left of `from` is
/// not read again.
struct Reflect<'a> {
    a: &'a mut Triangle,
    from: usize,
    factor: f64,
    v: &'a [Cell],
    /// Zeros: of p, and of what a row has in common with v.
    p: &'a mut [Cell],
    dots: &'a mut [Cell],
}

impl SimdKernel for Reflect<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Reflect { a, v, p, dots, .. } = self;
        let (first, zero) = (self.from / WIDTH, L::splat(0.0));
        let rows = || (0..).zip(a.cells.chunks_exact(a.blocks)).skip(self.from);
        // p = B v: a row of the lower triangle times v, and what its conjugate adds to the rows above.
        for (j, row) in rows() {
            let (own, last) = (all::<L>(v, j), j / WIDTH);
            let mut dot = [zero; 2];
            for b in first..last {
                let [re, im] = load::<L>(&row[b]);
                dot = plus(dot, re, [im, zero - im], load(&v[b]));
                store(plus(load(&p[b]), re, [zero - im, im], own), &mut p[b]);
            }
            let [re, im] = load::<L>(&row[last]);
            let sum = plus(load(&p[last]), re, [zero - im, im], own);
            store(sum, &mut p[last]);
            let [re, im] = dot.map(L::sum);
            set(dots, j, Complex::new(re, im));
        }
        for b in first..a.blocks {
            let ([re, im], [dot_re, dot_im]) = (load::<L>(&p[b]), load(&dots[b]));
            store([re + dot_re, im + dot_im], &mut p[b]);
        }
        (first * WIDTH..self.from).for_each(|i| set(p, i, Complex::default()));
        let scale = L::splat(self.factor);
        let mut along = zero;
        for (p, v) in p.iter_mut().zip(v).skip(first) {
            let ([re, im], [v_re, v_im]) = (load::<L>(p), load::<L>(v));
            let (re, im) = (re * scale, im * scale);
            along = v_re.fused(re, v_im.fused(im, along));
            store([re, im], p);
        }
        let share = L::splat(-0.5 * self.factor * along.sum());
        for (p, v) in p.iter_mut().zip(v).skip(first) {
            let ([re, im], [v_re, v_im]) = (load::<L>(p), load::<L>(v));
            store([v_re.fused(share, re), v_im.fused(share, im)], p);
        }
        let rows = (0..).zip(a.cells.chunks_exact_mut(a.blocks));
        for (i, row) in rows.skip(self.from) {
            let (own_v, own_p) = (all::<L>(v, i), all::<L>(p, i));
            for b in first..=i / WIDTH {
                let first = less(load(&row[b]), own_v, load(&p[b]));
                store(less(first, own_p, load(&v[b])), &mut row[b]);
            }
        }
    }
}

#[inline(always)]
fn load<L: Lanes>(cell: &Cell) -> [L; 2] {
    [L::load(&cell[0]), L::load(&cell[1])]
}

#[inline(always)]
fn store<L: Lanes>([re, im]: [L; 2], cell: &mut Cell) {
    re.store(&mut cell[0]);
    im.store(&mut cell[1]);
}

/// An element in all lanes.
#[inline(always)]
fn all<L: Lanes>(of: &[Cell], i: usize) -> [L; 2] {
    let z = get(of, i);
    [L::splat(z.re), L::splat(z.im)]
}

/// `sum + a b` with `a = re + i im`; of the conjugate where the parts `im` and `-im` are exchanged.
#[inline(always)]
fn plus<L: Lanes>(sum: [L; 2], re: L, [im, minus]: [L; 2], b: [L; 2]) -> [L; 2] {
    let inner = [minus.fused(b[1], sum[0]), im.fused(b[0], sum[1])];
    [re.fused(b[0], inner[0]), re.fused(b[1], inner[1])]
}

/// `sum - a b*`.
#[inline(always)]
fn less<L: Lanes>(sum: [L; 2], [re, im]: [L; 2], b: [L; 2]) -> [L; 2] {
    let [less_re, less_im] = [L::splat(0.0) - re, L::splat(0.0) - im];
    let inner = [less_re.fused(b[0], sum[0]), less_im.fused(b[0], sum[1])];
    [less_im.fused(b[1], inner[0]), re.fused(b[1], inner[1])]
}

/// Turns the diagonal into eigenvalues, and rotates `rows` into eigenvectors: by sine and cosine, which `turn` makes of the
/// sides `f` and `g` and the hypotenuse.
fn diagonalize(
    d: &mut [f64],
    e: &mut [f64],
    rows: &mut [Vec<f64>],
    turn: impl Fn(f64, f64, f64) -> (f64, f64),
) {
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
                (s, c) = turn(f, g, r);
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
        let orders = [(1, 1), (3, 1), (8, 8), (15, 4), (40, 40), (6, 0)];
        for (n, rank) in orders {
            let mut number = |_| Complex::new(random.normal(), random.normal());
            let factors = Array2::from_shape_fn((rank, n), &mut number);
            let a = factors.t().mapv(|z| z.conj()).dot(&factors);
            let found = eigen(&a);
            let alone = eigenvalues(&a);
            let near = 1e-14 * a.diag().sum().re;
            assert!((found.values.iter().sum::<f64>() - a.diag().sum().re).abs() <= near);
            assert!(found.values.is_sorted_by(|a, b| a >= b));
            let vectors = Array2::from_shape_fn((n, n), |(k, i)| found.vectors[k][i]);
            let overlaps = vectors.mapv(|z| z.conj()).dot(&vectors.t());
            for (k, value) in found.values.iter().enumerate() {
                assert!((value - alone[k]).abs() <= near, "{n} {rank} {k}");
                assert!(k < rank || value.abs() <= near, "{k} {value:e}");
                let off = a.dot(&vectors.row(k)) - vectors.row(k).mapv(|z| z * value);
                assert!(off.iter().all(|z| z.norm() <= near), "{n} {rank} {k}");
                let unit = |l: usize| f64::from(u8::from(k == l));
                let is_unit = |l: usize| (overlaps[[k, l]] - unit(l)).norm() < 1e-13;
                assert!((0..n).all(is_unit), "{n} {rank} {k}");
            }
        }
    }
}
