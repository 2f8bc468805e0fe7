//! Where and when energy moves: along the chain, over wavenumbers, and out of a scale.
//!
//! Equations: `J_j = F_j (v_j + v_{j+1}) / 2`; `Pi(k) = - sum_{k' <= k} T(k')`;
//! `Pi_l = (bar F - F(bar delta)) (bar v_j - bar v_{j+1})`, of `cascade::budget`.
//! Command: `cargo run --release --example flux_maps`; four seconds.
//! Shows: fluxes of a chain that carries a localized wave (4.9272, left) and of one that sheds
//! trailing pulses (2.398, right), on scales shared in each row; 100 sites, before the wall is felt.
//! Third row: Pi(k) integrated since the front was at site 20, when the impact has been taken up.
//! Asserts: balances close to 1e-10 of the energy. The localized wave takes four fifths of the energy
//! through three quarters of the chain, the dispersive one a quarter. Pi(k, t) is twice as large for the
//! localized wave, which moves energy up and down in k in each cell; what is left of it at the end is
//! 11 % of the energy at most, near k = 0, for the dispersive chain 48 %, towards low k. Out of a scale
//! of four cells a localized wave takes at its front what it gives back behind it, to 1 %.
//! Differs: the paper has no fluxes; its maps show spectra, from which no flux follows.

#[path = "panels/mod.rs"]
mod panels;

use cascade::analyze::{LargeArray, Map, Silent};
use cascade::budget::{Budget, BudgetRequest, Integration, Motion, budget};
use cascade::chain::{Chain, Simulation};
use cascade::plot::{Colours, Tile, map_grid};
use panels::{Outcome, map, save_maps};

const SITES: usize = 100;

struct Fluxes {
    budget: Budget,
    /// `Pi` since the start of the map, as shares of the energy, and the map.
    passed_k: Map,
}

fn main() -> Outcome<()> {
    let [localized, dispersive] =
        [(4.9272, 92.0), (2.398, 99.0)].map(|(ratio, end)| fluxes(ratio, end));
    let (localized, dispersive) = (localized?, dispersive?);
    let both = [&localized, &dispersive];

    for (name, of) in ["localized", "dispersive"].iter().zip(both) {
        let closure = &of.budget.closure;
        for residual in [&closure.real_space, &closure.wavenumber, &closure.scale] {
            assert!(residual.value().is_some_and(|residual| residual < 1e-10));
        }
        println!("{name}: {:.4?}", numbers(of)?);
    }
    let near = |value: f64, expected: f64, within: f64| (value - expected).abs() < within;
    let [taken, back, exchanged, out] = numbers(&localized)?;
    assert!(near(taken, 0.814, 0.002) && near(back, 0.114, 0.005) && near(out, 0.0, 0.01));
    let [shed, towards_low_k, exchange, _] = numbers(&dispersive)?;
    assert!(near(shed, 0.255, 0.005) && near(towards_low_k, -0.484, 0.01));
    assert!(near(exchange / exchanged, 0.45, 0.05));

    let names = ["localized, kappa = 4.9272", "dispersive, kappa = 2.398"];
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
        Tile {
            title: title.clone(),
            map,
            colours: match row {
                0 => Colours::signed(&pair, 3.0),
                2 => Colours::diverging(&pair),
                _ => Colours::signed(&pair, 2.0),
            },
            line: &[],
            inset: None,
        }
    });
    let tiles: Vec<Tile> = tiles.collect();
    let note = [
        "positive: towards +x, towards high k, out of the scales larger than l. Third row: since the front was at site 20.",
        "Grey: before that; where the filter does not fit into the chain. One cell in 200 is beyond the ends of linear scales.",
    ];
    let figure = map_grid(
        "flux_maps",
        "Fluxes of energy (no dimensions)",
        &note,
        2,
        &tiles,
    );
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
    let mut passed = arrays[&LargeArray::IntegratedSpectralFlux].clone() / budget.scale;
    let before = passed.row(start).to_owned();
    passed -= &before;
    passed.slice_mut(ndarray::s![..start, ..]).fill(f64::NAN);
    let over_k = budget.wavenumber.as_ref().ok_or("no wavenumbers")?;
    let axis = |axis: &cascade::analyze::MapAxis| (axis.low, axis.high);
    let (k, t) = (axis(&over_k.flux_map.x), axis(&over_k.flux_map.y));
    let passed_k = map(
        "energy passed to higher k (share of all)",
        passed.view(),
        [
            ("wavenumber k (rad per site)", k.0, k.1),
            ("time", t.0, t.1),
        ],
    );
    Ok(Fluxes { budget, passed_k })
}

/// Energy through three quarters of the chain; the largest that passed a wavenumber, with its sign;
/// mean magnitude of Pi in the second half; net over gross flux out of the scale.
fn numbers(of: &Fluxes) -> Outcome<[f64; 4]> {
    let budget = &of.budget;
    let passed = &of.passed_k.values;
    let last = passed.row(passed.nrows() - 1);
    let most = last
        .iter()
        .fold(0.0f32, |m, v| if v.abs() > m.abs() { *v } else { m });
    let over_k = &budget
        .wavenumber
        .as_ref()
        .ok_or("no wavenumbers")?
        .flux_map
        .values;
    let late = over_k.slice(ndarray::s![over_k.nrows() / 2.., ..]);
    let size = late.iter().map(|v| f64::from(v.abs())).sum::<f64>() / late.len() as f64;
    let scales = budget.scales.as_ref().ok_or("no scales")?;
    let flux = &scales.flux_map.as_ref().ok_or("no map of a scale")?.values;
    let defined = || flux.iter().filter(|v| v.is_finite()).map(|v| f64::from(*v));
    let net = defined().sum::<f64>() / defined().map(f64::abs).sum::<f64>();
    Ok([
        budget.passed[3 * SITES / 4] / budget.scale,
        f64::from(most),
        size,
        net,
    ])
}
