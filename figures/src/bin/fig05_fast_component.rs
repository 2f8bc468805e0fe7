//! The fast part of the exact waves in the stiff contacts, beside Figure 5 of the paper, which draws another.
//!
//! Equation: `[psi - ((F(t+h) + F(t-h))/2)^{2/3}] / eps`, psi at stiff and F at soft contacts of the
//! localized waves, `eps = kappa^{-2/3}`: what the paper expands to first order, exactly.
//! Command: `cargo run --release -p figures --bin fig05_fast_component`; seconds.
//! Shows: orders 2 to 7, time in cells.
//! Asserts: as many maxima as the order says, counted on the drawn curve; evenness within the
//! root of a force's rounding error; that the curve ends where nothing is left, below 1e-8 of its
//! largest value.
//! Differs: these are no solutions of the paper's equation 17, which it draws. That equation is of first order in
//! eps and driven by a fitted slow wave; its ratios are up to 42 % off (`table1_stiffness_ratios`).

use figures::{Panel, around, save};
use wavecascade::localized::Family;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let search = Family::default().search(7)?;
    let mut panels = Vec::new();
    for order in 2..=7 {
        let wave = search.wave(order)?;
        let eps = wave.ratio.powf(-2.0 / 3.0);
        let points: Vec<(f64, f64)> = (-2250..=2250)
            .map(|j| 0.002 * f64::from(j))
            .map(|t| (t, wave.fast_part(t) / eps))
            .collect();
        let maxima = points
            .windows(3)
            .filter(|w| w[1].1 > w[0].1 && w[1].1 >= w[2].1 && w[1].1.abs() > 1e-4)
            .count();
        println!("order {order}: kappa = {:.6}, {maxima} maxima", wave.ratio);
        assert_eq!(maxima, order);
        let largest = points.iter().fold(0.0, |m: f64, p| m.max(p.1.abs()));
        assert!(
            points[0].1.abs() < 1e-8 * largest,
            "order {order}: cut short at {:.1e} of its largest value",
            points[0].1.abs() / largest
        );
        let mirrored = points.iter().rev();
        let uneven = points.iter().zip(mirrored).map(|(a, b)| (a.1 - b.1).abs());
        let uneven = uneven.fold(0.0, f64::max);
        // Where a force is its rounding error, the slow part is the root of that.
        assert!(uneven < 10.0 * f64::EPSILON.powf(2.0 / 3.0) / eps);
        let curves = vec![("", points)];
        panels.push(Panel {
            title: format!("order {order}, κ = {:.4}", wave.ratio),
            x_label: "time (cells)",
            y_label: "fast component (dimensionless)",
            x: -4.5..4.5,
            y: around(&curves),
            curves,
        });
    }
    save("fig05_fast_component", 2, &panels)
}
