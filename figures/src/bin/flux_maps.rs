//! Where and when energy moves: along the chain, over wavenumbers, and out of a scale.
//!
//! Equations: `J_j = F_j (v_j + v_{j+1}) / 2`; `Pi(k) = - sum_{k' <= k} T(k')`;
//! `Pi_l = (bar F - F(bar delta)) (bar v_j - bar v_{j+1})`, of `wavecascade::budget`.
//! Command: `cargo run --release -p figures --bin flux_maps`; four seconds.
//! Shows: fluxes of a chain that carries a localized wave (4.9272, left) and of one that sheds
//! trailing pulses (2.398, right), on scales shared in each row; 100 sites, before the wall is felt.
//! Third row: Pi(k) integrated since the front was at site 20, when the impact has been taken up.
//! Asserts: balances close to 1e-10 of the energy. The localized wave takes four fifths of the energy
//! through three quarters of the chain, the dispersive one a quarter. Pi(k, t) is twice as large for the
//! localized wave, which moves energy up and down in k in each cell; what is left of it at the end is
//! 11 % of the energy at most, near k = 0, for the dispersive chain 48 %, towards low k. Out of a scale
//! of four cells a localized wave takes at its front what it gives back behind it, to 1 %.
//! Differs: the paper has no fluxes; its maps show spectra, from which no flux follows.

use ndarray::s;
use wavecascade::analyze::Map;
use wavecascade::arrays::LargeArray;
use wavecascade::budget::{Budget, BudgetRequest, Integration, Motion, budget};
use wavecascade::chain::{Chain, Simulation};
use wavecascade::observer::Silent;
use wavecascade::plot::{Chart, Colors, FigureLayout, Style, magnitudes, ordinary};

use figures::{Outcome, cells, expect, map, save_maps};

const SITES: usize = 100;

const WHAT: [&str; 4] = [
    "energy passed three quarters of the chain",
    "most that passed a k since the front was at site 20",
    "mean |Pi(k)| in the second half",
    "net over gross flux out of the scale",
];

struct Fluxes {
    budget: Budget,
    /// `Pi` integrated since the front was at site 20, as shares of the energy.
    passed_k: Map,
    numbers: [f64; 4],
}

fn main() -> Outcome<()> {
    let [localized, dispersive] =
        [(4.9272, 92.0), (2.398, 99.0)].map(|(ratio, end)| fluxes(ratio, end));
    let (localized, dispersive) = (localized?, dispersive?);
    let both = [&localized, &dispersive];

    let expected = [
        [0.814, 0.114, 0.0133, 0.008],
        [0.255, -0.484, 0.0059, 0.085],
    ];
    for ((name, of), expected) in ["localized", "dispersive"].iter().zip(both).zip(expected) {
        expect(name, WHAT, of.numbers, expected, 0.005);
        let closure = &of.budget.closure;
        for residual in [&closure.real_space, &closure.wavenumber, &closure.scale] {
            assert!(residual.value().is_some_and(|residual| residual < 1e-10));
        }
    }
    assert!((both[0].numbers[2] / both[1].numbers[2] - 2.2).abs() < 0.2);

    let names = ["localized, κ = 4.9272", "dispersive, κ = 2.398"];
    let mut maps: Vec<(String, &Map)> = Vec::new();
    for (of, name) in both.iter().zip(names) {
        let over_k = of.budget.wavenumber.as_ref().ok_or("no wavenumbers")?;
        let scales = of.budget.scales.as_ref().ok_or("no scales")?;
        let scale_map = scales.flux_map.as_ref().ok_or("no map of a scale")?;
        maps.push((format!("J(x, t): {name}"), &of.budget.flux_map));
        maps.push((format!("Π(k, t): {name}"), &over_k.flux_map));
        maps.push((format!("∫ Π(k) dt: {name}"), &of.passed_k));
        maps.push((
            format!("Π_l(x, t), l = {}: {name}", scales.map_scale),
            scale_map,
        ));
    }
    let tiles = (0..8).map(|index| {
        let (row, column) = (index / 2, index % 2);
        let pair = [maps[row].1, maps[row + 4].1];
        let (title, map) = &maps[row + 4 * column];
        let limit = magnitudes(pair.into_iter())[1];
        Chart {
            title: title.clone(),
            colors: match row {
                2 => Colors::about_zero(ordinary(pair.into_iter())),
                _ => Colors::Signed {
                    limit,
                    decades: if row == 0 { 3.0 } else { 2.0 },
                },
            },
            ..Chart::of_map(map)
        }
    });
    let note = concat!(
        "positive: towards +x, towards high k, out of the scales larger than l. Third row: since the front was at site 20. ",
        "Grey: before that; where the filter does not fit into the chain. One cell in 200 is beyond the ends of linear scales.",
    );
    let layout = FigureLayout {
        notes: vec![note.into()],
        ..FigureLayout::grid("Fluxes of energy (no dimensions)", 2, tiles)
    };
    let figure = layout.figure("flux_maps", &Style::screen());
    let named: Vec<(&str, &Map)> = maps
        .iter()
        .map(|(name, map)| (name.as_str(), *map))
        .collect();
    save_maps(&figure, &named)
}

fn fluxes(ratio: f64, end: f64) -> Outcome<Fluxes> {
    let simulation = Simulation::impact(Chain::dimer(SITES, ratio), 1.0, end, 1025);
    let run = simulation.run(&Silent)?;
    let request = BudgetRequest {
        integration: Integration::Stepping,
        ..BudgetRequest::default()
    };
    let (budget, arrays) = budget(&Motion::of(&run)?, &request)?;
    let moving = run.velocity.column(20).iter().position(|v| *v > 0.01);
    let start = moving.ok_or("the front does not arrive")?;
    let mut passed = arrays[&LargeArray::INTEGRATED_SPECTRAL_FLUX].clone() / budget.scale;
    let before = passed.row(start).to_owned();
    passed -= &before;
    passed.slice_mut(s![..start, ..]).fill(f64::NAN);
    let over_k = budget.wavenumber.as_ref().ok_or("no wavenumbers")?;
    let k = cells("wavenumber k (rad per site)", &over_k.wavenumber);
    let axes = [k, cells("time", &budget.time)];
    let label = "energy passed to higher k (share of all)";
    let passed_k = map(label, passed.view(), axes);
    let last = passed.row(passed.nrows() - 1);
    let most = last
        .iter()
        .fold(0.0f64, |m, v| if v.abs() > m.abs() { *v } else { m });
    let pi = &arrays[&LargeArray::SPECTRAL_FLUX];
    let late = pi.slice(s![pi.nrows() / 2.., ..]).mapv(f64::abs);
    let out = arrays[&LargeArray::SCALE_FLUX].mapv(|v| if v.is_finite() { v } else { 0.0 });
    let numbers = [
        budget.passed[3 * SITES / 4] / budget.scale,
        most,
        late.mean().unwrap_or(f64::NAN),
        out.sum() / out.mapv(f64::abs).sum(),
    ];
    Ok(Fluxes {
        budget,
        passed_k,
        numbers,
    })
}
