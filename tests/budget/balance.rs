//! Budgets of simulated chains over time: the change of a quantity against the integral of its
//! rate.

use rayon::prelude::*;
use test_support::changed;
use test_support::fields::{fixed, spring};
use wavecascade::arrays::LargeArray;
use wavecascade::budget::{
    Budget, BudgetRequest, Closure, Filter, Integration, Motion, Residual, budget,
};
use wavecascade::chain::{
    Accuracy, Chain, Drive, Ends, Ground, Law, Laws, Losses, Record, Resonators, Run, Scheme,
    Simulation, Waveform,
};
use wavecascade::observer::Silent;

fn simulate(chain: Chain, drive: Option<Drive>, end: f64, samples: usize) -> Run {
    let mut simulation = Simulation::impact(chain, 1.0, end, samples);
    if drive.is_some() {
        simulation.velocity.fill(0.0);
    }
    if let Some(Drive::Motion(site, wave)) = &drive {
        simulation.velocity[*site] = wave.rate_at(0.0);
    }
    simulation.drive = drive;
    simulation.accuracy = Accuracy::LocalError(1e-12);
    simulation.estimate_error = false;
    simulation.record = Record::ALL;
    let Chain {
        losses, on_site, ..
    } = &simulation.chain;
    if losses.any() || on_site.ground.is_some() || on_site.resonators.is_some() {
        simulation.scheme = Scheme::RungeKutta;
    }
    simulation.run(&Silent).unwrap()
}

fn found(run: &Run, integration: Integration) -> Budget {
    let request = changed(BudgetRequest::default(), |it| it.integration = integration);
    budget(&Motion::of(run).unwrap(), &request).unwrap().0
}

fn closed(residual: &Residual) -> f64 {
    residual.value().unwrap_or_else(|| panic!("{residual:?}"))
}

/// On every other body.
fn resonators(n: usize, damping: f64) -> Resonators {
    let of = |all: [f64; 2]| all.into_iter().cycle().take(n).collect();
    Resonators {
        mass: of([0.5, 0.0]),
        stiffness: of([0.7, 0.0]),
        damping: of([damping, 0.0]),
    }
}

/// Chains of every end, law, loss and drive, each with its end time.
fn chains() -> Vec<(&'static str, Chain, Option<Drive>, f64)> {
    let n = 26;
    let wave = Waveform::sine(0.2, 0.1);
    let (force, wall) = (Drive::Force(wave.clone()), Drive::Wall(wave.clone()));
    let body = Drive::Body(7, wave.clone());
    let burst = Drive::Body(7, Waveform::tone_burst(0.3, 0.15, 3.0));
    let [seventh, eighth] = [7, 8].map(|site| Drive::Motion(site, wave.clone()));
    let ground = |coefficient| Ground {
        law: Law::expression("d + 0.2*d^3").unwrap().into(),
        coefficient,
    };
    let spring = spring(0.25, 0.0);
    let fix = |it: &mut Chain| it.ends = fixed(1.0);
    let free = |it: &mut Chain| {
        it.ends = Ends::Free;
        it.coefficient.pop();
    };
    let mut all = Vec::new();
    // A dimer of this ratio with a change.
    let mut add = |name, ratio, drive, end, change: &dyn Fn(&mut Chain)| {
        all.push((name, changed(Chain::dimer(n, ratio), change), drive, end));
    };
    add("before the wall", 2.398, None, 20.0, &|_| {});
    add("uniform, after the wall", 1.0, None, 60.0, &|_| {});
    add("after the wall", 2.398, None, 60.0, &|_| {});
    add("stiff", 1e6, None, 30.0, &|_| {});
    add("dashpot", 2.398, None, 60.0, &|it| it.losses.dashpot = 0.05);
    add("tangent", 2.398, None, 60.0, &|it| it.losses.tangent = 0.05);
    add("drag", 2.398, None, 20.0, &|it| it.losses.drag = 0.02);
    add("masses", 1.0, None, 40.0, &|it| {
        let light = it.mass.iter_mut().skip(1).step_by(2);
        light.for_each(|mass| *mass = 0.4);
    });
    add("free and pushed", 3.0, Some(force), 15.0, &free);
    add("pushed inside", 3.0, Some(body), 15.0, &free);
    add("ring pushed by a burst", 2.0, Some(burst), 15.0, &|it| {
        it.ends = Ends::Periodic;
        it.law = spring.clone().into();
        it.losses.drag = 0.02;
    });
    add("driven wall", 2.0, Some(wall.clone()), 15.0, &fix);
    add("ring", 2.0, None, 30.0, &|it| {
        it.ends = Ends::Periodic;
        it.precompression = 0.2;
    });
    add("springs", 1.0, None, 30.0, &|it| {
        it.law = spring.clone().into();
        fix(it);
    });
    add("toda", 2.0, None, 30.0, &|it| {
        it.law = Law::toda(1.0).into()
    });
    add("many laws", 1.0, None, 15.0, &|it| {
        // Filters act over cells of four.
        *it = Chain::dimer(2 * n, 1.0);
        let cell = vec![
            Law::Hertz,
            Law::polynomial(vec![1.0, 0.0, -0.05]),
            Law::expression("d + 0.2*d^3").unwrap(),
            Law::morse(0.7),
        ];
        it.law = Laws::cell(cell).unwrap();
        it.precompression = 0.2;
    });
    add("linear, opens", 2.0, None, 30.0, &|it| {
        it.law = Law::Power { exponent: 1.0 }.into();
    });
    add("held by the ground", 2.0, None, 10.0, &|it| {
        it.on_site.gravity = 0.1;
        let coefficient = (0..n).map(|j| 0.3 + 0.1 * (j % 2) as f64);
        it.on_site.ground = Some(ground(coefficient.collect()));
    });
    add("resonators", 2.0, None, 10.0, &|it| {
        it.on_site.gravity = 0.1;
        it.on_site.resonators = Some(resonators(n, 0.0));
    });
    add("damped resonators", 2.0, Some(wall), 10.0, &|it| {
        it.losses.drag = 0.02;
        it.on_site.resonators = Some(resonators(n, 0.05));
        fix(it);
    });
    add("a body moved as told", 2.0, Some(seventh), 30.0, &|_| {});
    let name = "a body moved on resonators and the ground";
    add(name, 1.0, Some(eighth), 10.0, &|it| {
        it.losses.drag = 0.02;
        it.law = spring.clone().into();
        it.on_site.ground = Some(ground(vec![0.3; n]));
        it.on_site.resonators = Some(resonators(n, 0.05));
        fix(it);
    });
    add("square law", 2.0, None, 30.0, &|it| {
        it.law = Law::Power { exponent: 2.0 }.into();
    });
    all
}

