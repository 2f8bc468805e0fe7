//! Chains in which a pulse is followed, and their saved results.

use std::collections::HashSet;
use std::io::Write;

use serde::{Deserialize, Serialize};

use super::chains::{Pattern, homogeneous};
use super::high_band::high_shares;
use super::pulse::{Pulses, Sense, contacts, pulses};
use crate::Result;
use crate::chain::Simulation;
use crate::observer::{CancelOnly, Observer};
use crate::system::journal::{Journal, Outcome, StoredRequest};

/// The request that a directory of saved members belongs to. Members are named by what they run, so that further ones
/// can be added.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoredChains {
    version: String,
    /// As text.
    scenes: Vec<String>,
    /// The abscissa.
    against: String,
}

impl StoredChains {
    pub(super) fn new(scenes: Vec<String>, against: &str) -> StoredChains {
        StoredChains {
            version: env!("CARGO_PKG_VERSION").into(),
            scenes,
            against: against.to_owned(),
        }
    }
}

impl StoredRequest for StoredChains {
    const FILE: &'static str = "attenuation.json";
    const WORD: &'static str = "attenuation curve";
}

/// The saved result of a member.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PulseMeasures {
    pub(super) pulses: Pulses,
    /// Sites of the simulated chain.
    pub(super) sites: usize,
    /// Fraction of the energy passed above the band edge, from contact 0 on.
    pub(super) high: Option<Vec<f64>>,
}

/// The results known so far, by the hash of what was run.
pub(super) type Known = Journal<String, PulseMeasures>;

/// One chain to follow a pulse in.
#[derive(Debug, Clone)]
pub(super) struct FollowedChain {
    pub(super) name: String,
    key: String,
    /// Chains of growing length; the first that is long enough is used.
    pub(super) attempts: Vec<Simulation>,
    pub(super) sense: Sense,
    /// The last contact whose pulse is needed.
    pub(super) wanted: usize,
    /// Lower edge of the high band, if its share is requested.
    edge: Option<f64>,
}

/// A chain and its homogeneous reference.
#[derive(Debug, Clone)]
pub(super) struct Pair {
    pub(super) own: FollowedChain,
    pub(super) reference: FollowedChain,
}

impl Pair {
    /// # Errors
    /// As [`contacts`].
    pub(super) fn new(
        name: &str,
        attempts: Vec<Simulation>,
        pattern: &Pattern,
        (sense, wanted): (Sense, usize),
        edge: Option<f64>,
    ) -> Result<Pair> {
        for simulation in &attempts {
            contacts(simulation, sense)?;
        }
        let chain = |name: String, attempts: Vec<Simulation>| {
            let mut hasher = blake3::Hasher::new();
            // A hasher takes all that is written.
            let _ = write!(hasher, "{:?}", (&attempts, sense, wanted, edge));
            FollowedChain {
                name,
                key: hasher.finalize().to_hex().to_string(),
                attempts,
                sense,
                wanted,
                edge,
            }
        };
        let references = attempts.iter().map(|s| homogeneous(s, pattern)).collect();
        Ok(Pair {
            reference: chain(format!("reference of {name}"), references),
            own: chain(name.to_owned(), attempts),
        })
    }
}

/// What became of a chain and of its reference, which are run unless that is known.
///
/// # Errors
/// As [`Journal::member`].
pub(super) type See<'s> = &'s (dyn Fn(&Pair) -> Result<[Outcome<PulseMeasures>; 2]> + Sync);

/// The chains of pairs, each once.
fn members<'a>(pairs: impl Iterator<Item = &'a Pair>) -> Vec<&'a FollowedChain> {
    let mut seen = HashSet::new();
    let all = pairs.flat_map(|pair| [&pair.own, &pair.reference]);
    all.filter(|member| seen.insert(&member.key)).collect()
}

/// Curves, names and reasons of the chains that failed, and how many were simulated in this run.
type Curved<C> = (Vec<C>, Vec<(String, String)>, usize);

/// Follows the pulses of chains and their references in parallel, then makes curves, which may need further ones.
///
/// # Errors
/// As [`Journal::each`], and those of `curves`.
pub(super) fn follow<'a, C>(
    pairs: impl Iterator<Item = &'a Pair>,
    known: &Known,
    observer: &dyn Observer,
    curves: impl FnOnce(See) -> Result<Vec<C>>,
) -> Result<Curved<C>> {
    let members = members(pairs);
    known.each("pulses", &members, observer, |member, observer| {
        member.outcome(known, observer).map(drop)
    })?;
    let quiet = CancelOnly(observer);
    let see = |pair: &Pair| {
        let reference = &pair.reference;
        Ok([
            pair.own.outcome(known, &quiet)?,
            reference.outcome(known, &quiet)?,
        ])
    };
    let curves = curves(&see).map_err(|error| known.paused(error, members.len()))?;
    known.sync()?;
    let failed = members.iter();
    let failed = failed.filter_map(|member| match known.known(&member.key)? {
        Outcome::Failed(reason) => Some((member.name.clone(), reason)),
        Outcome::Done(_) => None,
    });
    Ok((curves, failed.collect(), known.computed()))
}

impl FollowedChain {
    fn outcome(&self, known: &Known, observer: &dyn Observer) -> Result<Outcome<PulseMeasures>> {
        known.member(&self.key, || self.see(observer))
    }

    fn see(&self, observer: &dyn Observer) -> Result<PulseMeasures> {
        let mut longer = self.attempts[1..].iter();
        let mut simulation = &self.attempts[0];
        let mut found = pulses(simulation, self.sense, observer)?;
        while found.pulses.last().map(|pulse| pulse.contact) < Some(self.wanted) {
            let Some(next) = longer.next() else { break };
            simulation = next;
            found = pulses(simulation, self.sense, observer)?;
        }
        found.pulses.retain(|pulse| pulse.contact <= self.wanted);
        let shares = |edge| high_shares(simulation, found.end_time, edge, observer);
        let mut high = self.edge.map(shares).transpose()?;
        if let Some(high) = &mut high {
            high.truncate(found.pulses.len());
        }
        Ok(PulseMeasures {
            high,
            pulses: found,
            sites: simulation.chain.n_sites(),
        })
    }
}
