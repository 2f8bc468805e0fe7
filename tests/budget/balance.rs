//! Budgets of simulated chains over time: the change of a quantity against the integral of its
//! rate.

use std::f64::consts::TAU;

use num_complex::Complex;
use rayon::prelude::*;
use test_support::scenes::{largest, rows, sized, slope};
use wavecascade::arrays::LargeArray;
use wavecascade::budget::{BudgetRequest, Closure, Filter, Integration, Residual};
use wavecascade::chain::Run;

use crate::{CHAINS, budget_of, exact, integrated};

const DIMER: &str = "sites = 26\nstiffness_ratio = 2.398\n";

fn closure(run: &Run, integration: Integration) -> Closure {
    integrated(run, BudgetRequest::default(), integration)
        .0
        .closure
}

fn closed(residual: &Residual) -> f64 {
    residual.value().unwrap_or_else(|| panic!("{residual:?}"))
}

#[test]
fn val_identity_balances_close_inside_the_stepping() {
    let chains: Vec<[String; 3]> = rows(CHAINS).collect();
    chains.into_par_iter().for_each(|[name, end, keys]| {
        let run = exact(&sized(&keys, 26), end.parse().unwrap(), 41);
        let of = closure(&run, Integration::Stepping);
        assert_eq!(of.integration, Integration::Stepping);
        for (what, residual, most) in [
            ("sites", of.real_space, 1e-10),
            ("wavenumbers", of.wavenumber, 1e-12),
            ("scales", of.scale, 2e-13),
            ("frequencies", of.frequency, 2e-12),
        ] {
            let off = closed(&residual);
            println!("{name}, {what}: {off:.1e}");
            assert!(off < most, "{name}, {what}: {off:e}");
        }
        // From the samples alone the closure shows the error of the trapezoid rule.
        let coarse = closure(&run, Integration::Samples).wavenumber;
        assert!(closed(&coarse) > 1e-5, "{name}: {coarse:?}");
    });
}

/// Fourier integrals of force and mean speed of a linear chain by Simpson's rule over its samples.
#[test]
fn val_simpson_the_low_band_inside_the_stepping() {
    let (end, last) = (12.0, 1200);
    let run = exact(
        "sites = 8\nstiffness_ratio = 2.0\nlaw = 'spring'",
        end,
        last + 1,
    );
    let (found, _) = integrated(&run, BudgetRequest::default(), Integration::Stepping);
    let flow = found.frequency.unwrap();
    let (force, v) = (run.force.as_ref().unwrap(), &run.velocity);
    let bins = (flow.edge * end * (1.0 + 1e-9)) as usize;
    let weight = |i: usize| match i % last {
        0 => end / last as f64 / 3.0,
        _ => end / last as f64 / 3.0 * 2.0 * (1 + i % 2) as f64,
    };
    let transform = |of: &dyn Fn(usize) -> f64, m: usize| {
        let angle = |i: usize| TAU * (m * i) as f64 / last as f64;
        let terms = (0..=last).map(|i| Complex::from_polar(weight(i) * of(i), angle(i)));
        terms.sum::<Complex<f64>>()
    };
    let low = (0..=bins).map(|m| {
        let power = transform(&|i| force[[i, 0]], m).conj()
            * transform(&|i| 0.5 * (v[[i, 0]] + v[[i, 1]]), m);
        power.re / end * if m == 0 { 1.0 } else { 2.0 }
    });
    let (low, found) = (low.sum::<f64>(), flow.refined[0]);
    assert!((found.low - low).abs() < 1e-9, "{found:?} {low}");
}

