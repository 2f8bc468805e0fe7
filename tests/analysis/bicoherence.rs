//! Bicoherence against pybispectra and NumPy, its distribution without coupling, and couplings that are known.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use ndarray::{Array2, s};
use test_support::estimate::bicoherence;
use test_support::fields::Congruential;
use test_support::{lies, near, share, worst};
use wavecascade::Field;
use wavecascade::estimates::Bicoherence;
use wavecascade::sheet::Describe;

use crate::peers::{compare, record};

fn found(words: &str, values: Array2<f64>) -> Bicoherence {
    bicoherence(words, [&Field::from_array(values)]).unwrap()
}

#[test]
fn val_pybispectra_and_numpy_bicoherence() {
    compare("pybispectra");
    // Along x the same triples are gathered at their sum.
    let words = "segment=32 overlap=16 sites=0 output=";
    let [own, cross] = [0, 1].map(|output| {
        let record = record("squares 1000 2");
        bicoherence(&format!("{words}{output}"), [&record]).unwrap()
    });
    for row in 4..16 {
        let all = own.map.bins.iter().zip(&own.map.bicoherence);
        let of_bin = all.filter(|(bins, _)| bins[2] == row as isize);
        let of_bin = of_bin.map(|(_, b)| *b);
        near(cross.along.summed[[row, 0]], of_bin.clone().sum(), 1e-13);
        near(cross.along.largest[[row, 0]], worst(of_bin), 2e-14);
    }
    let outside = [3, 16].map(|row| cross.along.largest[[row, 0]].is_nan());
    assert_eq!(outside, [true; 2]);
}

/// Without coupling: the mean is 1 / K, one cell in twenty (a hundred) is above 2.96 / K (4.45 / K) of many
/// realisations, and one map in twenty has a cell above its level. Overlapping segments count by their
/// effective number.
#[test]
fn val_elgar_guza_levels_without_coupling() {
    for (overlap, window) in [(0, "none"), (16, "hann"), (24, "hann")] {
        let (segments, sites) = (96, 400);
        let count = 32 + (segments - 1) * (32 - overlap);
        let values = Congruential(7).white(count, sites);
        let words = format!("segment=32 overlap={overlap} window={window} detrend=none");
        let mut cells = Vec::new();
        let [mut maps, mut said, mut doubted, mut even] = [0.0; 4];
        for column in values.axis_chunks_iter(ndarray::Axis(1), 1) {
            let found = found(&words, column.to_owned());
            let k = found.independence.effective;
            let level = found.cell_level().unwrap() * k;
            cells.extend(found.map.bicoherence.iter().map(|b| (b * k, level)));
            maps += f64::from(found.above(found.map_level().unwrap()) > 0);
            let answer = found.describe().answer;
            said += f64::from(answer.contains(" are coupled with") && !answer.starts_with("no "));
            doubted += f64::from(answer.contains(" may be coupled with"));
            even += f64::from(found.chance(worst(found.map.bicoherence.iter().copied())) < 0.5);
        }
        let sum: f64 = cells.iter().map(|(b, _)| b).sum();
        near(sum / cells.len() as f64, 1.0, 0.015);
        near(share(cells.iter().map(|(b, level)| b > level)), 0.05, 0.005);
        near(share(cells.iter().map(|(b, _)| *b > 2.96)), 0.05, 0.0075);
        near(share(cells.iter().map(|(b, _)| *b > 4.45)), 0.01, 0.002);
        let [maps, said, doubted, even] = [maps, said, doubted, even].map(|n| n / sites as f64);
        lies(maps, 0.03..0.08);
        // The word is said in a hundredth of the fields at most, the doubt in the other four.
        lies(said, 0.0..0.02);
        near(said + doubted, maps, 1e-12);
        lies(even, 0.42..0.58);
        // Along x, of all sites.
        let along = found(&format!("{words} sites=0..{sites}"), values).along;
        for (values, level) in [
            (&along.summed, &along.summed_level),
            (&along.largest, &along.largest_level),
        ] {
            let [values, level] = [values, level].map(|all| all.slice(s![6..14, ..]));
            let above = values.iter().zip(level).map(|(b, level)| b > level);
            lies(share(above), 0.04..0.06);
        }
    }
}

/// Two tones with random phases and their product, of a part of the power at their sum: bicoherence and
/// biphase are known, and nothing else is above the level of the map.
#[test]
fn val_constructed_coupling_has_its_share_and_biphase() {
    let (length, segments) = (64, 400);
    let (first, second) = (11, 6);
    for (share, biphase) in [(1.0f64, 0.0), (0.6, FRAC_PI_2), (0.3, -2.0)] {
        let mut random = Congruential(3);
        let mut values = Array2::zeros((length * segments, 2));
        for mut segment in values.exact_chunks_mut((length, 2)) {
            let [a, b, c] = [0; 3].map(|_| PI * random.uniform());
            for (n, mut row) in segment.rows_mut().into_iter().enumerate() {
                let angle = |bin: i32| TAU * f64::from(bin) * n as f64 / length as f64;
                let coupled = (angle(first + second) + a + b - biphase).cos();
                let free = (angle(first + second) + c).cos();
                let tones = (angle(first) + a).cos() + (angle(second) + b).cos();
                let sum = share.sqrt() * coupled + (1.0 - share).sqrt() * free;
                row[0] = tones + sum + 2e-2 * random.normal();
                // The difference, in the next site.
                let difference = (angle(first - second) + a - b - biphase).cos();
                row[1] = difference + 2e-2 * random.normal();
            }
        }
        let of = |output: usize| {
            let words = format!("segment=64 overlap=0 window=none output={output}");
            let all = found(&words, values.clone()).strongest(10);
            assert_eq!(all.len(), 1, "{all:?}");
            (all[0].frequencies.map(|f| f * length as f64), all[0])
        };
        let (bins, own) = of(0);
        assert_eq!(bins, [11.0, 6.0, 17.0]);
        near(own.bicoherence, share, 0.05);
        let half = own.biphase_interval + 1e-3;
        near(own.biphase, biphase, half.min(0.12));
        let (bins, cross) = of(1);
        assert_eq!(bins, [11.0, -6.0, 5.0]);
        near(cross.bicoherence, 1.0, 0.01);
        near(cross.biphase, biphase, 0.02);
    }
}

/// Pulses that repeat: every triple is coupled completely.
#[test]
fn regress_never_above_one() {
    let pulse = |n: usize| (-((n % 64) as f64 - 20.0).powi(2) / 8.0).exp();
    let values = Array2::from_shape_fn((64 * 20, 2), |(n, j)| pulse(n) * (1.0 + j as f64));
    let words = "segment=64 overlap=0 window=none sites=0,1 output=1";
    let found = found(words, values);
    let known = found.map.bicoherence.iter().filter(|b| b.is_finite());
    assert!(known.clone().count() > 100);
    assert!(known.clone().all(|b| (1.0 - 1e-9..=1.0).contains(b)));
    assert!(found.along.largest.iter().all(|b| b.is_nan() || *b <= 1.0));
}
