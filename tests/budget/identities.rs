//! Identities of budgets at any state, and budgets against their defining sums.

use std::f64::consts::PI;

use ndarray::{Array2, s};
use num_complex::Complex;
use test_support::changed;
use test_support::fields::{chain, fixed, spring};
use test_support::scenes::{apart, largest, near, rows, simulation, sized, within};
use wavecascade::arrays::LargeArray;
use wavecascade::budget::{BudgetRequest, Filter, Integration, Motion, budget};
use wavecascade::chain::{Chain, Drive, Ends, Losses, OnSite};

use crate::CHAINS;
use crate::states::{STEP, States};

/// Random states of all chains of these many sites whose energy is that of bodies and contacts alone.
fn states(sizes: &[usize]) -> Vec<(String, States)> {
    let mut all = Vec::new();
    for (seed, [name, _, keys]) in (1..).zip(rows(CHAINS)) {
        for &n in sizes {
            // A ring is of whole cells.
            let n = n + if keys.contains("periodic") { n % 2 } else { 0 };
            let of = simulation(&format!("end_time = 1.0\n{}", sized(&keys, n)));
            let moved = matches!(of.drive, Some(Drive::Motion(..)));
            if of.chain.on_site == OnSite::default() && !moved {
                let states = States::new(of.chain, of.drive, seed);
                all.push((format!("{name}, {n}"), states));
            }
        }
    }
    all
}

#[test]
fn val_identity_sums_over_k() {
    for (name, states) in states(&[9, 31, 100, 300]) {
        let (found, arrays) = states.wavenumbers();
        let of = found.closure.identities;
        let loss = of.loss_sum.unwrap_or(0.0);
        // Written so that no NaN passes.
        let small = of.transfer_sum < 3e-14 && of.energy_sum < 1e-15 && loss < 1e-15;
        assert!(small, "{name}: {of:?}");
        // The flux through the largest k is the sum of all transfers.
        let flux = arrays[&LargeArray::SPECTRAL_FLUX].rows().into_iter();
        for (flux, transfer) in flux.zip(arrays[&LargeArray::TRANSFER].rows()) {
            near(flux[flux.len() - 1], 0.0, 3e-14 * largest(transfer), &name);
        }
    }
}

/// E, T and L of small chains by their defining sums, with transforms as sums over all sites.
#[test]
fn val_defining_sums_of_spectra() {
    for (name, states) in states(&[9, 31]) {
        if matches!(states.chain.ends, Ends::Fixed { .. }) {
            continue;
        }
        let (_, arrays) = states.wavenumbers();
        for sample in [0, 4, 8] {
            let expected = by_definition(&states, sample);
            for (array, expected) in [
                LargeArray::ENERGY_SPECTRUM,
                LargeArray::TRANSFER,
                LargeArray::LOSS_SPECTRUM,
                LargeArray::INPUT_SPECTRUM,
            ]
            .into_iter()
            .zip(&expected)
            {
                let known = largest(expected);
                // What is not there is 0.
                let off = arrays
                    .get(&array)
                    .map_or(known, |found| apart(found.row(sample), expected));
                assert!(off <= 2e-13 * known, "{name}: {off:e}");
            }
        }
    }
}