#[test]
fn val_identity_balances_close_inside_the_stepping() {
    chains()
        .into_par_iter()
        .for_each(|(name, chain, drive, end)| {
            let run = simulate(chain, drive, end, 41);
            let Closure {
                real_space,
                wavenumber,
                frequency,
                scale,
                integration,
                ..
            } = found(&run, Integration::Stepping).closure;
            assert_eq!(integration, Integration::Stepping);
            let (real, wave) = (closed(&real_space), closed(&wavenumber));
            let scale = closed(&scale);
            println!("{name}: {real:.1e} {wave:.1e} {scale:.1e}");
            // A force that sets in with a kink costs the steps beside it.
            let limit = if name == "linear, opens" {
                2e-10
            } else {
                5e-11
            };
            assert!(real < limit, "{name}: {real:e}");
            assert!(wave < 1e-12, "{name}: {wave:e}");
            assert!(scale < 1e-11, "{name}: {scale:e}");
            let power = closed(&frequency);
            // At an opening contact elastic forces vary like t^{3/2} and stiffness-proportional damping
            // like t^{1/2}; a dashpot jumps. Sums over samples have order 5/2, 3/2 and 1.
            let limit = match name {
                "dashpot" => 5e-6,
                "tangent" => 5e-8,
                "linear, opens" => 1e-7,
                _ => 1e-9,
            };
            assert!(power < limit, "{name}: {power:e}");
            // From the samples alone the closure shows the error of the trapezoid rule.
            let coarse = found(&run, Integration::Samples).closure;
            assert!(closed(&coarse.wavenumber) > 1e-5, "{name}");
        });
}

/// Fourier integrals of force and mean speed of a linear chain by Simpson's rule over its samples.
#[test]
fn val_simpson_the_low_band_inside_the_stepping() {
    let chain = changed(Chain::dimer(8, 2.0), |it| it.law = spring(0.0, 0.0).into());
    let (end, last) = (12.0, 1200);
    let run = simulate(chain, None, end, last + 1);
    let flow = found(&run, Integration::Stepping).frequency.unwrap();
    let (force, v) = (run.force.as_ref().unwrap(), &run.velocity);
    let bins = (flow.edge * end * (1.0 + 1e-9)) as usize;
    let low = (0..=bins).map(|m| {
        let mut sums = [0.0; 4];
        for i in 0..=last {
            let weight = end / last as f64 / 3.0
                * if i % last == 0 {
                    1.0
                } else {
                    2.0 * (1 + i % 2) as f64
                };
            let (sin, cos) = (std::f64::consts::TAU * (m * i) as f64 / last as f64).sin_cos();
            let values = [force[[i, 0]], 0.5 * (v[[i, 0]] + v[[i, 1]])];
            let terms = values
                .into_iter()
                .flat_map(|value| [value * cos, value * sin]);
            sums.iter_mut()
                .zip(terms)
                .for_each(|(sum, term)| *sum += weight * term);
        }
        let power = sums[0] * sums[2] + sums[1] * sums[3];
        if m == 0 {
            power / end
        } else {
            2.0 * power / end
        }
    });
    let (low, found) = (low.sum::<f64>(), flow.refined[0]);
    assert!((found.low - low).abs() < 1e-9, "{found:?} {low}");
}

