//! Trailing pulses behind the leading one at kappa = 2.398: Figure 3 of the paper.
//!
//! Equation: `x_j'' = F_{j-1} - F_j`, `F_j = c_j max(x_j - x_{j+1}, 0)^{3/2}`, c alternately 1 and
//! kappa, 300 sites, site 0 struck at unit speed.
//! Command: `cargo run --release --example fig03_trailing_pulses`; under a second.
//! Shows: velocities of sites 29 and 30, forces in contacts 29 and 30.
//! Asserts: contacts open and close again behind the leading pulse, and hold a force of at least a
//! tenth of its peak there.

#[path = "panels/mod.rs"]
mod panels;

use cascade::analyze::Silent;
use cascade::chain::{Chain, Simulation};
use panels::{Panel, around, save};

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

    for (name, points) in &forces {
        let first = points.iter().position(|p| p.1 > 1e-3).ok_or("no pulse")?;
        let opening = points[first..]
            .iter()
            .position(|p| p.1 <= 0.0)
            .ok_or("never open")?;
        let (leading, trailing) = points.split_at(first + opening);
        let peak = |part: &[(f64, f64)]| part.iter().fold(0.0, |m: f64, p| m.max(p.1));
        let share = peak(trailing) / peak(leading);
        println!("{name}: largest trailing force over the leading peak {share:.3}");
        assert!(share > 0.1);
    }

    let panel = |title: &str, y_label, curves| Panel {
        title: title.into(),
        x_label: "time",
        y_label,
        x: 20.0..80.0,
        y: around(&curves),
        curves,
    };
    let panels = [
        panel("velocity, kappa = 2.398", "velocity", velocities),
        panel("force, kappa = 2.398", "force", forces),
    ];
    save("fig03_trailing_pulses", 2, &panels)
}
