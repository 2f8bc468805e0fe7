//! Identities of budgets at any state, and budgets against their defining sums.

use std::f64::consts::PI;

use ndarray::{Array1, Array2};
use num_complex::Complex;
use test_support::changed;
use test_support::fields::{fixed, losses, spring};
use wavecascade::arrays::{Arrays, LargeArray};
use wavecascade::budget::{Budget, BudgetRequest, Filter, Integration, Motion, budget};
use wavecascade::chain::{Chain, Drive, Ends, Law, Losses, Waveform};

/// Numbers in -1..1 without a pattern (splitmix64).
fn noise(seed: u64, n: usize) -> impl Iterator<Item = f64> {
    (0..n as u64).map(move |i| {
        let mut z = (seed << 32)
            .wrapping_add(i)
            .wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    })
}

/// Random states in place of a trajectory: the identities hold for any states.
struct States {
    chain: Chain,
    drive: Option<Drive>,
    time: Array1<f64>,
    x: Array2<f64>,
    v: Array2<f64>,
}

impl States {
    fn new(chain: Chain, drive: Option<Drive>, seed: u64) -> States {
        let (samples, n) = (9, chain.n_sites());
        let array = |seed| Array2::from_shape_vec((samples, n), noise(seed, samples * n).collect());
        States {
            chain,
            drive,
            time: Array1::from_iter((0..samples).map(|i| 0.37 * i as f64)),
            x: array(seed).unwrap(),
            v: array(seed + 1).unwrap(),
        }
    }

    fn motion(&self) -> Motion<'_> {
        Motion {
            chain: &self.chain,
            drive: self.drive.as_ref(),
            time: self.time.view(),
            displacement: self.x.view(),
            velocity: self.v.view(),
            resonators: None,
            energy_passed: None,
            energy_lost: None,
            energy_input: None,
        }
    }

    fn budget(&self, request: &BudgetRequest) -> (Budget, Arrays) {
        budget(&self.motion(), request).unwrap()
    }
}

fn wavenumber_only() -> BudgetRequest {
    changed(BudgetRequest::default(), |it| {
        (it.views.frequency, it.views.scale) = (false, false);
    })
}

/// Chains of every law, end and loss.
fn chains() -> Vec<(Chain, Option<Drive>)> {
    let wave = Waveform::sine(0.3, 0.2);
    let lossy = losses([0.1, 0.05, 0.02]);
    let spring = spring(0.25, 0.1);
    let fixed = fixed(1.3);
    let mut all = Vec::new();
    // A dimer of so many bodies and this ratio with a change.
    let mut add = |n, ratio, drive, change: &dyn Fn(&mut Chain)| {
        all.push((changed(Chain::dimer(n, ratio), change), drive));
    };
    for n in [5, 6, 31, 100, 300] {
        for kappa in [1.0, 2.398, 1e6] {
            add(n, kappa, None, &|_| {});
            add(n, kappa, None, &|it| it.losses = lossy);
        }
        for drive in [Some(Drive::Force(wave.clone())), None] {
            add(n, 3.0, drive, &|it| {
                it.ends = Ends::Free;
                it.coefficient.pop();
            });
        }
        for losses in [lossy, Losses::default()] {
            add(n + n % 2, 2.0, None, &|it| {
                (it.ends, it.precompression) = (Ends::Periodic, 0.4);
                it.losses = losses;
            });
        }
        let wall = Some(Drive::Wall(wave.clone()));
        add(n, 1.5, wall.clone(), &|it| {
            (it.law, it.ends) = (spring.clone().into(), fixed);
        });
        add(n, 1.5, wall, &|it| (it.ends, it.losses) = (fixed, lossy));
        add(n, 1.0, None, &|it| {
            it.law = Law::Power { exponent: 2.2 }.into();
            it.precompression = 0.1;
            let light = it.mass.iter_mut().skip(1).step_by(2);
            light.for_each(|m| *m = 0.3);
        });
    }
    all
}

