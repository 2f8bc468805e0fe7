//! The few numbers by which fields are compared.

use serde::{Deserialize, Serialize};

use crate::analyze::Analysis;
use crate::moved::{Movement, Verdict};
use crate::sheet::name_of;

/// Headline numbers of an analysis; those that are not known are `None`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Headlines {
    pub times: usize,
    pub sites: usize,
    /// What moved in frequency along x.
    pub frequency: Option<MovedShares>,
    /// Energy at the last sites compared over that at the first.
    pub energy_ratio: Option<f64>,
    /// First and last of the sites compared.
    pub from: Option<usize>,
    pub to: Option<usize>,
    /// What moved in wavenumber in time.
    pub wavenumber: Option<MovedShares>,
    /// Shares of the energy by direction, where they can be told.
    pub toward_plus_x: Option<f64>,
    pub toward_minus_x: Option<f64>,
    pub warnings: usize,
}

/// The shares of the energy that moved up and down, and where.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MovedShares {
    pub verdict: Verdict,
    /// Whether energy itself grew where shares did; `false` of a selective loss.
    pub transfer: Option<bool>,
    /// Why it cannot be told.
    pub reason: Option<String>,
    pub up: Option<f64>,
    pub up_at: Option<f64>,
    pub down: Option<f64>,
    pub down_at: Option<f64>,
    /// Of `up_at` and `down_at`.
    pub unit: String,
}

impl Headlines {
    /// The headlines of an analysis; computes nothing new.
    pub fn of(analysis: &Analysis) -> Headlines {
        let axes = &analysis.axes;
        let units = axes.units();
        let answer = analysis.answer.as_ref();
        let frequency = answer.map(|answer| &answer.frequency);
        let told = analysis.direction_of_waves();
        Headlines {
            times: axes.n_times,
            sites: axes.n_sites,
            frequency: frequency.map(|of| MovedShares::of(of, units.frequency.clone())),
            energy_ratio: frequency.and_then(|of| defined(of.energy_ratio)),
            from: frequency.and_then(|of| Some(of.from?.rows[0])),
            to: frequency.and_then(|of| Some(of.to?.rows[1])),
            wavenumber: answer
                .map(|answer| MovedShares::of(&answer.wavenumber, units.wavenumber.clone())),
            toward_plus_x: told.and_then(|direction| defined(direction.toward_plus_x)),
            toward_minus_x: told.and_then(|direction| defined(direction.toward_minus_x)),
            warnings: analysis.warnings.len(),
        }
    }
}

impl MovedShares {
    /// The verdict in a word or two.
    pub fn word(&self) -> String {
        match (self.verdict, self.transfer) {
            (Verdict::Up | Verdict::Down, Some(false)) => "selective loss".into(),
            (verdict, _) => name_of(&verdict),
        }
    }

    fn of(of: &Movement, unit: String) -> MovedShares {
        MovedShares {
            verdict: of.verdict,
            transfer: of.transfer,
            reason: of.reason.map(|reason| reason.message()),
            up: defined(of.up.share),
            up_at: defined(of.up.at),
            down: defined(of.down.share),
            down_at: defined(of.down.at),
            unit,
        }
    }
}

fn defined(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}