/// Scale budgets of a chain long enough for many sites, and of one whose wall drives and damps.
#[test]
fn val_identity_scales_of_a_long_chain() {
    let run = simulate(Chain::dimer(120, 2.398), None, 100.0, 33);
    let found = found(&run, Integration::Stepping);
    let scales = found.scales.unwrap();
    let mapped = scales
        .scales
        .iter()
        .position(|of| of.scale == scales.map_scale)
        .unwrap();
    let [first, end] = scales.contacts[mapped];
    assert!(end - first > 50);
    let residual = closed(&found.closure.scale);
    assert!(residual > 0.0 && residual < 1e-11, "{residual:e}");

    let wave = Waveform::half_sine(0.3, 4.1);
    let chain = Chain {
        ends: fixed(1.0),
        losses: changed(Losses::default(), |it| (it.dashpot, it.drag) = (0.05, 0.01)),
        ..Chain::dimer(20, 2.0)
    };
    let run = simulate(chain, Some(Drive::Wall(wave)), 20.0, 41);
    let closure = self::found(&run, Integration::Stepping).closure;
    let (real, wave) = (closed(&closure.real_space), closed(&closure.wavenumber));
    assert!(real < 1e-8 && wave < 1e-8, "{real:e} {wave:e}");
}

/// A spoiled record differs from the stepping, and the departure shows it.
#[test]
fn a_spoiled_record_departs_from_the_stepping() {
    let run = simulate(Chain::dimer(26, 2.398), None, 20.0, 21);
    let departure = |run: &Run| found(run, Integration::Stepping).closure.departure;
    assert!(departure(&run) < Some(1e-9));
    let mut wrong = run.clone();
    wrong.velocity.row_mut(15).mapv_inplace(|v| 1.01 * v);
    assert!(departure(&wrong) > Some(1e-4));
}

/// The balance over a window uses its sites and samples alone.
#[test]
fn a_window_balances_by_itself() {
    let run = simulate(Chain::dimer(26, 2.398), None, 60.0, 61);
    let motion = Motion::of(&run).unwrap();
    let residual = |window| {
        let request = changed(BudgetRequest::default(), |it| it.window = Some(window));
        closed(&budget(&motion, &request).unwrap().0.closure.real_space)
    };
    let whole = residual([0..61, 0..26]);
    for window in [[10..40, 3..9], [0..61, 25..26], [30..61, 0..1]] {
        let part = residual(window);
        assert!(part < 1e-10 && part <= 2.0 * whole, "{part:e} {whole:e}");
    }
    // A wrong energy at one contact shows in the balance there, and nowhere else.
    let mut wrong = run.clone();
    wrong
        .energy_passed
        .as_mut()
        .unwrap()
        .column_mut(12)
        .mapv_inplace(|w| 0.99 * w);
    let motion = Motion::of(&wrong).unwrap();
    let residual = |sites| {
        let request = BudgetRequest {
            window: Some([0..61, sites]),
            ..BudgetRequest::default()
        };
        closed(&budget(&motion, &request).unwrap().0.closure.real_space)
    };
    assert!(residual(12..14) > 1e-3 && residual(0..12) < 1e-9 && residual(14..26) < 1e-9);
}

/// Fitted slopes of the residuals against the sampling interval. At an opening contact forces vary
/// like `t^{3/2}`, so the trapezoid sum of F v has order 5/2. T varies like `t^{1/4}`, in both
/// signs.
#[test]
fn val_observed_order_from_samples() {
    let chain = Chain::dimer(26, 2.398);
    let residuals: Vec<[f64; 4]> = [256, 512, 1024, 2048, 4096]
        .map(|steps| {
            let run = simulate(chain.clone(), None, 60.0, steps + 1);
            let closure = found(&run, Integration::Samples).closure;
            let all = [&closure.wavenumber, &closure.frequency, &closure.scale];
            let [wavenumber, frequency, scale] = all.map(closed);
            [steps as f64, wavenumber, frequency, scale]
        })
        .to_vec();
    let slope = |of: usize| {
        let points = residuals.iter().map(|row| (-row[0].ln(), row[of].ln()));
        let n = residuals.len() as f64;
        let (x, y) = points
            .clone()
            .fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
        let products = points.map(|(u, v)| ((u - x) * (v - y), (u - x) * (u - x)));
        let (up, down) = products.fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
        up / down
    };
    let [wavenumber, frequency, scale] = [1, 2, 3].map(slope);
    assert!((wavenumber - 1.5).abs() < 0.1, "{wavenumber}");
    assert!((frequency - 2.5).abs() < 0.1, "{frequency}");
    assert!((scale - 2.0).abs() < 0.1, "{scale}");
}

