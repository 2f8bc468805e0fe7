//! Makes measurements of struck chains whose truth is known: records with noise, errors of gains, a late clock, missing
//! samples or bodies, or of another chain than the one that is fitted. `examples/data/impact_records.csv` is the first of them.
//!
//! `cargo run --example impact_records -- DIR` writes `NAME.csv`, `NAME.truth.toml`, the scene that was run, and
//! `NAME.truth.json`, what the instruments added. `python examples/score_records.py DIR/NAME result.json` scores what a
//! method makes of a table.

use std::fmt::Write;
use std::path::PathBuf;

use wavecascade::chain::EndTime;
use wavecascade::chain::scene::SceneSource;
use wavecascade::observer::Silent;

/// The chain: twelve cylinders of quartz, struck by a sphere.
const SCENE: &str = "sites = 13
young = \"70.4 GPa\"
poisson = 0.17
density = \"2200 kg/m^3\"
radius = \"9 mm\"
length = \"18 mm\"
angle = \"18 deg\"
second_angle = \"90 deg\"
striker_radius = \"9 mm\"
striker_velocity = \"0.83 m/s\"
tangent = \"0.6 us\"
";

const BODIES: [usize; 6] = [2, 4, 6, 8, 10, 12];
const SAMPLES: usize = 401;
const END: f64 = 0.4e-3;

struct Measurement {
    name: &'static str,
    /// In place of the line that begins alike.
    instead: &'static str,
    /// Over the root mean square of all records.
    noise: f64,
    correlation: f64,
    gain_error: f64,
    late: f64,
    missing: bool,
    bodies: &'static [usize],
    /// What is wrong with the scene that is fitted, as `cascade fit` names it.
    wrong: Option<&'static str>,
}

/// White noise of 4 %, and all else as it should be.
const PLAIN: Measurement = Measurement {
    name: "impact_records",
    instead: "",
    noise: 0.04,
    correlation: 0.0,
    gain_error: 0.0,
    late: 0.0,
    missing: false,
    bodies: &BODIES,
    wrong: None,
};

const ALL: [Measurement; 8] = [
    PLAIN,
    Measurement {
        name: "coloured_noise",
        correlation: 0.8,
        ..PLAIN
    },
    Measurement {
        name: "gains_and_clock",
        noise: 0.02,
        gain_error: 0.02,
        late: 7e-6,
        ..PLAIN
    },
    Measurement {
        name: "missing_samples",
        missing: true,
        ..PLAIN
    },
    Measurement {
        name: "other_angle",
        instead: "second_angle = \"70 deg\"",
        noise: 0.02,
        wrong: Some("second_angle"),
        ..PLAIN
    },
    Measurement {
        name: "heavy_body",
        instead: "tangent = \"0.6 us\"\n[[defect]]\nsite = 7\nfactor = 1.2",
        noise: 0.02,
        wrong: Some("mass of body 7"),
        ..PLAIN
    },
    Measurement {
        name: "two_bodies",
        bodies: &[4, 10],
        ..PLAIN
    },
    Measurement {
        name: "all_at_once",
        correlation: 0.5,
        gain_error: 0.02,
        late: 7e-6,
        missing: true,
        ..PLAIN
    },
];

/// SplitMix64 and the method of Box and Muller.
struct Normal(u64);

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((z ^ (z >> 31)) >> 11) + 1) as f64 / (1u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

impl Measurement {
    fn truth(&self) -> String {
        let key = self.instead.split(" =").next().unwrap_or_default();
        let line = |line: &str| match !key.is_empty() && line.starts_with(key) {
            true => self.instead.to_owned(),
            false => line.to_owned(),
        };
        SCENE.lines().map(line).collect::<Vec<_>>().join("\n") + "\n"
    }

    /// The table, and what the instruments added, in JSON.
    fn table(&self, seed: u64) -> wavecascade::Result<(String, String)> {
        let mut simulation = SceneSource::new(None, self.truth()).setup()?.simulation;
        simulation.end_time = EndTime::At(END);
        simulation.samples = SAMPLES;
        let run = simulation.run(&Silent)?;
        let record = |body: usize| run.velocity.column(body).to_vec();
        let bodies = self.bodies;
        let records: Vec<Vec<f64>> = bodies.iter().map(|body| record(*body)).collect();
        let squares: f64 = records.iter().flatten().map(|v| v * v).sum();
        let sigma = self.noise * (squares / (SAMPLES * bodies.len()) as f64).sqrt();
        let mut gains = Vec::new();
        let mut normal = Normal(seed);
        let fresh = (1.0 - self.correlation * self.correlation).sqrt();
        let mut noisy = Vec::new();
        for record in records {
            let gain = 1.0 + self.gain_error * normal.next();
            gains.push(gain);
            let mut last = normal.next();
            let mut noise = || {
                last = self.correlation * last + fresh * normal.next();
                sigma * last
            };
            noisy.push(
                record
                    .iter()
                    .map(|v| gain * v + noise())
                    .collect::<Vec<f64>>(),
            );
        }
        let names: Vec<String> = bodies
            .iter()
            .map(|body| format!("body {body} [m/s]"))
            .collect();
        let mut text = format!("time [s],{}\n", names.join(","));
        for i in 0..SAMPLES {
            let _ = write!(
                text,
                "{:.6e}",
                i as f64 * END / (SAMPLES - 1) as f64 + self.late
            );
            for (site, record) in noisy.iter().enumerate() {
                match self.missing && (i + 37 * site) % 90 < 5 {
                    true => text.push_str(",nan"),
                    false => {
                        let _ = write!(text, ",{:.5}", record[i]);
                    }
                }
            }
            text.push('\n');
        }
        let added = serde_json::json!({
            "bodies": bodies,
            "noise": sigma,
            "gains": gains,
            "time_shift": self.late,
            "wrong": self.wrong,
        });
        Ok((text, format!("{added:#}\n")))
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(
        std::env::args()
            .nth(1)
            .ok_or("expected the folder to write to")?,
    );
    std::fs::create_dir_all(&folder)?;
    for (seed, measurement) in (1..).zip(&ALL) {
        let file = |ending: &str| folder.join(format!("{}{ending}", measurement.name));
        let (table, added) = measurement.table(seed)?;
        std::fs::write(file(".csv"), table)?;
        std::fs::write(file(".truth.json"), added)?;
        std::fs::write(file(".truth.toml"), measurement.truth())?;
    }
    Ok(())
}
