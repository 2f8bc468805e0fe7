//! Where the energy of a struck dimer goes, in three views: over wavenumbers, over scales, along x.
//!
//! Equations: `dE(k)/dt = T(k)`, `Pi(k) = - sum_{k' <= k} T(k')`;
//! `Pi_l = (bar F - F(bar delta)) (bar v_j - bar v_{j+1})`; `J_j = F_j (v_j + v_{j+1}) / 2`.
//! Command: `cargo run --release -p figures --bin energy_views`; a few seconds.
//! Shows: for a ratio that carries a localized wave (4.9272) and for one that sheds trailing pulses
//! (2.398), energy that passed to higher k in the second half of the record (the first holds
//! the impact, which starts with E(k) flat), energy that left the scales larger than l where the
//! filter fits into the chain, and energy that passed through x. 200 sites, before the wall is felt.
//! Asserts: every balance closes to 1e-9 of the energy; the
//! localized wave passes three quarters of the chain with four fifths of the energy, all but what the
//! impact left at the striker's end, the dispersive chain with less than half of that; over scales the
//! localized wave exchanges a few per cent on the whole, a fifth of what the dispersive chain does.

use std::fmt::Write;

use wavecascade::budget::{Budget, BudgetRequest, ComparedBudgets, Integration, Motion, budget};
use wavecascade::chain::{Chain, Simulation};
use wavecascade::observer::Silent;
use wavecascade::plot::{Format, Style, figures_of};
use wavecascade::sheet::Sheet;

const SITES: usize = 200;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let of = |ratio: f64, end: f64| -> Result<Budget, Box<dyn std::error::Error>> {
        let simulation = Simulation::impact(Chain::dimer(SITES, ratio), 1.0, end, 2049);
        let run = simulation.run(&Silent)?;
        let request = BudgetRequest {
            integration: Integration::Stepping,
            ..BudgetRequest::default()
        };
        let (found, _) = budget(&Motion::of(&run)?, &request)?;
        let closure = &found.closure;
        println!(
            "ratio {ratio}: residuals in real space {:.1e}, over k {:.1e}, over f {:.1e}, over l {:.1e}",
            closure.real_space.value().ok_or("no balance")?,
            closure.wavenumber.value().ok_or("no balance")?,
            closure.frequency.value().ok_or("no balance")?,
            closure.scale.value().ok_or("no balance")?,
        );
        for residual in [&closure.real_space, &closure.wavenumber, &closure.scale] {
            assert!(residual.value().is_some_and(|residual| residual < 1e-10));
        }
        assert!(
            closure
                .frequency
                .value()
                .is_some_and(|residual| residual < 1e-9)
        );
        Ok(found)
    };
    let localized = of(4.9272, 190.0)?;
    let dispersive = of(2.398, 205.0)?;

    // Before the front, at three quarters of the chain.
    let passed = |budget: &Budget| budget.passed[3 * SITES / 4] / budget.scale;
    let exchanged = |budget: &Budget| -> f64 {
        let flux = budget
            .scales
            .iter()
            .flat_map(|scales| &scales.integrated_flux);
        flux.fold(f64::NAN, |m: f64, flux| m.max(flux.abs())) / budget.scale
    };
    let numbers = [&localized, &dispersive].map(|budget| (passed(budget), exchanged(budget)));
    println!(
        "passed three quarters of the chain; most that was exchanged over scales: {numbers:?}"
    );
    let [(kept, at_rest), (shed, exchange)] = numbers;
    assert!((kept - 0.814).abs() < 0.005 && shed < 0.5 * kept);
    assert!((at_rest - 0.027).abs() < 0.002 && (exchange - 0.158).abs() < 0.005);

    let out = figures::root().join("figures/out");
    let both = [("localized", &localized), ("dispersive", &dispersive)];
    let compared = ComparedBudgets {
        both: both.map(|(name, budget)| (name.to_owned(), budget.clone())),
        summaries: both.map(|(_, budget)| budget.describe(None).numbers.into()),
    };
    let sheet = Sheet::default();
    let figures = figures_of(&compared, &sheet, "", "views", &Style::screen());
    let figure = figures.first().ok_or("nothing to draw")?;
    for format in [Format::Png, Format::Svg] {
        let file = out.join(format!("energy_views.{}", format.extension()));
        std::fs::write(&file, figure.encode(format)?)?;
        println!("{}", file.display());
    }
    std::fs::write(out.join("energy_views.csv"), table(&both)?)?;
    Ok(())
}

/// What the figure draws.
fn table(both: &[(&str, &Budget)]) -> Result<String, Box<dyn std::error::Error>> {
    let mut text = String::from("chain,view,at,share_of_energy\n");
    for (name, budget) in both {
        let mut rows = |view: &str, at: &mut dyn Iterator<Item = f64>, values: &[f64]| {
            for (at, value) in at.zip(values) {
                let _ = writeln!(text, "{name},{view},{at:.9},{:.9}", value / budget.scale);
            }
        };
        let found = budget.wavenumber.as_ref().ok_or("no wavenumbers")?;
        rows("k", &mut found.wavenumber.iter().copied(), &found.late_flux);
        let scales = budget.scales.as_ref().ok_or("no scales")?;
        let lengths = scales.scales.iter().map(|scale| scale.scale);
        rows("l", &mut { lengths }, &scales.integrated_flux);
        let places = (0..budget.n_contacts).map(|j| j as f64 + 0.5);
        rows("x", &mut { places }, &budget.passed);
    }
    Ok(text)
}
