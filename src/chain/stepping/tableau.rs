//! The methods as data: coefficients, order, source.

use crate::numeric::lanes::LaneBlock;

/// The coefficients of an embedded explicit pair as they are printed: numbers and fractions between blanks.
struct Pair {
    order: u32,
    /// Order of the embedded velocity.
    embedded_order: u32,
    c: &'static str,
    a: &'static [&'static str],
    /// Weights of the velocity; those of the embedded one, or of the error where they are printed in their place.
    bp: &'static str,
    embedded: &'static str,
    error: &'static str,
}

/// For `x'' = f(x)`: `k_i = f(x + c_i h v + h^2 sum a_ij k_j)`, `v1 = v + h sum bp_i k_i`; the last stage, at
/// the position at the end, is the next step's first.
///
/// Source: J. R. Dormand, M. E. A. El-Mikkawy, P. J. Prince, High-order embedded
/// Runge-Kutta-Nystrom formulae, IMA Journal of Numerical Analysis 7 (1987) 423-430, RKN8(6)9FM.
const NYSTROM_8_6: Pair = Pair {
    order: 8,
    embedded_order: 6,
    c: "0 1/20 1/10 3/10 1/2 7/10 9/10 1 1",
    a: &[
        "",
        "1/800",
        "1/600 1/300",
        "9/200 -9/100 9/100",
        "-66701/197352 28325/32892 -2665/5482 2170/24669",
        "227015747/304251000 -54897451/30425100 12942349/10141700 -9499/304251 539/9250",
        "-1131891597/901789000 41964921/12882700 -6663147/3220675 270954/644135 -108/5875 114/1645",
        "13836959/3667458 -17731450/1833729 1063919505/156478208 -33213845/39119552 13335/28544 -705/14272 1645/57088",
        "223/7938 0 1175/8064 925/6048 41/448 925/14112 1175/72576 0",
    ],
    bp: "223/7938 0 5875/36288 4625/21168 41/224 4625/21168 5875/36288 223/7938 0",
    embedded: "7987313/109941300 0 1610737/40207104 10023263/23454144 -497221/6204800 10023263/23454144 \
               1610737/40207104 -4251941/54970650 3/20",
    error: "",
};

/// For `y' = f(y)`: `k_i = f(y + h sum a_ij k_j)`, `y1 = y + h sum bp_i k_i`.
///
/// Source: E. Hairer, S. P. Norsett, G. Wanner, *Solving Ordinary Differential Equations I*, second
/// edition (1993), section II.10, DOP853 with its fifth-order estimate.
const RUNGE_KUTTA_8_5: Pair = Pair {
    order: 8,
    embedded_order: 5,
    c: "0 0.05260015195876773 0.0789002279381516 0.1183503419072274 0.2816496580927726 0.3333333333333333 0.25 \
        0.3076923076923077 0.6512820512820513 0.6 0.8571428571428571 1",
    a: &[
        "",
        "0.05260015195876773",
        "0.0197250569845379 0.0591751709536137",
        "0.02958758547680685 0 0.08876275643042054",
        "0.2413651341592667 0 -0.8845494793282861 0.924834003261792",
        "0.037037037037037035 0 0 0.17082860872947386 0.12546768756682242",
        "0.037109375 0 0 0.17025221101954405 0.06021653898045596 -0.017578125",
        "0.03709200011850479 0 0 0.17038392571223998 0.10726203044637328 -0.015319437748624402 0.008273789163814023",
        "0.6241109587160757 0 0 -3.3608926294469414 -0.868219346841726 27.59209969944671 20.154067550477894 \
         -43.48988418106996",
        "0.47766253643826434 0 0 -2.4881146199716677 -0.590290826836843 21.230051448181193 15.279233632882423 \
         -33.28821096898486 -0.020331201708508627",
        "-0.9371424300859873 0 0 5.186372428844064 1.0914373489967295 -8.149787010746927 -18.52006565999696 \
         22.739487099350505 2.4936055526796523 -3.0467644718982196",
        "2.273310147516538 0 0 -10.53449546673725 -2.0008720582248625 -17.9589318631188 27.94888452941996 \
         -2.8589982771350235 -8.87285693353063 12.360567175794303 0.6433927460157636",
    ],
    bp: "0.054293734116568765 0 0 0 0 4.450312892752409 1.8915178993145003 -5.801203960010585 0.3111643669578199 \
         -0.1521609496625161 0.20136540080403034 0.04471061572777259",
    embedded: "",
    error: "0.01312004499419488 0 0 0 0 -1.2251564463762044 -0.4957589496572502 1.6643771824549864 \
            -0.35032884874997366 0.3341791187130175 0.08192320648511571 -0.022355307863886294",
};