fn by_definition(states: &States, sample: usize) -> [Vec<f64>; 4] {
    let (chain, t) = (&states.chain, states.time[sample]);
    let [x, v] = [&states.x, &states.v].map(|array| array.row(sample).to_vec());
    let (n, m) = (chain.n_sites(), chain.n_contacts());
    let right = |values: &[f64], j: usize| match (values.get(j + 1), chain.ends) {
        (Some(value), _) => *value,
        (None, Ends::Periodic) => values[0],
        (None, _) => 0.0,
    };
    // Force, phi, its rate, and the force of losses.
    let contacts = Vec::from_iter((0..m).map(|j| {
        let (c, d0) = (chain.coefficient[j], chain.static_overlap(j));
        let r = x[j] - right(&x, j);
        let force = chain.law.of(j).force(c, d0, r);
        let phi = chain.law.of(j).energy(c, d0, r).sqrt() * r.signum();
        let rate = match phi {
            0.0 => 0.0,
            phi => force * (v[j] - right(&v, j)) / (2.0 * phi),
        };
        [
            force,
            phi,
            rate,
            chain.force(j, &x, &v) - chain.force(j, &x, &vec![0.0; n]),
        ]
    }));
    let push = |j: usize, of: usize| {
        let left = match j.checked_sub(1) {
            Some(left) => contacts[left][of],
            None if chain.ends == Ends::Periodic => contacts[m - 1][of],
            None => 0.0,
        };
        left - contacts.get(j).map_or(0.0, |contact| contact[of])
    };
    let root = |j: usize| chain.mass[j].sqrt();
    let input = |j: usize| match &states.drive {
        Some(Drive::Force(wave)) if j == 0 => wave.at(t) / root(0),
        Some(Drive::Body(site, wave)) if j == *site => wave.at(t) / root(j),
        _ => 0.0,
    };
    let drag = |j: usize| chain.losses.drag * v[j];
    let sites = |of: &dyn Fn(usize) -> f64| Vec::from_iter((0..n).map(of));
    let rows: [Vec<f64>; 6] = [
        sites(&|j| root(j) * v[j]),
        sites(&|j| push(j, 0) / root(j)),
        contacts.iter().map(|c| c[1]).collect(),
        contacts.iter().map(|c| c[2]).collect(),
        sites(&|j| (push(j, 3) - drag(j)) / root(j)),
        sites(&input),
    ];
    let dot = |a: Complex<f64>, b: Complex<f64>| (a.conj() * b).re;
    let mut out: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; n / 2 + 1]);
    for k in 0..n {
        let of = rows
            .each_ref()
            .map(|row| transform(row, k, n) / (n as f64).sqrt());
        let [q, f, phi, rate, loss, input] = of;
        // Fold k and -k.
        let bin = k.min(n - k);
        out[0][bin] += 0.5 * q.norm_sqr() + phi.norm_sqr();
        out[1][bin] += dot(q, f) + 2.0 * dot(phi, rate);
        out[2][bin] -= dot(q, loss);
        out[3][bin] += dot(q, input);
    }
    out
}

/// The sum of the row with `exp(2 pi i j k / n)`.
fn transform(row: &[f64], k: usize, n: usize) -> Complex<f64> {
    let angle = |j: usize| 2.0 * PI * ((j * k) % n) as f64 / n as f64;
    let terms = row.iter().enumerate();
    terms
        .map(|(j, value)| Complex::from_polar(*value, angle(j)))
        .sum()
}

