//! Trailing pulses behind the leading one at kappa = 2.398: Figure 3 of the paper.
//!
//! Equation: `x_j'' = F_{j-1} - F_j`, `F_j = c_j max(x_j - x_{j+1}, 0)^{3/2}`, c alternately 1 and
//! kappa, 300 sites, site 0 struck at unit speed.
//! Command: `cargo run --release -p figures --bin fig03_trailing_pulses`; under a second.
//! Shows: velocities of sites 29 and 30, forces in contacts 29 and 30.
//! Asserts: behind the leading pulse contacts open, and carry more than a tenth of its peak force.
//! Differs: the paper does not say which contact the striker touches nor whether it counts sites from
//! the striker on; here it touches a soft one and is site 0.

use wavecascade::chain::{Chain, Simulation};
use wavecascade::observer::Silent;

use figures::{Curve, Panel, around, save};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let simulation = Simulation::impact(Chain::dimer(300, 2.398), 1.0, 80.0, 8001);
    let run = simulation.run(&Silent)?;
    let force = run.force.as_ref().ok_or("no forces")?;
    let curve = |values: ndarray::ArrayView1<f64>| -> Vec<(f64, f64)> {
        let points = run.time.iter().copied().zip(values.iter().copied());
        points.filter(|p| (20.0..=80.0).contains(&p.0)).collect()
    };
    let velocities = vec![
        ("site 29", curve(run.velocity.column(29))),
        ("site 30", curve(run.velocity.column(30))),
    ];
    let forces = vec![
        ("contact 29 (stiff)", curve(force.column(29))),
        ("contact 30 (soft)", curve(force.column(30))),
    ];

    let mut opened = 0;
    for (name, points) in &forces {
        let leading = (0..points.len())
            .max_by(|a, b| points[*a].1.total_cmp(&points[*b].1))
            .ok_or("no samples")?;
        let falling = points[leading..].windows(2).take_while(|w| w[1].1 < w[0].1);
        let trailing = &points[leading + falling.count()..];
        let largest = trailing.iter().fold(0.0, |m: f64, p| m.max(p.1));
        let share = largest / points[leading].1;
        let open = trailing.iter().filter(|p| p.1 <= 0.0).count();
        println!(
            "{name}: largest trailing force over the leading peak {share:.3}; open at {open} of {} \
             samples",
            trailing.len()
        );
        assert!(share > 0.1);
        opened += open;
    }
    assert!(opened > 0);

    let panel = |title: &str, y_label, curves: Vec<Curve>| Panel {
        title: title.into(),
        x_label: "time (dimensionless)",
        y_label,
        x: 20.0..80.0,
        y: around(&curves),
        curves,
    };
    let panels = [
        panel(
            "velocity, κ = 2.398",
            "velocity (dimensionless)",
            velocities,
        ),
        panel("force, κ = 2.398", "force (dimensionless)", forces),
    ];
    save("fig03_trailing_pulses", 2, &panels)
}