/// A symmetric composition of kicks and drifts: `kick b_1, drift a_1, kick b_2, ...` and back.
#[derive(Debug)]
pub(crate) struct Composition {
    order: u32,
    /// The first half of the kicks, and of the drifts, each without its last one: all add up to 1.
    kicks: &'static str,
    drifts: &'static str,
    /// Whether the one in the middle is a drift.
    middle_drift: bool,
}

/// Source: L. Verlet, Physical Review 159 (1967) 98-103.
pub(crate) const VERLET: Composition = Composition {
    order: 2,
    kicks: "",
    drifts: "",
    middle_drift: true,
};

/// Source: S. Blanes, P. C. Moan, Practical symplectic partitioned Runge-Kutta and
/// Runge-Kutta-Nystrom methods, Journal of Computational and Applied Mathematics 142 (2002)
/// 313-330, table 3, SRKN_6^b.
pub(crate) const SYMPLECTIC_4: Composition = Composition {
    order: 4,
    kicks: "0.0829844064174052 0.396309801498368 -0.0390563049223486",
    drifts: "0.245298957184271 0.604872665711080",
    middle_drift: false,
};

/// Source: as [`SYMPLECTIC_4`], SRKN_11^b.
pub(crate) const SYMPLECTIC_6: Composition = Composition {
    order: 6,
    kicks: "0.0414649985182624 0.198128671918067 -0.0400061921041533 0.0752539843015807 -0.0115113874206879",
    drifts: "0.123229775946271 0.290553797799558 -0.127049212625417 -0.246331761062075 0.357208872795928",
    middle_drift: true,
};

impl Composition {
    /// As a Nystrom method: its stages are the kicks, between which the sites fly. Velocities of stages are those in the
    /// middle of a kick, during which the force is constant.
    pub(crate) fn tableau(&self) -> Tableau {
        let kicks = whole(self.kicks, !self.middle_drift);
        let mut c = vec![0.0];
        for drift in whole(self.drifts, self.middle_drift) {
            c.push(c[c.len() - 1] + drift);
        }
        let last = kicks.len() - 1;
        c[last] = 1.0;
        let before = |i: usize| weights((0..i).map(|j| kicks[j] * (c[i] - c[j])));
        let middle = |i: usize| {
            let half = |j: usize| if j == i { 0.5 } else { 1.0 };
            weights((0..=i).map(|j| half(j) * kicks[j]))
        };
        let a: Vec<Weights> = (0..=last).map(before).collect();
        Tableau {
            order: self.order,
            embedded_order: 0,
            b: a[last].clone(),
            velocity: (0..=last).map(middle).collect(),
            bp: weights(kicks.iter().copied()),
            error: kicks.iter().map(|_| 0.0).enumerate().collect(),
            nodes: LaneBlock::default(),
            a,
            c,
        }
    }
}

/// A first half without its last number, and its mirror image, with one number in the middle or two; all add up to 1.
fn whole(half: &str, has_middle: bool) -> Vec<f64> {
    let mut half = numbers(half);
    let sum = half.iter().sum::<f64>();
    half.push(if has_middle {
        1.0 - 2.0 * sum
    } else {
        0.5 - sum
    });
    let back = half.iter().rev().skip(usize::from(has_middle));
    half.iter().chain(back).copied().collect()
}

/// Stages of the largest method here, the one at the step's end included.
pub(crate) const MOST_STAGES: usize = 13;

/// An embedded pair in the form the stepping uses, for `x'' = f(x, v)`.
#[derive(Debug)]
pub(crate) struct Tableau {
    pub(crate) order: u32,
    pub(crate) embedded_order: u32,
    pub(crate) c: Vec<f64>,
    /// Weights of the earlier stages in each stage's position.
    pub(crate) a: Vec<Weights>,
    /// Weights in each stage's velocity. Where the method itself has none, they integrate the
    /// polynomial through all stages with a weight, for use once the step is done.
    pub(crate) velocity: Vec<Weights>,
    pub(crate) b: Weights,
    /// Weights of the velocity; for the same stages as those of its error, zeros included.
    pub(crate) bp: Weights,
    /// Weights of the error estimate of the velocity.
    pub(crate) error: Weights,
    /// Nodes of the stages of `bp`, of which pairs have eight.
    pub(crate) nodes: LaneBlock,
}

