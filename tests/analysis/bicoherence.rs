//! Bicoherence against pybispectra and NumPy (`data/bicoherence.json`, made by `data/make_bicoherence.py`), its
//! distribution without coupling, and couplings that are known.

use std::f64::consts::{FRAC_PI_2, TAU};

use ndarray::{Array2, s};
use serde::Deserialize;
use test_support::changed;
use test_support::fields::{Congruential, averaging};
use wavecascade::Field;
use wavecascade::estimates::{Averaging, Bicoherence, BicoherenceRequest, Tapers, bicoherence};
use wavecascade::observer::Silent;
use wavecascade::prepare::{Detrend, Window};
use wavecascade::sheet::Describe;

fn request(length: usize, overlap: usize) -> BicoherenceRequest {
    BicoherenceRequest {
        averaging: averaging(length, overlap),
        ..BicoherenceRequest::default()
    }
}

fn found(values: Array2<f64>, request: &BicoherenceRequest) -> Bicoherence {
    bicoherence(&[&Field::from_array(values)], request, &Silent).unwrap()
}

#[derive(Deserialize)]
struct Expected {
    bins: Vec<[isize; 3]>,
    bicoherence: Vec<f64>,
    biphase: Vec<f64>,
}

#[derive(Deserialize)]
struct Reference {
    own: Expected,
    cross: Expected,
}

#[test]
fn val_pybispectra_and_numpy_bicoherence() {
    let reference: Reference =
        serde_json::from_str(include_str!("../data/bicoherence.json")).unwrap();
    let (mut a, mut b) = (Congruential(1), Congruential(2));
    let a: Vec<f64> = (0..1000).map(|_| a.uniform()).collect();
    let b: Vec<f64> = (0..1000).map(|_| b.uniform()).collect();
    let values = Array2::from_shape_fn((1000, 2), |(n, j)| match j {
        0 => a[n] + 0.5 * a[n] * a[n],
        _ => a[(n + 999) % 1000].powi(2) + 0.3 * b[n],
    });
    for (expected, output) in [(&reference.own, 0), (&reference.cross, 1)] {
        let request = BicoherenceRequest {
            output: Some(output),
            along: vec![0],
            ..request(32, 16)
        };
        let found = found(values.clone(), &request);
        assert_eq!(found.map.bins, expected.bins);
        let mut worst = [0.0f64; 2];
        for (cell, (b, phase)) in expected
            .bicoherence
            .iter()
            .zip(&expected.biphase)
            .enumerate()
        {
            worst[0] = worst[0].max((found.map.bicoherence[cell] - b).abs());
            // The phase of nothing is rounding.
            if *b > 1e-3 {
                let difference = found.map.biphase[cell] - phase;
                worst[1] = worst[1].max((difference / 2.0).sin().abs());
            }
        }
        println!("bicoherence {:e}, biphase {:e}", worst[0], worst[1]);
        assert!(worst[0] < 1e-15 && worst[1] < 1e-14, "{worst:?}");
        if output == 0 {
            continue;
        }
        // Along x the same triples are gathered at their sum.
        let of_bin = |third: isize| {
            let cells = reference.own.bins.iter().zip(&reference.own.bicoherence);
            cells
                .filter(move |(bins, _)| bins[2] == third)
                .map(|(_, b)| *b)
        };
        for third in 4..16 {
            let along = &found.along;
            let row = third as usize;
            let sum: f64 = of_bin(third).sum();
            let largest = of_bin(third).fold(0.0, f64::max);
            assert!((along.summed[[row, 0]] - sum).abs() < 1e-13);
            assert!((along.largest[[row, 0]] - largest).abs() < 2e-14);
        }
        assert!(found.along.largest[[3, 0]].is_nan() && found.along.largest[[16, 0]].is_nan());
    }
}