/// Scale budgets of a chain long enough for many sites.
#[test]
fn val_identity_scales_of_a_long_chain() {
    let run = exact("sites = 120\nstiffness_ratio = 2.398", 100.0, 33);
    let (found, _) = integrated(&run, BudgetRequest::default(), Integration::Stepping);
    let scales = found.scales.unwrap();
    let mut all = scales.scales.iter();
    let mapped = all.position(|of| of.scale == scales.map_scale).unwrap();
    let [first, end] = scales.contacts[mapped];
    assert!(end - first > 50);
    let residual = closed(&found.closure.scale);
    assert!(residual > 0.0 && residual < 1e-11, "{residual:e}");
}

/// A spoiled record differs from the stepping, and the departure shows it.
#[test]
fn a_spoiled_record_departs_from_the_stepping() {
    let mut run = exact(DIMER, 20.0, 21);
    let departure = |run: &Run| closure(run, Integration::Stepping).departure;
    assert!(departure(&run) < Some(1e-9));
    run.velocity.row_mut(15).mapv_inplace(|v| 1.01 * v);
    assert!(departure(&run) > Some(1e-4));
}

/// The balance over a window uses its sites and samples alone.
#[test]
fn a_window_balances_by_itself() {
    let mut run = exact(DIMER, 60.0, 61);
    let residual = |run: &Run, window| {
        let request = BudgetRequest {
            window: Some(window),
            ..BudgetRequest::default()
        };
        closed(&budget_of(run, &request).0.closure.real_space)
    };
    let whole = residual(&run, [0..61, 0..26]);
    for window in [[10..40, 3..9], [0..61, 25..26], [30..61, 0..1]] {
        let part = residual(&run, window);
        assert!(part < 1e-10 && part <= 2.0 * whole, "{part:e} {whole:e}");
    }
    // A wrong energy at one contact shows in the balance there, and nowhere else.
    let passed = run.energy_passed.as_mut().unwrap();
    passed.column_mut(12).mapv_inplace(|w| 0.99 * w);
    let [before, there, behind] =
        [0..12, 12..14, 14..26].map(|sites| residual(&run, [0..61, sites]));
    assert!(there > 1e-3 && before < 1e-9 && behind < 1e-9);
}

/// Fitted slopes of the residuals against the sampling interval. At an opening contact forces vary
/// like `t^{3/2}`, so the trapezoid sum of F v has order 5/2. T varies like `t^{1/4}`, in both
/// signs.
#[test]
fn val_observed_order_from_samples() {
    let residuals = [256, 512, 1024, 2048, 4096].map(|steps| {
        let of = closure(&exact(DIMER, 60.0, steps + 1), Integration::Samples);
        let all = [&of.wavenumber, &of.frequency, &of.scale];
        (
            -(steps as f64).ln(),
            all.map(|residual| closed(residual).ln()),
        )
    });
    for (of, order) in [1.5, 2.5, 2.0].into_iter().enumerate() {
        let found = slope(&residuals.map(|(x, y)| [x, y[of]]));
        assert!((found - order).abs() < 0.1, "{order}: {found}");
    }
}

/// Fourth-order time differences of E(k) against T - L.
#[test]
fn val_differences_of_the_energy_spectrum() {
    for losses in ["", "tangent = 0.05\ndrag = 0.01"] {
        // Samples so dense that the error of fourth-order differences is rounding over h.
        let keys = format!("sites = 24\nstiffness_ratio = 4.0\n{losses}");
        let run = exact(&keys, 20.0, 8001);
        let (_, arrays) = budget_of(&run, &BudgetRequest::default());
        let h = run.time[1];
        let energy = &arrays[&LargeArray::ENERGY_SPECTRUM];
        let transfer = &arrays[&LargeArray::TRANSFER];
        let loss = arrays.get(&LargeArray::LOSS_SPECTRUM);
        let scale = largest(transfer);
        let mut off: Vec<f64> = Vec::new();
        for i in (2..7999).step_by(7) {
            for m in 0..transfer.ncols() {
                let e = |j: usize| energy[[j, m]];
                let slope = (8.0 * (e(i + 1) - e(i - 1)) - (e(i + 2) - e(i - 2))) / (12.0 * h);
                let rate = transfer[[i, m]] - loss.map_or(0.0, |loss| loss[[i, m]]);
                off.push((slope - rate).abs() / scale);
            }
        }
        // Differences are wrong where a contact opens between samples.
        off.sort_by(f64::total_cmp);
        let (median, ninth) = (off[off.len() / 2], off[off.len() * 9 / 10]);
        assert!(median < 1e-10 && ninth < 1e-8, "{median:e} {ninth:e}");
    }
}