#[test]
fn val_identity_sums_over_k() {
    let mut worst = [0f64; 3];
    for (i, (chain, drive)) in chains().into_iter().enumerate() {
        let states = States::new(chain, drive, 3 + 2 * i as u64);
        let (found, arrays) = states.budget(&wavenumber_only());
        let identities = found.closure.identities;
        let found = [
            identities.transfer_sum,
            identities.energy_sum,
            identities.loss_sum.unwrap_or(0.0),
        ];
        for (worst, found) in worst.iter_mut().zip(found) {
            assert!(found.is_finite());
            *worst = worst.max(found);
        }
        // The flux through the largest k is the sum of all transfers.
        let (flux, transfer) = (
            &arrays[&LargeArray::SPECTRAL_FLUX],
            &arrays[&LargeArray::TRANSFER],
        );
        for (flux, transfer) in flux.rows().into_iter().zip(transfer.rows()) {
            let largest = transfer.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
            assert!(flux[flux.len() - 1].abs() <= 3e-14 * largest);
        }
    }
    assert!(worst[0] < 3e-14, "{worst:?}");
    assert!(worst[1] < 1e-15, "{worst:?}");
    assert!(worst[2] < 1e-15, "{worst:?}");
}

/// E, T and L of small chains by their defining sums, with transforms as sums over all sites.
#[test]
fn val_defining_sums_of_spectra() {
    for (i, (chain, drive)) in chains().into_iter().enumerate() {
        let n = chain.n_sites();
        if n > 40 || matches!(chain.ends, Ends::Fixed { .. }) {
            continue;
        }
        let states = States::new(chain, drive, 50 + 2 * i as u64);
        let (_, arrays) = states.budget(&wavenumber_only());
        for sample in [0, 4, 8] {
            let (x, v) = (states.x.row(sample), states.v.row(sample));
            let expected = by_definition(&states, states.time[sample], &x.to_vec(), &v.to_vec());
            for (array, expected) in [
                (LargeArray::ENERGY_SPECTRUM, &expected[0]),
                (LargeArray::TRANSFER, &expected[1]),
                (LargeArray::LOSS_SPECTRUM, &expected[2]),
                (LargeArray::INPUT_SPECTRUM, &expected[3]),
            ] {
                let Some(array) = arrays.get(&array) else {
                    continue;
                };
                let scale = expected.iter().fold(1e-300, |m: f64, t| m.max(t.abs()));
                for (found, expected) in array.row(sample).iter().zip(expected) {
                    let off = (found - expected).abs() / scale;
                    assert!(off < 2e-13, "{i} {n} {off:e}");
                }
            }
        }
    }
}