/// Stage and weight, zero weights left out.
pub(crate) type Weights = Vec<(usize, f64)>;

/// The numbers of a row.
fn numbers(row: &str) -> Vec<f64> {
    let value = |typed: &str| typed.parse().unwrap_or(f64::NAN);
    let number = |typed: &str| match typed.split_once('/') {
        Some((above, below)) => value(above) / value(below),
        None => value(typed),
    };
    row.split_whitespace().map(number).collect()
}

impl Pair {
    fn tableau(&self, a: Vec<Weights>, velocity: Vec<Weights>) -> Tableau {
        let mut c = numbers(self.c);
        c.resize(a.len(), 1.0);
        let bp = numbers(self.bp);
        let mut error = numbers(self.error);
        let pairs = bp.iter().zip(numbers(self.embedded));
        error.extend(pairs.map(|(bp, embedded)| bp - embedded));
        let together = |of: &[f64]| -> Weights {
            let counts = |i: &usize| bp[*i] != 0.0 || error[*i] != 0.0;
            (0..of.len()).filter(counts).map(|i| (i, of[i])).collect()
        };
        let (bp, error) = (together(&bp), together(&error));
        let nodes = LaneBlock(std::array::from_fn(|i| c[bp[i].0]));
        Tableau {
            order: self.order,
            embedded_order: self.embedded_order,
            b: a.last().cloned().unwrap_or_default(),
            error,
            bp,
            nodes,
            a,
            velocity,
            c,
        }
    }
}

impl Tableau {
    /// The Nystrom pair 8(6), for forces without damping.
    pub(crate) fn nystrom_8_6() -> Tableau {
        let pair = &NYSTROM_8_6;
        let (c, bp) = (numbers(pair.c), numbers(pair.bp));
        let nodes: Vec<usize> = (0..c.len()).filter(|&i| bp[i] != 0.0).collect();
        let velocity = |end: &f64| -> Weights {
            let weight = |&j: &usize| (j, integral_of_lagrange(&c, &nodes, j, *end));
            nodes.iter().map(weight).collect()
        };
        let a = pair.a.iter().map(|row| weights(numbers(row)));
        pair.tableau(a.collect(), c.iter().map(velocity).collect())
    }

    /// The Runge-Kutta pair 8(5), for any force; a last stage at the step's end is added.
    pub(crate) fn runge_kutta_8_5() -> Tableau {
        let pair = &RUNGE_KUTTA_8_5;
        let rows = pair.a.iter().chain([&pair.bp]);
        let rows: Vec<Vec<f64>> = rows.map(|row| numbers(row)).collect();
        let squared = |row: &Vec<f64>| -> Weights {
            weights((0..row.len()).map(|l| {
                let terms = row.iter().enumerate().skip(l + 1);
                terms.map(|(j, w)| w * rows[j][l]).sum()
            }))
        };
        let velocity = rows.iter().cloned().map(weights);
        pair.tableau(rows.iter().map(squared).collect(), velocity.collect())
    }

    pub(crate) fn stages(&self) -> usize {
        self.c.len()
    }
}

fn weights(row: impl IntoIterator<Item = f64>) -> Weights {
    let row = row.into_iter().enumerate();
    row.filter(|(_, w)| *w != 0.0).collect()
}

/// Integral from 0 to `end` of the polynomial that is 1 at `c[one]`, 0 at the other nodes.
pub(crate) fn integral_of_lagrange(c: &[f64], nodes: &[usize], one: usize, end: f64) -> f64 {
    let mut power = vec![1.0];
    let mut scale = 1.0;
    for &j in nodes.iter().filter(|&&j| j != one) {
        scale *= c[one] - c[j];
        power.push(0.0);
        for n in (1..power.len()).rev() {
            power[n] = power[n - 1] - c[j] * power[n];
        }
        power[0] *= -c[j];
    }
    let sum = power
        .iter()
        .enumerate()
        .rfold(0.0, |sum, (n, p)| sum * end + p / (n + 1) as f64);
    sum * end / scale
}
