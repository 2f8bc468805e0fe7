//! Attenuation against length.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::chains::{ContactKind, SceneTemplate};
use super::curve::{
    Attenuation, AttenuationCurve, CurveRow, Stop, StopCause, compared, reach, rows_of,
};
use super::fit::{Criterion, fit};
use super::members::{FollowedChain, OutcomeStore, PulseMeasures};
use super::plan::{Plan, PlannedLength};
use super::pulse::{Sense, refuse};
use crate::Result;
use crate::chain::scene::SceneSource;
use crate::observer::Observer;
use crate::system::journal::{Outcome, StoredRequest};

/// Every length up to this one is simulated in the wall sense.
const EVERY: usize = 40;

/// A named chain.
#[derive(Debug, Clone)]
pub struct Named {
    pub name: String,
    pub scene: SceneSource,
}

/// A request for attenuation against length.
#[derive(Debug, Clone)]
pub struct AttenuationRequest {
    pub chains: Vec<Named>,
    /// Bodies behind the striker.
    pub length: usize,
    pub senses: Vec<Sense>,
    /// Lengths in the wall sense; `None`: all up to 40, then spaced geometrically by 1.1.
    pub lengths: Option<Vec<usize>>,
    /// The kind of contacts that are fitted and compared with the target; those of kind
    /// [`ContactKind::Other`] always are.
    pub kind: ContactKind,
    pub criterion: Criterion,
    /// Target of the peak force relative to the homogeneous chain; the length that reaches it is
    /// computed.
    pub target: Option<f64>,
    /// Whether the share of the high band is computed.
    pub high_band: bool,
    /// Upper edge of the low band; `None`: the frequency below which 90 % of the spectral energy of
    /// the force in the homogeneous chain's first contact lies.
    pub band_edge_frequency: Option<f64>,
}

impl Default for AttenuationRequest {
    fn default() -> Self {
        AttenuationRequest {
            chains: Vec::new(),
            length: 40,
            senses: vec![Sense::Chain, Sense::Wall],
            lengths: None,
            kind: ContactKind::Soft,
            criterion: Criterion::default(),
            target: None,
            high_band: true,
            band_edge_frequency: None,
        }
    }
}

/// The request that a directory of saved members belongs to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredLength {
    version: String,
    /// Scenes as text.
    scenes: Vec<String>,
    length: usize,
    lengths: Vec<usize>,
    senses: Vec<Sense>,
    high_band: bool,
    band_edge_frequency: Option<f64>,
}

impl StoredRequest for StoredLength {
    const FILE: &'static str = "attenuation-request.json";
    const WORD: &'static str = "attenuation curve";

    fn difference(&self, asked: &StoredLength) -> Option<String> {
        if self == asked {
            return None;
        }
        Some(if self.version != asked.version {
            let (found, asked) = (&self.version, &asked.version);
            format!("it was made by version {found}, this is {asked}")
        } else if self.scenes != asked.scenes {
            "it belongs to other chains".into()
        } else {
            "its lengths, senses or bands differ".into()
        })
    }
}

impl AttenuationRequest {
    /// # Errors
    /// [`crate::Error::Request`] for missing or invalid values.
    fn check(&self) -> Result<()> {
        let no =
            |option, expected: &str, found: String| Err(refuse(option, expected.into(), found));
        if self.chains.is_empty() {
            return no("chains", "at least one chain", "none".into());
        }
        if !(2..=100_000).contains(&self.length) {
            return no("bodies", "2 to 100000", self.length.to_string());
        }
        if self.senses.is_empty() {
            return no("sense", "chain, wall or both", "none".into());
        }
        if let Some(target) = self.target.filter(|t| !(*t > 0.0 && *t < 1.0)) {
            return no("target", "a number between 0 and 1", target.to_string());
        }
        let lengths = self.lengths.iter().flatten();
        if let Some(n) = lengths.clone().find(|n| !(1..=100_000).contains(*n)) {
            return no("lengths", "1 to 100000 bodies each", n.to_string());
        }
        if self.lengths.as_ref().is_some_and(|l| l.is_empty()) {
            return no("lengths", "at least one length", "none".into());
        }
        if let Some(edge) = self.band_edge_frequency
            && !(edge.is_finite() && edge >= 0.0)
        {
            return no("band-edge-frequency", "0 or more", edge.to_string());
        }
        Ok(())
    }

