//! Localized pulses at the first four orders: Figure 4 of the paper.
//!
//! Equation: that of `wavecascade::localized`, solved; then a chain of 300 sites at each of its ratios,
//! struck at unit speed.
//! Command: `cargo run --release -p figures --bin fig04_localized_pulses`; seconds.
//! Shows: velocities of sites 29 and 30 and forces in contacts 29 and 30 about the leading pulse,
//! at kappa of orders 1 to 4; in the lowest row also what follows it.
//! Asserts: the simulated leading pulse is the localized wave, scaled; its forces are symmetric in
//! time, its velocities are not, beyond order 1. Behind it the impact itself leaves pulses of its own, slower
//! ones: the largest velocity that follows is below 1e-6, 0.1007, 0.0129 and below 0.001 at orders 1 to 4, of
//! 0.474 of the leading pulse at order 2.
//! Differs: ratios are those of the exact waves, which the paper's direct ones match to 1e-4.

use wavecascade::chain::{Chain, Simulation};
use wavecascade::localized::{Family, Wave};
use wavecascade::observer::Silent;
use wavecascade::plot::Chart;

use figures::{Curve, Panel, around, save_as};

/// Times drawn about the leading pulse, and until the last one that is known at every order.
const ABOUT: f64 = 8.0;
const FOLLOWS: f64 = 32.0;
const TIME: &str = "time from the peak in contact 30 (dimensionless)";
const VELOCITY: &str = "velocity (dimensionless)";
const FORCE: &str = "force (dimensionless)";
const ORDERS: [&str; 4] = ["order 1", "order 2", "order 3", "order 4"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let search = Family::default().search(4)?;
    let mut panels = Vec::new();
    let mut followed = [Vec::new(), Vec::new()];
    for order in 1..=4 {
        let wave = search.wave(order)?;
        let simulation = Simulation::impact(Chain::dimer(300, wave.ratio), 1.0, 70.0, 14_001);
        let run = simulation.run(&Silent)?;
        let force = run.force.as_ref().ok_or("no forces")?;
        let soft = force.column(30);
        let peak = (0..soft.len())
            .max_by(|a, b| soft[*a].total_cmp(&soft[*b]))
            .ok_or("no samples")?;
        let centre = run.time[peak];
        let curve = |values: ndarray::ArrayView1<f64>| -> Vec<(f64, f64)> {
            let points = run.time.iter().zip(values).map(|(t, v)| (t - centre, *v));
            points
                .filter(|p| (-ABOUT..FOLLOWS).contains(&p.0))
                .collect()
        };
        let velocity = curve(run.velocity.column(30));
        let behind = velocity.iter().filter(|p| p.0 > 5.0).map(|p| p.1);
        let behind = behind.fold(0.0, f64::max);
        let expected = [0.0, 0.1007, 0.0129, 0.0005][order - 1];
        let within = [1e-6, 1e-4, 1e-4, 5e-4][order - 1];
        println!("order {order}: behind the leading pulse velocities up to {behind:.4}");
        assert!((behind - expected).abs() <= within);
        let label = ORDERS[order - 1];
        followed[0].push((label, velocity));
        followed[1].push((label, curve(soft)));

        // The wave at the amplitude of the simulated one: forces and times scale as one.
        let scale = soft[peak] / Wave::peak(&wave.force[0]).1;
        let rate = scale.powf(1.0 / 6.0);
        let far = curve(soft)
            .iter()
            .filter(|p| p.0.abs() < 2.0 / rate)
            .map(|(t, f)| (f - scale * wave.force[0].value(t * rate)).abs())
            .fold(0.0, f64::max)
            / soft[peak];
        let [velocity, force_asymmetry] = [&wave.velocity[0], &wave.force[0]].map(Wave::asymmetry);
        println!(
            "order {order}: simulated force within {far:.1e} of the wave; asymmetry of the \
             velocity {velocity:.2e}, of the force {force_asymmetry:.1e}"
        );
        assert!(far < 0.02 && force_asymmetry < 1e-10);
        assert_eq!(velocity > 0.05, order > 1);

        let panel = |y_label, curves: Vec<Curve>| Panel {
            title: format!("order {order}, κ = {:.4}", wave.ratio),
            x_label: TIME,
            y_label,
            x: -ABOUT..ABOUT,
            y: around(&curves),
            curves,
        };
        panels.push(panel(
            VELOCITY,
            vec![
                ("site 29", curve(run.velocity.column(29))),
                ("site 30", curve(run.velocity.column(30))),
            ],
        ));
        panels.push(panel(
            FORCE,
            vec![
                ("contact 29 (stiff)", curve(force.column(29))),
                ("contact 30 (soft)", curve(soft)),
            ],
        ));
    }
    let names = ["what follows, site 30", "what follows, contact 30 (soft)"];
    for ((title, y_label), curves) in names.into_iter().zip([VELOCITY, FORCE]).zip(followed) {
        panels.push(Panel {
            title: title.into(),
            x_label: TIME,
            y_label,
            x: -ABOUT..FOLLOWS,
            y: 1e-3..1.0,
            curves,
        });
    }
    save_as("fig04_localized_pulses", 2, &panels, |i, chart| Chart {
        log_y: i >= 8,
        ..chart
    })
}
