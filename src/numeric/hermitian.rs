//! Eigenvalues and eigenvectors of small Hermitian matrices.

use ndarray::Array2;
use num_complex::Complex;

/// Eigenvalues, descending, with the eigenvectors as rows if they were requested.
pub(crate) struct Eigen {
    pub values: Vec<f64>,
    pub vectors: Vec<Vec<Complex<f64>>>,
}

/// Steps of the QL iteration an eigenvalue; two or three are usual.
const STEPS: usize = 60;
/// Off-diagonal elements below this share of the trace are rounding.
const FLOOR: f64 = 1e-3 * f64::EPSILON;

/// The eigenvalues of a positive semidefinite Hermitian matrix, of which the lower triangle is read, to a
/// few times the rounding of its trace; on request the eigenvectors, of unit length.
///
/// Reduced to a real tridiagonal matrix by reflections, then diagonalized by implicit QL steps. Cost: `4/3
/// n^3` complex operations, three times that with the vectors.
///
/// Source: R. S. Martin, C. Reinsch, J. H. Wilkinson, Numer. Math. 11, 181 (1968); A. Dubrulle, R. S. Martin,
/// J. H. Wilkinson, Numer. Math. 12, 377 (1968).
pub(crate) fn eigen(matrix: &Array2<Complex<f64>>, with_vectors: bool) -> Eigen {
    let n = matrix.nrows();
    let trace: f64 = (0..n).map(|i| matrix[[i, i]].re).sum();
    let scale = if trace > 0.0 { trace } else { 1.0 };
    let mut reduced = Reduced::of(matrix.mapv(|z| z / scale));
    let mut rows = match with_vectors {
        true => (0..n).map(|i| unit_vector(n, i)).collect(),
        false => Vec::new(),
    };
    diagonalize(&mut reduced.diagonal, &mut reduced.beside, &mut rows);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| reduced.diagonal[*b].total_cmp(&reduced.diagonal[*a]));
    let vectors = match with_vectors {
        true => order.iter().map(|i| reduced.back(&rows[*i])).collect(),
        false => Vec::new(),
    };
    Eigen {
        values: order.iter().map(|i| reduced.diagonal[*i] * scale).collect(),
        vectors,
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
    fn of(mut a: Array2<Complex<f64>>) -> Reduced {
        let n = a.nrows();
        let one = Complex::new(1.0, 0.0);
        let mut found = Reduced {
            diagonal: Vec::with_capacity(n),
            beside: Vec::with_capacity(n),
            phases: vec![one],
            reflections: Vec::with_capacity(n),
        };
        for k in 0..n {
            found.diagonal.push(a[[k, k]].re);
            if k + 1 == n {
                found.beside.push(0.0);
                break;
            }
            let mut v: Vec<Complex<f64>> = (k + 1..n).map(|i| a[[i, k]]).collect();
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
                reflect(&mut a, k + 1, &v, factor);
            }
            let size = beside.norm();
            let turn = if size > 0.0 { beside / size } else { one };
            found.phases.push(found.phases[k] * turn);
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

/// `B <- H B H`, of the lower triangle of the part of `a` from `from` on.
fn reflect(a: &mut Array2<Complex<f64>>, from: usize, v: &[Complex<f64>], factor: f64) {
    let n = v.len();
    let mut p = vec![Complex::default(); n];
    for i in 0..n {
        for j in 0..i {
            let element = a[[from + i, from + j]];
            p[i] += element * v[j];
            p[j] += element.conj() * v[i];
        }
        p[i] += v[i] * a[[from + i, from + i]].re;
    }
    for z in &mut p {
        *z *= factor;
    }
    let along: Complex<f64> = v.iter().zip(&p).map(|(v, p)| v.conj() * p).sum();
    let half = 0.5 * factor * along.re;
    for (p, v) in p.iter_mut().zip(v) {
        *p -= v * half;
    }
    for i in 0..n {
        for j in 0..=i {
            a[[from + i, from + j]] -= v[i] * p[j].conj() + p[i] * v[j].conj();
        }
    }
}

/// Turns the diagonal into eigenvalues, and rotates `rows`, which may be none, into eigenvectors.
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
            let mut g = (d[l + 1] - d[l]) / (2.0 * e[l]);
            let r = g.hypot(1.0);
            g = d[m] - d[l] + e[l] / (g + r.copysign(g));
            let (mut s, mut c, mut p) = (1.0, 1.0, 0.0);
            let mut is_whole = true;
            for i in (l..m).rev() {
                let (f, b) = (s * e[i], c * e[i]);
                let r = f.hypot(g);
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
            let found = eigen(&a, true);
            let alone = eigen(&a, false);
            let trace: f64 = (0..n).map(|i| a[[i, i]].re).sum();
            let near = 1e-14 * trace;
            assert!((found.values.iter().sum::<f64>() - trace).abs() <= near);
            assert!(found.values.is_sorted_by(|a, b| a >= b));
            for (k, (value, vector)) in found.values.iter().zip(&found.vectors).enumerate() {
                assert_eq!(value.to_bits(), alone.values[k].to_bits());
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