    fn wall_lengths(&self) -> Vec<usize> {
        let mut lengths = self.lengths.clone().unwrap_or_else(|| {
            let mut lengths: Vec<usize> = (1..=self.length.min(EVERY)).collect();
            let mut n = EVERY as f64;
            while n * 1.1 < self.length as f64 {
                n *= 1.1;
                lengths.push(n.round() as usize);
            }
            lengths.push(self.length);
            lengths
        });
        lengths.sort_unstable();
        lengths.dedup();
        lengths
    }

    /// Follows the pulses of all chains and of their homogeneous references, and fits the curves.
    ///
    /// With a directory, each chain's result is saved as soon as it is computed, and saved results
    /// are not computed again. The results depend neither on that nor on the number of threads.
    ///
    /// # Errors
    /// [`crate::Error::Request`] and [`crate::Error::Scene`] before any work;
    /// [`crate::Error::OutputInUse`] for a directory in use for something else;
    /// [`crate::Error::Paused`] or [`crate::Error::Cancelled`] when the observer cancels;
    /// [`crate::Error::Write`].
    pub fn run(&self, directory: Option<&Path>, observer: &dyn Observer) -> Result<Attenuation> {
        self.check()?;
        let makes: Result<Vec<SceneTemplate>> = self
            .chains
            .iter()
            .map(|c| SceneTemplate::new(c.scene.clone()))
            .collect();
        let makes = makes?;
        let lengths = self.wall_lengths();
        let scenes: Result<Vec<String>> = makes.iter().map(SceneTemplate::text).collect();
        let asked = StoredLength {
            version: env!("CARGO_PKG_VERSION").into(),
            scenes: scenes?,
            length: self.length,
            lengths: lengths.clone(),
            senses: self.senses.clone(),
            high_band: self.high_band,
            band_edge_frequency: self.band_edge_frequency,
        };
        let mut plan = Plan::default();
        for (chain, make) in makes.iter().enumerate() {
            for &sense in &self.senses {
                let planned = self.plan(chain, make, sense, &lengths, &mut plan)?;
                plan.curves.push(planned);
            }
        }
        let known = OutcomeStore::open(directory, &asked)?;
        let outcomes = known.members(&plan.members, observer)?;
        let computed = known.sync()?;
        let failed = plan.members.iter().zip(&outcomes);
        let failed = failed.filter_map(|(member, outcome)| match outcome {
            Outcome::Failed(reason) => Some((member.key.clone(), reason.clone())),
            Outcome::Done(_) => None,
        });
        let curves = plan.curves.iter();
        Ok(Attenuation {
            length: self.length,
            kind: self.kind,
            target: self.target,
            curves: curves
                .map(|planned| self.curve(planned, &plan.members, &outcomes))
                .collect(),
            failed: failed.collect(),
            computed,
        })
    }

    fn curve(
        &self,
        planned: &PlannedLength,
        members: &[FollowedChain],
        outcomes: &[Outcome<PulseMeasures>],
    ) -> AttenuationCurve {
        let mut rows: Vec<CurveRow> = Vec::new();
        let mut stop = None;
        for pair in &planned.pairs {
            let member = &members[pair.own];
            let Outcome::Done(seen) = &outcomes[pair.own] else {
                let (bodies, cause) = (member.wanted, StopCause::Failed);
                stop = stop.or(Some(Stop { bodies, cause }));
                continue;
            };
            let reference = match &outcomes[pair.reference] {
                Outcome::Done(reference) => Some(reference),
                Outcome::Failed(_) => None,
            };
            let before = rows.len();
            rows.extend(rows_of(member, seen, reference, &planned.pattern));
            let last = rows[before..].last().map(|row| row.bodies);
            if last < Some(member.wanted) {
                let cause = match seen.pulses.arrived {
                    true => StopCause::Reflection,
                    false => StopCause::Faded,
                };
                let bodies = match planned.sense {
                    Sense::Chain => last.map_or(0, |n| n + 1),
                    Sense::Wall => member.wanted,
                };
                stop = stop.or(Some(Stop { bodies, cause }));
            }
        }
        let (n, y): (Vec<f64>, Vec<f64>) = compared(self.kind, &rows).into_iter().unzip();
        let fits = fit(&n, &y, self.criterion);
        let reach = self
            .target
            .map(|target| reach(target, &n, &y, fits.as_ref()));
        AttenuationCurve {
            name: self.chains[planned.chain].name.clone(),
            sense: planned.sense,
            units: planned.units,
            stiffness_ratio: planned.pattern.stiffness_ratio(),
            band_edge_frequency: planned.edge,
            rows,
            stop,
            fits,
            reach,
        }
    }
}