/// Coarse-grained flux and energy by weighted sums over cells, contact by contact.
#[test]
fn val_defining_sums_of_scale_flux() {
    let gauss = |i: usize| (-0.5 * (2.0 * i as f64 / (5.0 / 12f64.sqrt())).powi(2)).exp();
    for (filter, weights) in [
        (Filter::Gaussian, Vec::from_iter((0..12).map(gauss))),
        (Filter::Box, vec![1.0, 1.0 - 0.25]),
    ] {
        let losses = changed(Losses::default(), |it| it.dashpot = 0.1);
        let chain = changed(Chain::dimer(120, 3.0), |it| it.losses = losses);
        let states = States::new(chain, None, 7);
        let request = BudgetRequest {
            filter,
            scales: vec![5.0],
            map_scale: Some(5.0),
            ..BudgetRequest::default()
        };
        let (found, arrays) = states.budget(&request);
        let [first, end] = found.scales.unwrap().contacts[0];
        assert!(first > 1 && end < 119 && end > first + 40);
        let total = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
        let flux = &arrays[&LargeArray::SCALE_FLUX];
        let (chain, law) = (&states.chain, states.chain.law.of(0));
        for sample in [0, 5] {
            let (x, v) = (states.x.row(sample), states.v.row(sample));
            let bar = |row: &dyn Fn(usize) -> f64, j: usize| {
                let within = (1..weights.len()).filter(|i| j >= 2 * i && j + 2 * i < 119);
                let sides = within.map(|i| weights[i] * (row(j + 2 * i) + row(j - 2 * i)));
                (weights[0] * row(j) + sides.sum::<f64>()) / total
            };
            let overlap = |j: usize| x[j] - x[j + 1];
            let force_at = |j: usize, overlap: f64| law.force(chain.coefficient[j], 0.0, overlap);
            let force = |j: usize| force_at(j, overlap(j));
            for j in first..end {
                let apart = bar(&|j| v[j], j) - bar(&|j| v[j], j + 1);
                let expected = (bar(&force, j) - force_at(j, bar(&overlap, j))) * apart;
                let off = (flux[[sample, j]] - expected).abs();
                assert!(off < 4e-15, "{filter:?} {j} {off:e}");
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
    for (chain, samples) in [ring, Chain::dimer(37, 2.0)].into_iter().zip([9, 8]) {
        let states = States::new(chain, None, 31);
        let (n, chain) = (states.chain.n_sites(), &states.chain);
        let motion = Motion {
            time: states.time.slice(s![..samples]),
            displacement: states.x.slice(s![..samples, ..]),
            velocity: states.v.slice(s![..samples, ..]),
            ..states.motion()
        };
        let (found, arrays) = budget(&motion, &BudgetRequest::default()).unwrap();
        let flow = found.frequency.unwrap();
        for j in 0..chain.n_contacts() {
            let right = (j + 1) % n;
            // No energy passes a wall.
            let wall = j + 1 == n && chain.ends != Ends::Periodic;
            let record = |i: usize| {
                let (x, v) = (states.x.row(i).to_vec(), states.v.row(i).to_vec());
                let end = if i == 0 || i + 1 == samples { 0.5 } else { 1.0 };
                match wall {
                    true => (0.0, 0.0),
                    false => (end * chain.force(j, &x, &v), 0.5 * (v[j] + v[right])),
                }
            };
            let (force, speed): (Vec<f64>, Vec<f64>) = (0..samples).map(record).unzip();
            for bin in 0..=samples / 2 {
                let [a, b] = [&force, &speed].map(|row| transform(row, bin, samples));
                let weight = if bin == 0 || 2 * bin == samples {
                    1.0
                } else {
                    2.0
                };
                let expected = weight * STEP * STEP * (a.conj() * b).re;
                let off = (arrays[&LargeArray::POWER_FLOW][[bin, j]] - expected).abs();
                assert!(off < 1e-13, "{j} {bin} {off:e}");
            }
            let trapezoid: f64 = force.iter().zip(&speed).map(|(f, v)| STEP * f * v).sum();
            assert!((flow.passed(j) - trapezoid).abs() < 1e-13);
            let column = arrays[&LargeArray::CUMULATIVE_POWER_FLOW].column(j);
            let below = |f: &&f64| **f <= flow.edge * (1.0 + 1e-9);
            let edge = flow.frequency.iter().filter(below).count();
            assert!((column[edge - 1] - flow.low[j]).abs() < 1e-13);
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
        let (found, arrays) = States::new(ring, None, 11).wavenumbers();
        assert!(found.wavenumber.unwrap().branches.is_some());
        let [acoustic, optical, energy] = [
            LargeArray::ACOUSTIC_SPECTRUM,
            LargeArray::OPTICAL_SPECTRUM,
            LargeArray::ENERGY_SPECTRUM,
        ]
        .map(|array| arrays[&array].sum_axis(ndarray::Axis(1)));
        for ((a, o), e) in acoustic.iter().zip(&optical).zip(&energy) {
            assert!((a + o - e).abs() < 1e-14 * e);
            assert!(*a > 0.1 * e && *o > 0.1 * e);
        }
        let mut spectrum = arrays[&LargeArray::ACOUSTIC_SPECTRUM].iter();
        assert!(spectrum.all(|e| *e > -1e-12));
    }
    // Without a linear limit, or without a dimer, there are no branches.
    for (ratio, precompression) in [(2.5, 0.0), (1.0, 1.0)] {
        let chain = changed(Chain::dimer(40, ratio), |it| {
            it.precompression = precompression
        });
        let (found, _) = States::new(chain, None, 13).wavenumbers();
        assert!(found.wavenumber.unwrap().branches.is_none());
    }
}

/// In a uniform linear chain each wavenumber keeps its energy: `T(k) = 0`, for any state.
#[test]
fn val_linear_chains_exchange_nothing_between_wavenumbers() {
    for n in [3, 4, 31, 64, 101] {
        for ends in [Ends::Periodic, fixed(2.5)] {
            let linear = chain(vec![0.7; n], vec![2.5; n], spring(0.0, 0.0), ends);
            let (_, arrays) = States::new(linear, None, 23).wavenumbers();
            // 2 sqrt(c / m) is the highest frequency: |q^| |f^| is at most that times the energy.
            let scale = 2.0 * f64::sqrt(2.5 / 0.7) * largest(&arrays[&LargeArray::ENERGY_SPECTRUM]);
            let worst = largest(&arrays[&LargeArray::TRANSFER]) / scale;
            assert!(worst < 2e-15, "{n} {ends:?} {worst:e}");
        }
    }
}

/// A linear dimer mixes k with k + pi / a, but not its acoustic with its optical modes.
#[test]
fn val_linear_dimers_exchange_nothing_between_branches() {
    for (mass, coefficient) in [
        ([1.0, 1.0], [1.0, 4.9]),
        ([1.0, 3.0], [1.0, 1.0]),
        ([0.2, 3.0], [2.0, 0.5]),
    ] {
        let [mass, coefficient] = [mass, coefficient].map(|cell| cell.repeat(32));
        let dimer = chain(mass, coefficient, spring(0.0, 0.0), Ends::Periodic);
        let (found, arrays) = States::new(dimer, None, 27).wavenumbers();
        let branches = found.wavenumber.unwrap().branches.unwrap();
        let transfer = &arrays[&LargeArray::TRANSFER];
        for (i, optical) in branches.optical_transfer.iter().enumerate() {
            let exchanged: f64 = transfer.row(i).iter().map(|t| t.abs()).sum();
            // k and k + pi / a do exchange.
            within(exchanged, 0.01.., i);
            near(*optical, 0.0, 1e-14 * exchanged, exchanged);
            let energy = branches.optical_energy[i];
            assert!(energy > 0.1 * (found.kinetic[i] + found.contact[i]));
        }
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
        assert_eq!(found.closure.real_space.value(), Some(0.0));
        assert_eq!(found.closure.wavenumber.value(), Some(0.0));
        assert_eq!(found.closure.identities.transfer_sum, 0.0);
        assert!(found.frequency.unwrap().edge.is_nan());
    }

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
    let chain = changed(Chain::dimer(100_000, 4.9272), |it| it.losses.drag = 0.01);
    let (found, _) = States::new(chain, None, 17).wavenumbers();
    let identities = found.closure.identities;
    assert!(identities.transfer_sum < 3e-14, "{identities:?}");
    assert!(identities.transfer_rounding < 1e-15, "{identities:?}");
    assert!(identities.energy_sum < 2e-14 && identities.loss_sum < Some(2e-14));
}

#[test]
fn what_does_not_fit_is_refused() {
    let states = States::new(Chain::dimer(40, 2.0), None, 29);
    let (short, mut holes) = (Array2::zeros((9, 39)), states.v.clone());
    holes[[2, 3]] = f64::NAN;
    for velocity in [&short, &holes] {
        let unfit = changed(states.motion(), |it| it.velocity = velocity.view());
        assert!(budget(&unfit, &BudgetRequest::default()).is_err());
    }
}
