//! Eigenvalues and modes of the realisations at one frequency.

use ndarray::Array2;
use num_complex::Complex;

use crate::numeric::hermitian::{eigen, eigenvalues};
use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, WIDTH, widest};

/// Blocks of products that are summed plainly before their sums are added.
const LEAF: usize = 32;
/// Modes whose eigenvalue, and sites whose power is below this share of the power of all sites are rounding.
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

/// One mode at one bin.
pub(super) struct Solved {
    /// Of each site, of the unit norm `sum |phi|^2 = 1`, the largest real and positive; NaN where the eigenvalue is rounding.
    pub shape: Vec<Complex<f64>>,
    /// Power in step with the mode, each site's over its own: 1 for each site that is wholly coherent with it.
    pub related: f64,
    /// Variance of its power over the realisations, over the square of the mean: 0 of a steady tone, 1 of noise.
    pub unsteadiness: f64,
}

/// Eigenvalues at one bin, descending.
pub(super) struct Eigenvalues {
    /// Of the realisations.
    pub energies: Vec<f64>,
    /// Of the same with the power 1 at every site.
    pub coherencies: Vec<f64>,
    /// Powers of all sites.
    pub trace: f64,
    /// How evenly realisations share the power of unrelated sites: 1, or less where a few of them are loud at many sites.
    pub evenness: f64,
}

impl Snapshots<'_> {
    /// Those at a bin.
    pub fn eigenvalues(&self, bin: usize) -> Eigenvalues {
        let (gram, levels) = (self.rows(bin, None).gram(), self.levels(bin));
        let equal = match self.is_wide() {
            true => self.rows(bin, Some(&levels)).gram(),
            // A row a site.
            false => {
                Array2::from_shape_fn(gram.dim(), |(i, j)| gram[[i, j]] * (levels[i] * levels[j]))
            }
        };
        Eigenvalues {
            energies: eigenvalues(&gram),
            coherencies: eigenvalues(&equal),
            trace: gram.diag().iter().map(|z| z.re).sum(),
            evenness: self.evenness(bin, &levels),
        }
    }

    /// `(n^2 + n) / (R sum_r p_r^2)`, with the powers `p_r` that R realisations have at n sites of equal power: 1 for white noise,
    /// whose `R p_r / n` has the variance `1 / n`.
    fn evenness(&self, bin: usize, levels: &[f64]) -> f64 {
        let power = |r: usize| -> f64 {
            let sites = levels.iter().enumerate();
            sites
                .map(|(j, level)| (self.at(bin, j, r) * level).norm_sqr())
                .sum()
        };
        let powers = (0..self.count).map(power);
        let [all, squares] = powers.fold([0.0; 2], |[all, squares], p| [all + p, squares + p * p]);
        match squares > 0.0 {
            true => ((all * all + all) / (self.count as f64 * squares)).min(1.0),
            false => 1.0,
        }
    }

    /// The first `modes` modes at a bin.
    pub fn solve(&self, bin: usize, modes: usize) -> Vec<Solved> {
        let (rows, levels) = (self.rows(bin, None), self.levels(bin));
        let found = eigen(&rows.gram());
        let least = LEAST * found.values.iter().sum::<f64>();
        let of = |(vector, value): (&Vec<Complex<f64>>, &f64)| {
            let other = rows.combined(vector);
            let (shape, course) = match self.is_wide() {
                true => (&other[..self.n_sites], &vector[..]),
                false => (&vector[..], &other[..self.count]),
            };
            let energy: f64 = shape.iter().map(Complex::norm_sqr).sum();
            let larger = |a: Complex<f64>, b: Complex<f64>| match b.norm_sqr() > a.norm_sqr() {
                true => b,
                false => a,
            };
            let largest = shape.iter().copied().reduce(larger).unwrap_or_default();
            let turn = match *value > least {
                true => largest.conj() / (largest.norm() * energy.sqrt()),
                false => f64::NAN.into(),
            };
            let shape: Vec<Complex<f64>> = shape.iter().map(|z| z * turn).collect();
            let coherent = shape.iter().zip(&levels);
            let coherent = coherent.map(|(z, level)| (z * level).norm_sqr());
            let of_powers = |n: i32| -> f64 { course.iter().map(|a| a.norm_sqr().powi(n)).sum() };
            Solved {
                related: value * coherent.sum::<f64>(),
                unsteadiness: self.count as f64 * of_powers(2) / of_powers(1).powi(2) - 1.0,
                shape,
            }
        };
        let pairs = found.vectors.iter().zip(&found.values);
        pairs.take(modes).map(of).collect()
    }

    fn is_wide(&self) -> bool {
        self.count <= self.n_sites
    }

    fn at(&self, bin: usize, site: usize, realisation: usize) -> Complex<f64> {
        let [re, im] = &self.tiles[site / WIDTH][bin * self.count + realisation];
        Complex::new(re.0[site % WIDTH], im.0[site % WIDTH])
    }

    /// What the realisations of each site are multiplied by to have the power 1; 0 of sites whose power is rounding.
    fn levels(&self, bin: usize) -> Vec<f64> {
        let power = |site: usize| -> f64 {
            let all = (0..self.count).map(|r| self.at(bin, site, r).norm_sqr());
            all.sum()
        };
        let powers: Vec<f64> = (0..self.n_sites).map(power).collect();
        let least = LEAST * powers.iter().sum::<f64>();
        let level = |power: f64| match power > least {
            true => power.sqrt().recip(),
            false => 0.0,
        };
        powers.into_iter().map(level).collect()
    }

    /// A row a realisation, or a site where there are fewer, with sites multiplied by their levels.
    fn rows(&self, bin: usize, levels: Option<&[f64]>) -> Rows {
        let at = |site: usize, r: usize| {
            self.at(bin, site, r) * levels.map_or(1.0, |levels| levels[site])
        };
        match self.is_wide() {
            true => Rows::of(self.count, self.n_sites, |r, site| at(site, r)),
            false => Rows::of(self.n_sites, self.count, at),
        }
    }
}