/// Flux of the sharp filter through all contacts of a ring, against `Pi` at the same wavenumbers.
///
/// The filter acts on whole cells: it passes k up to its cut-off and also k + pi, which is the same
/// wavenumber of the cell. Kinetic energy is then split alike, but contact energy is not: the
/// energy of a filtered overlap is not the square of the filtered phi. The two fluxes differ by the
/// rate of change of that difference. The difference is bounded, so both carry the same energy over
/// a long time.
#[test]
fn val_identity_sharp_filter_beside_the_spectral_flux() {
    let (n, kept, cells) = (64, 6, 32);
    let keys = "sites = 64\nends = 'periodic'\nprecompression = 1e-3\nstiffness_ratio = 2.0";
    let run = exact(keys, 20.0, 8001);
    let request = BudgetRequest {
        filter: Filter::Sharp,
        scales: vec![n as f64 / kept as f64],
        ..BudgetRequest::default()
    };
    let (_, arrays) = budget_of(&run, &request);
    let passes = |m: usize| m <= kept || m >= cells - kept;
    let low = |array: LargeArray, i: usize| -> f64 {
        let row = arrays[&array].row(i);
        let kept = row.iter().enumerate().filter(|(m, _)| passes(*m));
        kept.map(|(_, value)| value).sum()
    };
    // Rows filtered by sums over cells, each sublattice separately.
    let gain = |away: usize| {
        let angle = |m: usize| TAU * ((away * m) % cells) as f64 / cells as f64;
        1.0 + 2.0 * (1..=kept).map(|m| angle(m).cos()).sum::<f64>()
    };
    let filtered = |row: &dyn Fn(usize) -> f64, j: usize| -> f64 {
        let terms = (0..cells).map(|c| gain(c) * row((j + 2 * c) % n));
        terms.sum::<f64>() / cells as f64
    };
    let (x, chain) = (run.displacement.as_ref().unwrap(), &run.chain);
    let coarse = |i: usize| -> f64 {
        let energy = |j: usize| {
            let speed = filtered(&|j| run.velocity[[i, j]], j);
            let overlap = filtered(&|j| x[[i, j]] - x[[i, (j + 1) % n]], j);
            let (c, d0) = (chain.coefficient[j], chain.static_overlap(j));
            0.5 * speed * speed + chain.law.of(0).energy(c, d0, overlap)
        };
        (0..n).map(energy).sum()
    };
    let flux = &arrays[&LargeArray::SCALE_FLUX_IN_TIME];
    let rates = |i: usize| [flux[[i, 0]], -low(LargeArray::TRANSFER, i)];
    let apart = |i: usize| low(LargeArray::ENERGY_SPECTRUM, i) - coarse(i);
    let (mut sums, mut gap, start) = ([0.0; 2], 0f64, apart(0));
    for i in 1..=8000 {
        let (before, now) = (rates(i - 1), rates(i));
        for (of, sum) in sums.iter_mut().enumerate() {
            *sum += 0.5 * run.time[1] * (before[of] + now[of]);
        }
        if i % 500 == 0 {
            let [scale, spectral] = sums;
            let off = (scale - spectral - (apart(i) - start)).abs();
            assert!(off < 2e-5, "{i} {off:e}");
            gap = gap.max((scale - spectral).abs());
        }
    }
    // The difference is not small.
    assert!(gap > 1e-2, "{gap}");
}
