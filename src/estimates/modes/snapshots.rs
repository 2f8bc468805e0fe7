//! Eigenvalues and modes of the realisations at one frequency.

use ndarray::Array2;
use num_complex::Complex;

use crate::numeric::hermitian::eigen;
use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, WIDTH, widest};

/// Blocks of products that are summed plainly before their sums are added.
const LEAF: usize = 32;
/// Modes whose eigenvalue is below this share of the trace are rounding.
const LEAST: f64 = 1e-13;

/// Spectra of all realisations at several bins, in tiles of sites.
pub(super) struct Snapshots<'a> {
    /// Each `[(bin * count + realisation) * width + site]`.
    pub tiles: &'a [&'a [Complex<f64>]],
    pub n_sites: usize,
    /// Sites of a whole tile.
    pub together: usize,
    /// Realisations.
    pub count: usize,
}

/// What is found at one bin.
pub(super) struct Solved {
    /// Descending.
    pub eigenvalues: Vec<f64>,
    /// Their sum, from the powers of all sites.
    pub trace: f64,
    /// `(mode, site)`, of the unit norm `sum |phi|^2 = 1`; NaN where the eigenvalue is rounding.
    pub modes: Array2<Complex<f64>>,
}

impl Snapshots<'_> {
    /// Eigenvalues at a bin, and the first `modes` modes.
    pub fn solve(&self, bin: usize, modes: usize) -> Solved {
        let is_wide = self.count <= self.n_sites;
        let rows = self.rows(bin, is_wide);
        let gram = rows.gram();
        let found = eigen(&gram, modes > 0);
        let trace: f64 = (0..gram.nrows()).map(|i| gram[[i, i]].re).sum();
        let kept = modes.min(found.values.len());
        let mut shapes = Array2::from_elem((kept, self.n_sites), Complex::new(f64::NAN, f64::NAN));
        for (n, mut shape) in shapes.outer_iter_mut().enumerate() {
            if found.values[n] <= LEAST * trace {
                continue;
            }
            let mode = match is_wide {
                true => rows.combined(&found.vectors[n], self.n_sites),
                false => found.vectors[n].clone(),
            };
            for (to, z) in shape.iter_mut().zip(phased(&mode)) {
                *to = z;
            }
        }
        Solved {
            eigenvalues: found.values,
            trace,
            modes: shapes,
        }
    }

    /// A row a realisation, or a row a site.
    fn rows(&self, bin: usize, by_realisation: bool) -> Rows {
        let (count, length) = match by_realisation {
            true => (self.count, self.n_sites),
            false => (self.n_sites, self.count),
        };
        let mut rows = Rows::zeros(count, length);
        for (t, tile) in self.tiles.iter().enumerate() {
            let first = t * self.together;
            let width = self.together.min(self.n_sites - first);
            let tile = &tile[bin * self.count * width..][..self.count * width];
            for (r, spectra) in tile.chunks_exact(width).enumerate() {
                for (c, x) in spectra.iter().enumerate() {
                    let site = first + c;
                    let (row, column) = if by_realisation { (r, site) } else { (site, r) };
                    rows.set(row, column, *x);
                }
            }
        }
        rows
    }
}

/// Of unit norm, its largest element real and positive.
fn phased(mode: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let norm = mode.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
    let zero = Complex::default();
    let largest = mode
        .iter()
        .fold(zero, |most, z| match z.norm_sqr() > most.norm_sqr() {
            true => *z,
            false => most,
        });
    let turn = largest.conj() / (largest.norm() * norm);
    mode.iter().map(|z| z * turn).collect()
}

/// Rows of complex numbers, real and imaginary parts apart, padded with zeros to whole blocks.
struct Rows {
    re: Vec<LaneBlock>,
    im: Vec<LaneBlock>,
    count: usize,
    /// Blocks of a row.
    blocks: usize,
}

impl Rows {
    fn zeros(count: usize, length: usize) -> Rows {
        let blocks = length.div_ceil(WIDTH);
        Rows {
            re: vec![LaneBlock::default(); count * blocks],
            im: vec![LaneBlock::default(); count * blocks],
            count,
            blocks,
        }
    }

    fn set(&mut self, row: usize, column: usize, x: Complex<f64>) {
        let place = row * self.blocks + column / WIDTH;
        self.re[place].0[column % WIDTH] = x.re;
        self.im[place].0[column % WIDTH] = x.im;
    }

    fn at(&self, row: usize, column: usize) -> Complex<f64> {
        let place = row * self.blocks + column / WIDTH;
        let lane = column % WIDTH;
        Complex::new(self.re[place].0[lane], self.im[place].0[lane])
    }

    /// `G_kl = sum_c X_kc* X_lc`.
    fn gram(&self) -> Array2<Complex<f64>> {
        widest(Gram(self))
    }

    /// `sum_k v_k* X_kc*`, of the first `length` columns.
    fn combined(&self, vector: &[Complex<f64>], length: usize) -> Vec<Complex<f64>> {
        let term = |c: usize| -> Complex<f64> {
            let terms = vector.iter().enumerate();
            terms.map(|(k, v)| (v * self.at(k, c)).conj()).sum()
        };
        (0..length).map(term).collect()
    }
}

struct Gram<'a>(&'a Rows);

impl SimdKernel for Gram<'_> {
    type Output = Array2<Complex<f64>>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Array2<Complex<f64>> {
        let Rows {
            re,
            im,
            count,
            blocks,
        } = self.0;
        let (count, blocks) = (*count, *blocks);
        let mut gram = Array2::zeros((count, count));
        for k in 0..count {
            for l in 0..=k {
                let mut sum = [L::splat(0.0), L::splat(0.0)];
                for from in (0..blocks).step_by(LEAF) {
                    let range = from..blocks.min(from + LEAF);
                    let mut leaf = [L::splat(0.0), L::splat(0.0)];
                    for b in range {
                        let (p, q) = (k * blocks + b, l * blocks + b);
                        let (a, b) = (L::load(&re[p]), L::load(&im[p]));
                        let (c, d) = (L::load(&re[q]), L::load(&im[q]));
                        leaf[0] = leaf[0] + (a * c + b * d);
                        leaf[1] = leaf[1] + (a * d - b * c);
                    }
                    sum = [sum[0] + leaf[0], sum[1] + leaf[1]];
                }
                let [re, im] = sum.map(|lanes| {
                    let mut v = [0.0; WIDTH];
                    lanes.write(&mut v);
                    let [a, b, c, d, e, f, g, h] = v;
                    ((a + e) + (b + f)) + ((c + g) + (d + h))
                });
                gram[[k, l]] = Complex::new(re, im);
                gram[[l, k]] = Complex::new(re, -im);
            }
        }
        gram
    }
}