fn by_definition(states: &States, t: f64, x: &[f64], v: &[f64]) -> [Vec<f64>; 4] {
    let chain = &states.chain;
    let (n, m) = (chain.n_sites(), chain.n_contacts());
    let right = |values: &[f64], j: usize| match (values.get(j + 1), chain.ends) {
        (Some(value), _) => *value,
        (None, Ends::Periodic) => values[0],
        (None, _) => 0.0,
    };
    let law = |j: usize| {
        let (c, d0) = (chain.coefficient[j], chain.static_overlap(j));
        let r = x[j] - right(x, j);
        let excess = chain.law.of(0).energy(c, d0, r);
        let force = chain.law.of(0).force(c, d0, r);
        let phi = excess.sqrt() * r.signum();
        let closing = v[j] - right(v, j);
        let rate = if phi == 0.0 {
            0.0
        } else {
            force * closing / (2.0 * phi)
        };
        let damping = chain.force(j, x, v) - chain.force(j, x, &vec![0.0; n]);
        (force, phi, rate, damping)
    };
    let contacts: Vec<_> = (0..m).map(law).collect();
    type Contact = (f64, f64, f64, f64);
    let push = |j: usize, of: &dyn Fn(&Contact) -> f64| {
        let left = match j.checked_sub(1) {
            Some(left) => of(&contacts[left]),
            None if chain.ends == Ends::Periodic => of(&contacts[m - 1]),
            None => 0.0,
        };
        left - contacts.get(j).map_or(0.0, of)
    };
    let root = |j: usize| chain.mass[j].sqrt();
    let rows: [Vec<f64>; 6] = [
        (0..n).map(|j| root(j) * v[j]).collect(),
        (0..n).map(|j| push(j, &|c| c.0) / root(j)).collect(),
        contacts.iter().map(|c| c.1).collect(),
        contacts.iter().map(|c| c.2).collect(),
        (0..n)
            .map(|j| (push(j, &|c| c.3) - chain.losses.drag * v[j]) / root(j))
            .collect(),
        (0..n)
            .map(|j| match &states.drive {
                Some(Drive::Force(wave)) if j == 0 => wave.at(t) / root(0),
                _ => 0.0,
            })
            .collect(),
    ];
    let transform = |row: &[f64], k: usize| -> Complex<f64> {
        let term = |(j, value): (usize, &f64)| {
            Complex::from_polar(*value, 2.0 * PI * ((j * k) % n) as f64 / n as f64)
        };
        row.iter().enumerate().map(term).sum::<Complex<f64>>() / (n as f64).sqrt()
    };
    let dot = |a: Complex<f64>, b: Complex<f64>| (a.conj() * b).re;
    let mut out: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; n / 2 + 1]);
    for k in 0..n {
        // Fold k and -k.
        let bin = k.min(n - k);
        let [q, f, phi, rate, loss, input] = [0, 1, 2, 3, 4, 5].map(|row| transform(&rows[row], k));
        out[0][bin] += 0.5 * q.norm_sqr() + phi.norm_sqr();
        out[1][bin] += dot(q, f) + 2.0 * dot(phi, rate);
        out[2][bin] -= dot(q, loss);
        out[3][bin] += dot(q, input);
    }
    out
}

/// Coarse-grained flux and energy by weighted sums over cells, contact by contact.
#[test]
fn val_defining_sums_of_scale_flux() {
    for filter in [Filter::Gaussian, Filter::Box] {
        let chain = Chain {
            losses: changed(Losses::default(), |it| it.dashpot = 0.1),
            ..Chain::dimer(120, 3.0)
        };
        let states = States::new(chain, None, 7);
        let request = BudgetRequest {
            filter,
            scales: vec![5.0],
            map_scale: Some(5.0),
            ..BudgetRequest::default()
        };
        let (found, arrays) = states.budget(&request);
        let found = found.scales.unwrap();
        let [first, end] = found.contacts[0];
        assert!(first > 1 && end < 119 && end > first + 40);
        let weights: Vec<f64> = match filter {
            Filter::Box => vec![1.0, 1.0 - 0.25],
            _ => (0..12)
                .map(|i| (-0.5 * (2.0 * i as f64 / (5.0 / 12f64.sqrt())).powi(2)).exp())
                .collect(),
        };
        let total = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
        let flux = &arrays[&LargeArray::SCALE_FLUX];
        for sample in [0, 5] {
            let (x, v) = (states.x.row(sample), states.v.row(sample));
            let bar = |row: &dyn Fn(usize) -> f64, j: usize| {
                let side = |i: usize| row(j + 2 * i) + row(j - 2 * i);
                let sum: f64 = (1..weights.len())
                    .filter(|i| j >= 2 * i && j + 2 * i < 119)
                    .map(|i| weights[i] * side(i))
                    .sum();
                (weights[0] * row(j) + sum) / total
            };
            let overlap = |j: usize| x[j] - x[j + 1];
            let law = &states.chain.law;
            let force = |j: usize| {
                law.of(0)
                    .force(states.chain.coefficient[j], 0.0, overlap(j))
            };
            for j in first..end {
                let speed = |j: usize| v[j];
                let apart = bar(&speed, j) - bar(&speed, j + 1);
                let of_bar = law
                    .of(0)
                    .force(states.chain.coefficient[j], 0.0, bar(&overlap, j));
                let expected = (bar(&force, j) - of_bar) * apart;
                let off = (flux[[sample, j]] - expected).abs();
                assert!(off < 2e-15, "{filter:?} {j} {off:e}");
            }
            assert!(flux[[sample, first - 1]].is_nan() && flux[[sample, end]].is_nan());
        }
    }
}