/// Without coupling: the mean is 1 / K, one cell in twenty (a hundred) is above 2.96 / K (4.45 / K) of many
/// realisations, and one map in twenty has a cell above its level. Overlapping segments count by their
/// effective number.
#[test]
fn val_elgar_guza_levels_without_coupling() {
    for (overlap, window) in [(0, Window::None), (16, Window::Hann), (24, Window::Hann)] {
        let (segments, sites) = (96, 400);
        let count = 32 + (segments - 1) * (32 - overlap);
        let mut noise = Congruential(7);
        let values = Array2::from_shape_fn((count, sites), |_| noise.gaussian());
        let all = BicoherenceRequest {
            averaging: Averaging {
                tapers: Tapers::Window(window),
                detrend: Detrend::None,
                ..averaging(32, overlap)
            },
            along: (0..sites).collect(),
            ..BicoherenceRequest::default()
        };
        let mut shares = [0.0; 3];
        let (mut mean, mut cells, mut maps) = (0.0, 0.0, 0.0);
        let [mut said, mut doubted, mut even] = [0.0; 3];
        let mut sums = [0.0; 2];
        for site in 0..sites {
            let column = values.slice(s![.., site..=site]).to_owned();
            let along = if site == 0 { values.clone() } else { column };
            let request = BicoherenceRequest {
                along: if site == 0 {
                    all.along.clone()
                } else {
                    Vec::new()
                },
                ..all.clone()
            };
            let found = found(along, &request);
            let k = found.independence.effective;
            for b in &found.map.bicoherence {
                mean += b * k;
                cells += 1.0;
                for (share, level) in
                    shares
                        .iter_mut()
                        .zip([found.cell_level().unwrap(), 2.96 / k, 4.45 / k])
                {
                    *share += f64::from(*b > level);
                }
            }
            maps += f64::from(found.above(found.map_level().unwrap()) > 0);
            let answer = found.describe().answer;
            said += f64::from(answer.contains(" are coupled with") && !answer.starts_with("no "));
            doubted += f64::from(answer.contains(" may be coupled with"));
            let largest = found.map.bicoherence.iter().copied().fold(0.0, f64::max);
            even += f64::from(found.chance(largest) < 0.5);
            if site == 0 {
                let along = &found.along;
                let rows = 6..14;
                for j in 0..sites {
                    for m in rows.clone() {
                        sums[0] += f64::from(along.summed[[m, j]] > along.summed_level[[m, j]]);
                        sums[1] += f64::from(along.largest[[m, j]] > along.largest_level[[m, j]]);
                    }
                }
                println!("{k} effective of {}", found.independence.segments);
            }
        }
        let [cell, five, one] = shares.map(|share| share / cells);
        let [maps, said, doubted, even] =
            [maps, said, doubted, even].map(|count| count / sites as f64);
        let [summed, largest] = sums.map(|share| share / (8 * sites) as f64);
        println!(
            "overlap {overlap}: mean K b^2 {}, above {cell} {five} {one}, maps {maps}, sums {summed}, largest {largest}",
            mean / cells
        );
        assert!((mean / cells - 1.0).abs() < 0.015, "{}", mean / cells);
        assert!((cell / 0.05 - 1.0).abs() < 0.1, "{cell}");
        assert!((five / 0.05 - 1.0).abs() < 0.15, "{five}");
        assert!((one / 0.01 - 1.0).abs() < 0.2, "{one}");
        println!("said {said}, doubted {doubted}, below one half {even}");
        assert!((0.03..0.08).contains(&maps), "{maps}");
        // The word is said in a hundredth of the fields at most, the doubt in the other four.
        assert!((0.0..0.02).contains(&said), "{said}");
        assert!((said + doubted - maps).abs() < 1e-12, "{doubted}");
        assert!((0.42..0.58).contains(&even), "{even}");
        assert!((0.04..0.06).contains(&summed), "{summed}");
        assert!((0.04..0.06).contains(&largest), "{largest}");
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
        for segment in 0..segments {
            let [a, b, c] = [0; 3].map(|_| std::f64::consts::PI * random.uniform());
            for n in 0..length {
                let angle = |bin: i32| TAU * f64::from(bin) * n as f64 / length as f64;
                let coupled = (angle(first + second) + a + b - biphase).cos();
                let free = (angle(first + second) + c).cos();
                let tones = (angle(first) + a).cos() + (angle(second) + b).cos();
                let noise = [1e-2, 1e-2].map(|size| size * random.gaussian());
                let sum = share.sqrt() * coupled + (1.0 - share).sqrt() * free;
                values[[segment * length + n, 0]] = tones + sum + noise[0];
                // The difference, in the next site.
                let difference = (angle(first - second) + a - b - biphase).cos();
                values[[segment * length + n, 1]] = difference + noise[1];
            }
        }
        let request = BicoherenceRequest {
            averaging: Averaging {
                tapers: Tapers::Window(Window::None),
                ..averaging(length, 0)
            },
            ..BicoherenceRequest::default()
        };
        let own = found(values.clone(), &request);
        let all = own.strongest(10);
        assert_eq!(all.len(), 1, "{all:?}");
        let df = 1.0 / length as f64;
        assert_eq!(all[0].frequencies, [11.0 * df, 6.0 * df, 17.0 * df]);
        println!("{share}: {:?}", all[0]);
        assert!((all[0].bicoherence - share).abs() < 0.05, "{:?}", all[0]);
        let off = (all[0].biphase - biphase).abs();
        assert!(off < all[0].biphase_interval + 1e-3, "{:?}", all[0]);
        assert!(off < 0.12, "{:?}", all[0]);
        let request = changed(request, |it| it.output = Some(1));
        let cross = found(values, &request);
        let all = cross.strongest(10);
        assert_eq!(all.len(), 1, "{all:?}");
        assert_eq!(all[0].frequencies, [11.0 * df, -6.0 * df, 5.0 * df]);
        assert!(all[0].bicoherence > 0.99 && (all[0].biphase - biphase).abs() < 0.02);
    }
}

