//! Time of flight and mean speed against the first angle: Figure 9 of the paper.
//!
//! Equation: as Figure 7; the time from the impact until the force on the sensor is 1 % of its peak,
//! and 40 cylinders of 18 mm over it.
//! Command: `cargo run --release -p figures --bin fig09_time_of_flight`; 2.3 s of processor time.
//! Shows: the pulse arrives earlier the smaller the angle; the sensor's contact changes next to
//! nothing.
//! Asserts: the time falls with the angle at every step, from 1.083 ms (665 m/s) at 90 degrees to
//! 0.833 ms at 2 degrees (1.076 ms, 669 m/s, and 0.826 ms with a nearly flat cap).
//! Differs: the paper does not say what counts as an arrival, and gives no numbers.

use std::fmt::Write;

use wavecascade::attenuation::{TransmissionPoint, TransmissionRequest};
use wavecascade::observer::Silent;
use wavecascade::plot::{Chart, Look, Series};

use figures::{Outcome, experiment_scene, save_charts, write};

const SENSORS: [(&str, &str); 2] = [
    ("cap rounded at 20 mm", "20 mm"),
    ("cap nearly flat", "1 m"),
];

fn main() -> Outcome<()> {
    let (mut times, mut speeds) = (Vec::new(), Vec::new());
    let mut text = String::from("sensor,first_angle_degrees,time_of_flight_s,mean_speed_m_s\n");
    for (i, (name, radius)) in SENSORS.into_iter().enumerate() {
        let scene = experiment_scene(&[("wall_radius", radius)])?;
        let mut request = TransmissionRequest::new(scene, "angle=2:90:45");
        request.locate = false;
        let found = request.run(None, &Silent)?;
        let points = &found.curves[0].points;
        for p in points {
            let (time, speed) = (p.time_of_flight.value, p.mean_speed);
            writeln!(text, "{name},{:.5},{time:.9e},{speed:.6}", p.value)?;
        }
        let look = [Look::Line, Look::Dashed][i];
        let curve = |value: &dyn Fn(&TransmissionPoint) -> f64| {
            let points = points.iter().map(|p| (p.value, value(p)));
            Series::line(name, i, points.collect()).with(look)
        };
        times.push(curve(&|p| 1e3 * p.time_of_flight.value));
        speeds.push(curve(&|p| p.mean_speed));
        let (first, last) = (points[0], points[points.len() - 1]);
        println!(
            "{name}: {:.4} ms at {} degrees, {:.4} ms and {:.1} m/s at {}",
            1e3 * first.time_of_flight.value,
            first.value,
            1e3 * last.time_of_flight.value,
            last.mean_speed,
            last.value
        );
        let rising = points.windows(2);
        assert!(
            rising
                .into_iter()
                .all(|p| p[0].time_of_flight.value < p[1].time_of_flight.value)
        );
        assert!((last.mean_speed - [665.0, 668.9][i]).abs() < 0.1);
        assert!((1e3 * first.time_of_flight.value - [0.8332, 0.8258][i]).abs() < 2e-4);
    }
    write("fig09_time_of_flight.csv", text.as_bytes())?;
    let angle = "first angle (degrees)";
    let charts = [
        Chart::of(
            "time of flight through 40 cylinders",
            angle,
            "time (ms)",
            times,
        ),
        Chart::of("mean speed", angle, "speed (m/s)", speeds),
    ];
    save_charts("fig09_time_of_flight", 2, &charts)
}