/// Power flow by its defining transforms, for records of even and odd length, and its sums.
#[test]
fn val_defining_sums_of_power_flow() {
    let losses = changed(Losses::default(), |it| it.tangent = 0.1);
    let ring = Chain {
        ends: Ends::Periodic,
        losses,
        ..Chain::dimer(40, 3.0)
    };
    for chain in [ring, Chain::dimer(37, 2.0)] {
        let states = States::new(chain, None, 31);
        let n = states.chain.n_sites();
        for samples in [9, 8] {
            let whole = states.motion();
            let motion = Motion {
                time: states.time.slice(ndarray::s![..samples]),
                displacement: states.x.slice(ndarray::s![..samples, ..]),
                velocity: states.v.slice(ndarray::s![..samples, ..]),
                ..whole
            };
            let (found, arrays) = budget(&motion, &BudgetRequest::default()).unwrap();
            let flow = found.frequency.unwrap();
            let dt = 0.37;
            for j in 0..states.chain.n_contacts() {
                let right = (j + 1) % n;
                // No energy passes a wall.
                let wall = j + 1 == n && states.chain.ends != Ends::Periodic;
                let record = |i: usize| {
                    let (x, v) = (states.x.row(i).to_vec(), states.v.row(i).to_vec());
                    let end = if i == 0 || i + 1 == samples { 0.5 } else { 1.0 };
                    match wall {
                        true => (0.0, 0.0),
                        false => (end * states.chain.force(j, &x, &v), 0.5 * (v[j] + v[right])),
                    }
                };
                let records: Vec<_> = (0..samples).map(record).collect();
                for bin in 0..=samples / 2 {
                    let term = |(i, value): (usize, f64)| {
                        Complex::from_polar(
                            value,
                            -2.0 * PI * ((i * bin) % samples) as f64 / samples as f64,
                        )
                    };
                    let force: Complex<f64> =
                        records.iter().map(|r| r.0).enumerate().map(term).sum();
                    let speed: Complex<f64> =
                        records.iter().map(|r| r.1).enumerate().map(term).sum();
                    let weight = if bin == 0 || 2 * bin == samples {
                        1.0
                    } else {
                        2.0
                    };
                    let expected = weight * dt * dt * (force.conj() * speed).re;
                    let off = (arrays[&LargeArray::POWER_FLOW][[bin, j]] - expected).abs();
                    assert!(off < 1e-13, "{j} {bin} {off:e}");
                }
                let trapezoid: f64 = records
                    .iter()
                    .map(|(force, speed)| dt * force * speed)
                    .sum();
                assert!((flow.passed(j) - trapezoid).abs() < 1e-13);
                let column = arrays[&LargeArray::CUMULATIVE_POWER_FLOW]
                    .column(j)
                    .to_vec();
                let edge = flow
                    .frequency
                    .iter()
                    .filter(|f| **f <= flow.edge * (1.0 + 1e-9))
                    .count();
                assert!((column[edge - 1] - flow.low[j]).abs() < 1e-13);
            }
        }
    }
}

