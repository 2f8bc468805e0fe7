//! Records of chains that are known, with noise.

use ndarray::Array2;
use wavecascade::chain::scene::SceneSource;
use wavecascade::chain::{EndTime, Run};
use wavecascade::field::{Axis, Quantity};
use wavecascade::fit::{FitRequest, Fitted};
use wavecascade::observer::Silent;
use wavecascade::{Error, Field};

use test_support::measured::Normal;

/// What is measured of a run.
#[derive(Clone)]
pub struct Measurement {
    pub bodies: Vec<usize>,
    pub samples: usize,
    pub end: f64,
    pub quantity: Quantity,
    /// Standard deviation of the noise, over the root mean square of the records.
    pub noise: f64,
    /// Correlation of neighbouring samples of the noise.
    pub correlation: f64,
    pub seed: u64,
}

impl Measurement {
    pub fn of(bodies: &[usize], samples: usize, end: f64) -> Measurement {
        Measurement {
            bodies: bodies.to_vec(),
            samples,
            end,
            quantity: Quantity::Velocity,
            noise: 0.02,
            correlation: 0.0,
            seed: 1,
        }
    }

    pub fn run(&self, scene: &str) -> Run {
        let mut simulation = SceneSource::new(None, scene).setup().unwrap().simulation;
        simulation.end_time = EndTime::At(self.end);
        simulation.samples = self.samples;
        simulation.run(&Silent).unwrap()
    }

    /// The records of a run, one column a body.
    pub fn records(&self, run: &Run) -> Array2<f64> {
        let of = |values: &Array2<f64>| {
            Array2::from_shape_fn((self.samples, self.bodies.len()), |(i, j)| {
                values[[i, self.bodies[j]]]
            })
        };
        match self.quantity {
            Quantity::Displacement => of(run.displacement.as_ref().unwrap()),
            Quantity::Force => of(run.force.as_ref().unwrap()),
            _ => of(&run.velocity),
        }
    }

    pub fn with_noise(&self, records: &Array2<f64>) -> Array2<f64> {
        let size = (records.iter().map(|v| v * v).sum::<f64>() / records.len() as f64).sqrt();
        let mut normal = Normal(self.seed.wrapping_mul(0x1234_5678_9abc_def1));
        let mut noisy = records.clone();
        let fresh = (1.0 - self.correlation * self.correlation).sqrt();
        for mut column in noisy.columns_mut() {
            let mut last = normal.draw();
            for value in &mut column {
                *value += self.noise * size * last;
                last = self.correlation * last + fresh * normal.draw();
            }
        }
        noisy
    }

    pub fn field(&self, values: Array2<f64>) -> Field {
        let mut field = Field::from_array(values);
        field.quantity = self.quantity;
        field.time = Axis {
            origin: 0.0,
            step: self.end / (self.samples - 1) as f64,
            unit: None,
        };
        field
    }

    pub fn measured(&self, scene: &str) -> Field {
        self.field(self.with_noise(&self.records(&self.run(scene))))
    }

    pub fn request(&self, free: &[&str]) -> FitRequest {
        FitRequest {
            free: free.iter().map(|text| (*text).to_owned()).collect(),
            bodies: Some(self.bodies.clone()),
            starts: 1,
            ..FitRequest::default()
        }
    }

    /// Fits a scene to what is measured of the truth.
    pub fn fit(&self, truth: &str, scene: &str, free: &[&str]) -> Result<Fitted, Error> {
        let scene = SceneSource::new(None, scene);
        self.request(free)
            .run(&self.measured(truth), &scene, &Silent)
    }
}