/// Fourth-order time differences of E(k) against T - L.
#[test]
fn val_differences_of_the_energy_spectrum() {
    for losses in [
        Losses::default(),
        changed(Losses::default(), |it| (it.tangent, it.drag) = (0.05, 0.01)),
    ] {
        let chain = changed(Chain::dimer(24, 4.0), |it| it.losses = losses);
        // Samples so dense that the error of fourth-order differences is rounding over h.
        let run = simulate(chain, None, 20.0, 8001);
        let motion = Motion::of(&run).unwrap();
        let (_, arrays) = budget(&motion, &BudgetRequest::default()).unwrap();
        let h = run.time[1];
        let energy = &arrays[&LargeArray::ENERGY_SPECTRUM];
        let transfer = &arrays[&LargeArray::TRANSFER];
        let loss = arrays.get(&LargeArray::LOSS_SPECTRUM);
        let largest = transfer.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        let mut off: Vec<f64> = Vec::new();
        for i in (2..7999).step_by(7) {
            for m in 0..transfer.ncols() {
                let e = |j: usize| energy[[j, m]];
                let slope = (8.0 * (e(i + 1) - e(i - 1)) - (e(i + 2) - e(i - 2))) / (12.0 * h);
                let rate = transfer[[i, m]] - loss.map_or(0.0, |loss| loss[[i, m]]);
                off.push((slope - rate).abs() / largest);
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
    use std::f64::consts::PI;
    let (n, kept) = (64, 6);
    let ring = Chain {
        ends: Ends::Periodic,
        precompression: 1e-3,
        ..Chain::dimer(n, 2.0)
    };
    let run = simulate(ring.clone(), None, 20.0, 8001);
    let request = BudgetRequest {
        filter: Filter::Sharp,
        scales: vec![n as f64 / kept as f64],
        ..BudgetRequest::default()
    };
    let (_, arrays) = budget(&Motion::of(&run).unwrap(), &request).unwrap();
    let passes = |m: usize| m <= kept || m >= n / 2 - kept;
    let low = |array: LargeArray, i: usize| -> f64 {
        let row = arrays[&array].row(i);
        let kept = row.iter().enumerate().filter(|(m, _)| passes(*m));
        kept.map(|(_, value)| value).sum()
    };
    // Rows filtered by sums over cells, each sublattice separately.
    let filtered = |row: &dyn Fn(usize) -> f64, j: usize| -> f64 {
        let cells = n / 2;
        let gain = |away: usize| {
            let angle = |m: usize| 2.0 * PI * ((away * m) % cells) as f64 / cells as f64;
            1.0 + 2.0 * (1..=kept).map(|m| angle(m).cos()).sum::<f64>()
        };
        let terms = (0..cells).map(|c| gain(c) * row((j + 2 * c) % n));
        terms.sum::<f64>() / cells as f64
    };
    let x = run.displacement.as_ref().unwrap();
    let coarse = |i: usize| -> f64 {
        let energy = |j: usize| {
            let speed = filtered(&|j| run.velocity[[i, j]], j);
            let overlap = filtered(&|j| x[[i, j]] - x[[i, (j + 1) % n]], j);
            let (c, d0) = (ring.coefficient[j], ring.static_overlap(j));
            0.5 * speed * speed + ring.law.of(0).energy(c, d0, overlap)
        };
        (0..n).map(energy).sum()
    };
    let flux = &arrays[&LargeArray::SCALE_FLUX_IN_TIME];
    let (mut sums, mut gap) = ([0.0; 2], 0f64);
    let h = run.time[1];
    let apart = |i: usize| low(LargeArray::ENERGY_SPECTRUM, i) - coarse(i);
    let start = apart(0);
    for i in 1..=8000 {
        for (sum, rate) in sums.iter_mut().zip([
            flux[[i - 1, 0]] + flux[[i, 0]],
            -low(LargeArray::TRANSFER, i - 1) - low(LargeArray::TRANSFER, i),
        ]) {
            *sum += 0.5 * h * rate;
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