#[test]
fn regress_never_above_one() {
    // Pulses that repeat: every triple is coupled completely.
    let pulse = |n: usize| (-((n % 64) as f64 - 20.0).powi(2) / 8.0).exp();
    let values = Array2::from_shape_fn((64 * 20, 2), |(n, j)| pulse(n) * (1.0 + j as f64));
    let request = BicoherenceRequest {
        averaging: Averaging {
            tapers: Tapers::Window(Window::None),
            ..averaging(64, 0)
        },
        along: vec![0, 1],
        output: Some(1),
        ..BicoherenceRequest::default()
    };
    let found = found(values, &request);
    let known = found.map.bicoherence.iter().filter(|b| b.is_finite());
    for b in known.clone() {
        assert!((1.0 - 1e-9..=1.0).contains(b), "{b}");
    }
    assert!(known.count() > 100);
    assert!(found.along.largest.iter().all(|b| b.is_nan() || *b <= 1.0));
}

#[test]
fn regress_one_transient_has_no_significance() {
    let values = Array2::from_shape_fn((2048, 6), |(n, j)| {
        let t = (n as f64 - 300.0 - 5.0 * j as f64) / 6.0;
        // An offset is no steady motion.
        (-t * t).exp() - 0.8
    });
    let request = changed(request(128, 64), |it| it.along = vec![0, 5]);
    let one = found(values.clone(), &request);
    assert!(one.independence.is_transient());
    assert!(one.cell_level().is_none() && one.map_level().is_none());
    assert!(one.strongest(5).is_empty());
    assert!(one.along.largest_level.iter().all(|level| level.is_nan()));
    assert_eq!(one.along.coupled_outputs(), [0, 0]);
    assert!(one.describe().answer.contains("cannot be told"));
    // Repeated, it has: as many as there are records.
    let field = Field::from_array(values);
    let shots = bicoherence(&[&field; 5], &request, &Silent).unwrap();
    assert_eq!(shots.independence.independent, Some(5.0));
    assert!((shots.cell_level().unwrap() - (1.0 - 0.05f64.powf(0.25))).abs() < 1e-15);
}

/// Amplitudes whose fourth powers would leave the range of numbers, or nearly so.
#[test]
fn regress_powers_of_two_do_not_move_a_bit() {
    let mut noise = Congruential(3);
    let values = Array2::from_shape_fn((600, 3), |_| noise.gaussian());
    let request = BicoherenceRequest {
        output: Some(2),
        along: vec![0, 1],
        ..request(64, 32)
    };
    let bits = |amplitude: f64| {
        let found = found(&values * amplitude, &request);
        let map = found.map.bicoherence.iter().chain(&found.map.biphase);
        let along = found.along.largest.iter().chain(&found.along.summed);
        map.chain(along).map(|v| v.to_bits()).collect::<Vec<_>>()
    };
    let expected = bits(1.0);
    assert!(expected.iter().any(|v| f64::from_bits(*v) > 0.1));
    for exponent in [-190, -40, 60, 190] {
        assert!(bits(2f64.powi(exponent)) == expected, "{exponent}");
    }
}

#[test]
fn regress_a_silent_site_has_no_triples() {
    let found = found(Array2::zeros((600, 1)), &request(64, 32));
    assert!(found.map.bicoherence.iter().all(|b| b.is_nan()) && found.cells() == 0);
    let coupling = found.describe().answer;
    assert!(coupling.contains("no triple"), "{coupling}");
}
