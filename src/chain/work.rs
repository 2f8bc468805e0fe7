//! The work of a run, estimated before it begins.

use super::lattice::refuse;
use super::simulation::{Accuracy, EndTime, Simulation};
use super::stepping::{self, Extreme};
use crate::error::Result;

/// Steps within the time in which the stiffest contact stops the lightest site: 5 to 40 were found
/// at tolerances of 1e-6 to 1e-12.
const STEPS_A_CONTACT: f64 = 20.0;

/// The rate of damping times the longest stable step of explicit schemes of high order.
const STABLE: f64 = 6.0;

/// Steps beyond which a run is refused whose damping, not whose motion, determines them.
const MOST_DAMPED: f64 = 1e7;

/// Steps beyond which any run is refused.
const MOST: f64 = 1e11;

/// Estimated work of a run.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Work {
    /// Steps of one integration, to a factor of a few; to the latest time at which a front is waited
    /// for, where the run ends with its arrival.
    pub steps: f64,
    /// What determines their length: `motion`, `step`, or the loss `dashpot`, `tangent` or `drag`.
    pub limit: &'static str,
}

impl Simulation {
    /// The work of a run.
    pub fn work(&self) -> Work {
        let time = match self.end_time {
            EndTime::At(time) => time,
            EndTime::Arrival => self.latest_arrival(self.velocity_scale(0.0)),
        };
        if let Accuracy::Step(step) = self.accuracy {
            return Work {
                steps: time / step,
                limit: "step",
            };
        }
        let (limit, rate) = self.damping_rate(time);
        let contact =
            stepping::contact_time(&self.chain, self.velocity_scale(time), Extreme::Fastest);
        let [moved, damped] = [STEPS_A_CONTACT / contact, rate / STABLE].map(|n| n * time);
        match damped > moved {
            true => Work {
                steps: damped,
                limit,
            },
            false => Work {
                steps: moved,
                limit: "motion",
            },
        }
    }

    /// The loss that relaxes velocities fastest, and its rate: a dashpot between two sites of mass m
    /// relaxes neighbours in opposite motion at `4 dashpot / m`, and a contact of stiffness K that damps
    /// by its tangent as a dashpot of `tangent K`.
    fn damping_rate(&self, time: f64) -> (&'static str, f64) {
        let chain = &self.chain;
        let lightest = chain.mass.iter().copied().fold(f64::INFINITY, f64::min);
        let losses = chain.losses;
        let speed = self.velocity_scale(time);
        let compressed = speed * stepping::contact_time(chain, speed, Extreme::Fastest);
        let stiffest = (0..chain.n_contacts())
            .map(|j| {
                let overlap = chain.static_overlap(j);
                chain
                    .law
                    .stiffness(chain.coefficient[j], overlap, compressed)
                    .abs()
            })
            .fold(0.0, f64::max);
        let rates = [
            ("dashpot", 4.0 * losses.dashpot / lightest),
            ("tangent", 4.0 * losses.tangent * stiffest / lightest),
            ("drag", losses.drag / lightest),
        ];
        let fastest =
            |a: (&'static str, f64), b: (&'static str, f64)| if b.1 > a.1 { b } else { a };
        rates.into_iter().fold(rates[0], fastest)
    }

    /// Refuses a run that would not end in any time worth waiting for.
    pub(super) fn check_work(&self) -> Result<()> {
        let Work { steps, limit } = self.work();
        let is_damped = !matches!(limit, "motion" | "step");
        let most = if is_damped { MOST_DAMPED } else { MOST };
        if steps.is_nan() || steps <= most {
            return Ok(());
        }
        let until = match self.end_time {
            EndTime::At(time) => format!("to the end time {time}"),
            EndTime::Arrival => "while the arrival of a front is waited for".to_owned(),
        };
        let option = if limit == "motion" { "end-time" } else { limit };
        let losses = self.chain.losses;
        let value = match limit {
            "dashpot" => format!("{}: ", losses.dashpot),
            "tangent" => format!("{}: ", losses.tangent),
            "drag" => format!("{}: ", losses.drag),
            _ => String::new(),
        };
        let expected = match is_damped {
            true => format!(
                "damping that a run of {most:e} steps can follow: less of it, heavier sites or an \
                 earlier end time"
            ),
            false => format!("a run of at most {most:e} steps"),
        };
        Err(refuse(
            option,
            &expected,
            format!("{value}about {steps:.1e} steps {until}"),
        ))
    }
}
