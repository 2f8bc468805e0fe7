//! What unrelated sites have in common by chance.

use crate::numeric::chi_square_level;

/// The distribution of Tracy and Widom for complex entries is nearly that of Gamma with this shape and scale, shifted.
const SHAPE: f64 = 79.6595;
const SCALE: f64 = 0.101037;
const SHIFT: f64 = 9.81961;

/// What the largest eigenvalue of the coherencies exceeds with probability `chance`, where no site is related to another.
///
/// # Equation
/// The coherencies `C_ij = S_ij / sqrt(S_ii S_jj)` of n sites know neither levels nor spectra. If levels were known and did not
/// have to be estimated, the largest eigenvalue of K independent realisations would exceed
///
/// ```text
/// t = (q^2 + s q (1 / sqrt K + 1 / sqrt n)^(1/3)) / K,    q = sqrt K + sqrt n,
/// ```
///
/// with s of the distribution of Tracy and Widom. Levels that are set to 1 take from t what sites are louder by chance: half of
/// what the mean of n K powers exceeds, `t / (1 + sqrt(2 ln(1 / chance) / (n K)) / 2)`. (Of 2 to 64 sites and 4 to 60
/// realisations this is exceeded 0.1 to 1.2 times as often as stated, at chances from 0.05 to 1e-4.) Nor can the eigenvalue exceed
/// `1 + (n - 1) g`, with the largest coherence `g^2` of any two sites, which is exact for two.
///
/// Segments that overlap are alike, also in phase: with `v = R / K - 1` of R realisations that count as K in a mean, the
/// eigenvalue is that of `R / (1 + v (1 + sqrt(n / R)))` realisations, to first order in v, but of no fewer than
/// `R / (1 + sqrt(2 v))`: the largest eigenvalue of neighbours whose correlation is r is `1 + 2 r`, and `v = 2 r^2`.
///
/// # Shapes
/// Numbers.
///
/// # Units
/// None: eigenvalues of n sites sum up to n.
///
/// # Errors
/// None.
///
/// # Source
/// C. A. Tracy, H. Widom, Commun. Math. Phys. 159, 151 (1994); I. M. Johnstone, Ann. Stat. 29, 295 (2001); Z. Bao, G. Pan, W.
/// Zhou, Electron. J. Probab. 17, 88 (2012) for coherencies; M. Chiani, J. Multivar. Anal. 129, 69 (2014) for Gamma; J. W.
/// Silverstein, Z. D. Bai, J. Multivar. Anal. 54, 175 (1995) for realisations that are alike.
pub(super) fn largest_of_unrelated(
    sites: usize,
    independent: f64,
    overlap: f64,
    chance: f64,
) -> f64 {
    let n = sites as f64;
    let all = independent * (1.0 + overlap);
    let alike = overlap * (1.0 + (n / all).sqrt());
    let realisations = all / (1.0 + alike.min((2.0 * overlap).sqrt()).max(overlap));
    let pairs = 0.5 * n * (n - 1.0);
    let of_pairs = (chance / pairs).powf(1.0 / (realisations - 1.0).max(f64::MIN_POSITIVE));
    let most = 1.0 + (n - 1.0) * (1.0 - of_pairs).sqrt();
    let s = 0.5 * SCALE * chi_square_level(chance, 2.0 * SHAPE) - SHIFT;
    let (root_n, root_k) = (n.sqrt(), realisations.sqrt());
    let q = root_n + root_k;
    let known = (q * q + s * q * (root_n.recip() + root_k.recip()).cbrt()) / realisations;
    let louder = 0.5 * (-2.0 * chance.ln() / (n * realisations)).sqrt();
    most.min(known / (1.0 + louder))
}