/// The energies of the two branches of a dimer with a linear limit sum to its energy.
#[test]
fn val_identity_branches_sum_to_the_energy() {
    for precompression in [0.01, 3.0] {
        let ring = Chain {
            ends: Ends::Periodic,
            precompression,
            ..Chain::dimer(40, 2.5)
        };
        let (found, arrays) = States::new(ring, None, 11).budget(&wavenumber_only());
        assert!(found.wavenumber.unwrap().branches.is_some());
        let sum = |array| {
            arrays[&array]
                .rows()
                .into_iter()
                .map(|row: ndarray::ArrayView1<f64>| row.sum())
                .collect::<Vec<_>>()
        };
        let (acoustic, optical) = (
            sum(LargeArray::ACOUSTIC_SPECTRUM),
            sum(LargeArray::OPTICAL_SPECTRUM),
        );
        for (i, energy) in sum(LargeArray::ENERGY_SPECTRUM).into_iter().enumerate() {
            assert!((acoustic[i] + optical[i] - energy).abs() < 1e-14 * energy);
            assert!(acoustic[i] > 0.1 * energy && optical[i] > 0.1 * energy);
        }
        assert!(
            arrays[&LargeArray::ACOUSTIC_SPECTRUM]
                .iter()
                .all(|e| *e > -1e-12)
        );
    }
    // Without a linear limit, or without a dimer, there are no branches.
    for chain in [
        Chain::dimer(40, 2.5),
        changed(Chain::dimer(40, 1.0), |it| it.precompression = 1.0),
    ] {
        let (found, _) = States::new(chain, None, 13).budget(&wavenumber_only());
        assert!(found.wavenumber.unwrap().branches.is_none());
    }
}

#[test]
fn hard_chains_have_budgets() {
    // At rest: nothing anywhere, and every balance closes.
    let mut states = States::new(Chain::dimer(6, 2.0), None, 1);
    states.x.fill(0.0);
    states.v.fill(0.0);
    for integration in [Integration::Samples, Integration::Stepping] {
        let request = changed(BudgetRequest::default(), |it| it.integration = integration);
        let (found, _) = states.budget(&request);
        assert_eq!(found.closure.wavenumber.value(), Some(0.0));
    }
    let (found, _) = states.budget(&BudgetRequest::default());
    assert_eq!(found.closure.real_space.value(), Some(0.0));
    assert_eq!(found.closure.wavenumber.value(), Some(0.0));
    assert_eq!(found.closure.identities.transfer_sum, 0.0);
    assert!(found.frequency.unwrap().edge.is_nan());

    // A single site on a wall; contacts that just touch, and just open.
    for (n, kappa) in [(1, 1.0), (2, 1e6), (5, 1e6)] {
        let mut states = States::new(Chain::dimer(n, kappa), None, 5);
        states.x.row_mut(0).fill(0.0);
        states.x.row_mut(1).mapv_inplace(|x| 1e-300 * x);
        states.x.row_mut(2).mapv_inplace(|x| -1e-160 * x.abs());
        let (found, arrays) = states.budget(&BudgetRequest::default());
        assert!(found.closure.scale.value().is_none());
        for (array, values) in &arrays {
            let undefined = values.iter().any(|value| !value.is_finite());
            assert!(!undefined || *array == LargeArray::SCALE_FLUX, "{array:?}");
        }
        // With so few wavenumbers transfers may cancel in all of them.
        assert!(n < 3 || found.closure.identities.transfer_sum < 1e-13);
    }

    // A hundred thousand sites.
    let mut chain = Chain::dimer(100_000, 4.9272);
    chain.losses.drag = 0.01;
    let (found, _) = States::new(chain, None, 17).budget(&wavenumber_only());
    let identities = found.closure.identities;
    assert!(identities.transfer_sum < 3e-14, "{identities:?}");
    assert!(identities.transfer_rounding < 1e-15, "{identities:?}");
    assert!(identities.energy_sum < 2e-14 && identities.loss_sum < Some(2e-14));
}

#[test]
fn what_does_not_fit_is_refused() {
    let states = States::new(Chain::dimer(40, 2.0), None, 29);
    let motion = states.motion();
    let request = BudgetRequest::default;
    let short = Array2::zeros((9, 39));
    let unfit = changed(motion, |it| it.velocity = short.view());
    assert!(budget(&unfit, &request()).is_err());
    let mut holes = states.v.clone();
    holes[[2, 3]] = f64::NAN;
    let unfit = changed(motion, |it| it.velocity = holes.view());
    assert!(budget(&unfit, &request()).is_err());
}
