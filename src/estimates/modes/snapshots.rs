//! Eigenvalues and modes of the realisations at one frequency.

use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex;

use crate::numeric::hermitian::{eigen, eigenvalues};
use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, WIDTH, widest};

/// Blocks of products that are summed plainly before their sums are added.
const LEAF: usize = 32;
/// Modes whose eigenvalue is below this share of the trace are rounding.
const LEAST: f64 = 1e-13;

/// Real and imaginary parts of a realisation at the sites of a tile, 0 beyond the last site.
pub(super) type Cell = [LaneBlock; 2];

/// Spectra of all realisations at several bins, in tiles of sites.
pub(super) struct Snapshots<'a> {
    /// Each `[bin * count + realisation]`.
    pub tiles: &'a [&'a [Cell]],
    pub n_sites: usize,
    /// Realisations.
    pub count: usize,
}

/// What is found at one bin.
pub(super) struct Solved {
    /// `(mode, site)`, of the unit norm `sum |phi|^2 = 1`; NaN where the eigenvalue is rounding.
    pub modes: Array2<Complex<f64>>,
}

impl Snapshots<'_> {
    /// Eigenvalues at up to eight bins, and their sum from the powers of all sites.
    pub fn eigenvalues(&self, bins: Range<usize>) -> Vec<(Vec<f64>, f64)> {
        let grams: Vec<_> = bins.map(|bin| self.rows(bin).gram()).collect();
        let traces = grams
            .iter()
            .map(|gram| gram.diag().iter().map(|z| z.re).sum());
        eigenvalues(&grams).into_iter().zip(traces).collect()
    }

    fn is_wide(&self) -> bool {
        self.count <= self.n_sites
    }

    fn rows(&self, bin: usize) -> Rows {
        match self.is_wide() {
            true => self.by_realisation(bin),
            false => self.by_site(bin),
        }
    }

    /// The first `modes` modes at a bin.
    pub fn solve(&self, bin: usize, modes: usize) -> Solved {
        let is_wide = self.is_wide();
        let rows = self.rows(bin);
        let gram = rows.gram();
        let found = eigen(&gram);
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
        Solved { modes: shapes }
    }

    /// A row a realisation.
    fn by_realisation(&self, bin: usize) -> Rows {
        let blocks = self.tiles.len();
        let mut rows = Rows::zeros(self.count, blocks);
        for (t, tile) in self.tiles.iter().enumerate() {
            let cells = &tile[bin * self.count..][..self.count];
            for (r, cell) in cells.iter().enumerate() {
                rows.cells[r * blocks + t] = *cell;
            }
        }
        rows
    }

    /// A row a site.
    fn by_site(&self, bin: usize) -> Rows {
        let mut rows = Rows::zeros(self.n_sites, self.count.div_ceil(WIDTH));
        for site in 0..self.n_sites {
            let (tile, lane) = (self.tiles[site / WIDTH], site % WIDTH);
            let cells = &tile[bin * self.count..][..self.count];
            for (r, [re, im]) in cells.iter().enumerate() {
                rows.set(site, r, Complex::new(re.0[lane], im.0[lane]));
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
    cells: Vec<Cell>,
    count: usize,
    /// Cells of a row.
    blocks: usize,
}

impl Rows {
    fn zeros(count: usize, blocks: usize) -> Rows {
        Rows {
            cells: vec![Cell::default(); count * blocks],
            count,
            blocks,
        }
    }

    fn set(&mut self, row: usize, column: usize, x: Complex<f64>) {
        let [re, im] = &mut self.cells[row * self.blocks + column / WIDTH];
        re.0[column % WIDTH] = x.re;
        im.0[column % WIDTH] = x.im;
    }

    fn at(&self, row: usize, column: usize) -> Complex<f64> {
        let [re, im] = &self.cells[row * self.blocks + column / WIDTH];
        Complex::new(re.0[column % WIDTH], im.0[column % WIDTH])
    }

    fn row(&self, row: usize) -> &[Cell] {
        &self.cells[row * self.blocks..][..self.blocks]
    }

    /// `G_kl = sum_c X_kc* X_lc`.
    fn gram(&self) -> Array2<Complex<f64>> {
        let mut gram = Array2::zeros((self.count, self.count));
        let last = self.count - 1;
        // Two rows with two others; an odd last one is taken twice.
        for k in (0..self.count).step_by(2) {
            for l in (0..=k).step_by(2) {
                let (rows, columns) = ([k, (k + 1).min(last)], [l, (l + 1).min(last)]);
                let products = widest(Products {
                    rows: rows.map(|row| self.row(row)),
                    columns: columns.map(|row| self.row(row)),
                });
                for (product, (row, column)) in products.iter().zip([
                    (rows[0], columns[0]),
                    (rows[0], columns[1]),
                    (rows[1], columns[0]),
                    (rows[1], columns[1]),
                ]) {
                    gram[[row, column]] = *product;
                    gram[[column, row]] = product.conj();
                }
            }
        }
        gram
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

/// `sum_c X_kc* X_lc` of two rows k with two rows l.
struct Products<'a> {
    rows: [&'a [Cell]; 2],
    columns: [&'a [Cell]; 2],
}

impl SimdKernel for Products<'_> {
    type Output = [Complex<f64>; 4];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [Complex<f64>; 4] {
        let ([p, q], [s, t]) = (self.rows, self.columns);
        let zero = L::splat(0.0);
        let mut sums = [[zero; 2]; 4];
        let leaves = p.chunks(LEAF).zip(q.chunks(LEAF));
        let others = s.chunks(LEAF).zip(t.chunks(LEAF));
        for ((p, q), (s, t)) in leaves.zip(others) {
            let mut leaf = [[zero; 2]; 4];
            for ((p, q), (s, t)) in p.iter().zip(q).zip(s.iter().zip(t)) {
                let (p, q) = (Parts::of(p), Parts::of(q));
                let (s, t) = (Parts::of(s), Parts::of(t));
                leaf = [
                    p.add_product(&s, leaf[0]),
                    p.add_product(&t, leaf[1]),
                    q.add_product(&s, leaf[2]),
                    q.add_product(&t, leaf[3]),
                ];
            }
            for (sum, leaf) in sums.iter_mut().zip(leaf) {
                *sum = [sum[0] + leaf[0], sum[1] + leaf[1]];
            }
        }
        let mut found = [Complex::default(); 4];
        for (found, sum) in found.iter_mut().zip(sums) {
            *found = Complex::new(sum[0].sum(), sum[1].sum());
        }
        found
    }
}

/// A cell in registers.
#[derive(Clone, Copy)]
struct Parts<L> {
    re: L,
    im: L,
}

impl<L: Lanes> Parts<L> {
    #[inline(always)]
    fn of(cell: &Cell) -> Parts<L> {
        Parts {
            re: L::load(&cell[0]),
            im: L::load(&cell[1]),
        }
    }

    /// Adds `z* w`.
    #[inline(always)]
    fn add_product(&self, w: &Parts<L>, [re, im]: [L; 2]) -> [L; 2] {
        let minus = L::splat(0.0) - self.im;
        [
            self.im.fused(w.im, self.re.fused(w.re, re)),
            minus.fused(w.re, self.re.fused(w.im, im)),
        ]
    }
}