/// Rows of complex numbers, padded with zeros to whole blocks.
struct Rows(Vec<Vec<Cell>>);

impl Rows {
    fn of(count: usize, columns: usize, at: impl Fn(usize, usize) -> Complex<f64>) -> Rows {
        let mut rows = vec![vec![Cell::default(); columns.div_ceil(WIDTH)]; count];
        for (row, cells) in rows.iter_mut().enumerate() {
            for column in 0..columns {
                let [re, im] = &mut cells[column / WIDTH];
                let x = at(row, column);
                (re.0[column % WIDTH], im.0[column % WIDTH]) = (x.re, x.im);
            }
        }
        Rows(rows)
    }

    /// `G_kl = sum_c X_kc* X_lc`.
    fn gram(&self) -> Array2<Complex<f64>> {
        let count = self.0.len();
        let mut gram = Array2::zeros((count, count));
        // Two rows with two others; an odd last one is taken twice.
        let pair = |k: usize| [k, (k + 1).min(count - 1)];
        for k in (0..count).step_by(2) {
            for l in (0..=k).step_by(2) {
                let products = widest(Products(
                    [pair(k), pair(l)].map(|p| p.map(|k| &self.0[k][..])),
                ));
                for (row, products) in pair(k).into_iter().zip(products) {
                    for (column, product) in pair(l).into_iter().zip(products) {
                        gram[[row, column]] = product;
                        gram[[column, row]] = product.conj();
                    }
                }
            }
        }
        gram
    }

    /// `sum_k v_k* X_kc*` of all columns.
    fn combined(&self, vector: &[Complex<f64>]) -> Vec<Complex<f64>> {
        let term = |c: usize| -> Complex<f64> {
            let part = |(v, row): (&Complex<f64>, &Vec<Cell>)| {
                let [re, im] = row[c / WIDTH].map(|block| block.0[c % WIDTH]);
                (v * Complex::new(re, im)).conj()
            };
            vector.iter().zip(&self.0).map(part).sum()
        };
        (0..WIDTH * self.0[0].len()).map(term).collect()
    }
}

/// `sum_c X_kc* X_lc` of two rows k with two rows l.
struct Products<'a>([[&'a [Cell]; 2]; 2]);

impl SimdKernel for Products<'_> {
    type Output = [[Complex<f64>; 2]; 2];

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Products([[p, q], [s, t]]) = self;
        let zero = L::splat(0.0);
        let mut sums = [[[zero; 2]; 2]; 2];
        let leaves = p.chunks(LEAF).zip(q.chunks(LEAF));
        let others = s.chunks(LEAF).zip(t.chunks(LEAF));
        for ((p, q), (s, t)) in leaves.zip(others) {
            let mut leaf = [[[zero; 2]; 2]; 2];
            for ((p, q), (s, t)) in p.iter().zip(q).zip(s.iter().zip(t)) {
                for (x, leaf) in [p, q].into_iter().zip(&mut leaf) {
                    let [re, im] = [L::load(&x[0]), L::load(&x[1])];
                    for (y, leaf) in [s, t].into_iter().zip(leaf) {
                        let [y_re, y_im] = [L::load(&y[0]), L::load(&y[1])];
                        leaf[0] = im.fused(y_im, re.fused(y_re, leaf[0]));
                        leaf[1] = (zero - im).fused(y_re, re.fused(y_im, leaf[1]));
                    }
                }
            }
            for (sum, leaf) in sums.iter_mut().flatten().zip(leaf.iter().flatten()) {
                *sum = [sum[0] + leaf[0], sum[1] + leaf[1]];
            }
        }
        let mut found = [[Complex::default(); 2]; 2];
        for (found, [re, im]) in found.iter_mut().flatten().zip(sums.into_iter().flatten()) {
            *found = Complex::new(re.sum(), im.sum());
        }
        found
    }
}
