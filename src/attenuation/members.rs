//! Computing members and saving their results.

use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::high_band::high_shares;
use super::pulse::{Pulses, Sense, pulses};
use crate::chain::Simulation;
use crate::observer::{CancelOnly, Observer};
use crate::system::journal::{Journal, Outcome, Outcomes, StoredRequest};
use crate::{Error, Result};

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

/// One chain to follow a pulse in.
#[derive(Debug, Clone)]
pub(super) struct FollowedChain {
    /// Its name.
    pub(super) key: String,
    /// Chains of growing length; the first that is long enough is used.
    pub(super) attempts: Vec<Simulation>,
    pub(super) sense: Sense,
    /// The last contact whose pulse is needed.
    pub(super) wanted: usize,
    /// Lower edge of the high band, if its share is requested.
    pub(super) edge: Option<f64>,
}

/// The outcomes known so far, saved in a directory if there is one.
#[derive(Debug)]
pub(super) struct OutcomeStore {
    journal: Option<Journal>,
    outcomes: Mutex<Outcomes<String, PulseMeasures>>,
    /// Number of members computed in this run.
    computed: Mutex<usize>,
}

impl OutcomeStore {
    /// # Errors
    /// As [`Journal::open`].
    pub(super) fn open<A: StoredRequest>(
        directory: Option<&Path>,
        asked: &A,
    ) -> Result<OutcomeStore> {
        let (journal, outcomes) = match directory {
            None => (None, Outcomes::new()),
            Some(directory) => {
                let (journal, outcomes) = Journal::open(directory, asked, &|_: &String| Ok(()))?;
                (Some(journal), outcomes)
            }
        };
        Ok(OutcomeStore {
            journal,
            outcomes: Mutex::new(outcomes),
            computed: Mutex::new(0),
        })
    }

    /// The outcome of a member, computed if it is not known.
    ///
    /// # Errors
    /// [`Error::Cancelled`], [`Error::Memory`], [`Error::Write`]; any other error becomes the
    /// outcome.
    pub(super) fn member(
        &self,
        member: &FollowedChain,
        observer: &dyn Observer,
    ) -> Result<Outcome<PulseMeasures>> {
        if let Some(known) = self.lock().get(&member.key) {
            return Ok(known.clone());
        }
        let outcome = match member.see(observer) {
            Ok(seen) => Outcome::Done(seen),
            Err(error @ (Error::Cancelled | Error::Memory { .. })) => return Err(error),
            Err(error) => Outcome::Failed(error.to_string()),
        };
        if let Some(journal) = &self.journal {
            journal.add(&member.key, &outcome)?;
        }
        *self.computed.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        self.lock().insert(member.key.clone(), outcome.clone());
        Ok(outcome)
    }

    /// The outcomes of members, in their order, computed in parallel on the current pool.
    ///
    /// # Errors
    /// As [`OutcomeStore::member`]; [`Error::Paused`] for [`Error::Cancelled`] where a directory saves the
    /// outcomes.
    pub(super) fn members(
        &self,
        members: &[FollowedChain],
        observer: &dyn Observer,
    ) -> Result<Vec<Outcome<PulseMeasures>>> {
        observer.stage("pulses", members.len() as u64);
        let outcomes: Result<Vec<Outcome<PulseMeasures>>> = members
            .par_iter()
            .map(|member| {
                let outcome = self.member(member, &CancelOnly(observer));
                observer.advance(1);
                outcome
            })
            .collect();
        outcomes.map_err(|error| self.paused(error, members))
    }

    /// Turns [`Error::Cancelled`] into [`Error::Paused`] where the outcomes are saved.
    pub(super) fn paused(&self, error: Error, members: &[FollowedChain]) -> Error {
        match (error, &self.journal) {
            (Error::Cancelled, Some(_)) => {
                let known = self.lock();
                Error::Paused {
                    known: members
                        .iter()
                        .filter(|m| known.contains_key(&m.key))
                        .count(),
                    members: members.len(),
                }
            }
            (error, _) => error,
        }
    }

    /// Flushes the outcomes to disk; returns the number of members computed.
    pub(super) fn sync(&self) -> Result<usize> {
        if let Some(journal) = &self.journal {
            journal.sync()?;
        }
        Ok(*self.computed.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn lock(&self) -> MutexGuard<'_, Outcomes<String, PulseMeasures>> {
        self.outcomes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl FollowedChain {
    fn see(&self, observer: &dyn Observer) -> Result<PulseMeasures> {
        let mut seen = None;
        for simulation in &self.attempts {
            let found = pulses(simulation, self.sense, observer)?;
            let reached = found.pulses.last().map(|pulse| pulse.contact);
            seen = Some((simulation, found));
            if reached >= Some(self.wanted) {
                break;
            }
        }
        let Some((simulation, mut found)) = seen else {
            return Err(Error::Request {
                option: "length",
                expected: "a chain".into(),
                found: "none".into(),
            });
        };
        found.pulses.retain(|pulse| pulse.contact <= self.wanted);
        let high = match self.edge {
            None => None,
            Some(edge) => Some(high_shares(simulation, found.end_time, edge, observer)?),
        };
        Ok(PulseMeasures {
            high: high.map(|shares| shares[..found.pulses.len()].to_vec()),
            pulses: found,
            sites: simulation.chain.n_sites(),
        })
    }
}
