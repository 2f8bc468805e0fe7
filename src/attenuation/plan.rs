//! The chains simulated for attenuation against length, each once, with their homogeneous
//! references.

use super::chains::{Pattern, SceneTemplate, homogeneous};
use super::high_band::default_edge;
use super::length::AttenuationRequest;
use super::members::FollowedChain;
use super::pulse::{Sense, contacts};
use crate::Result;
use crate::chain::Simulation;
use crate::chain::scene::{Setup, Units};

/// Initial margin of bodies behind the last requested contact, to which a quarter of the length is
/// added. It makes the contact's pulse complete before the front reaches the wall, and is doubled
/// as needed, at most [`DOUBLINGS`] times.
const MARGIN: usize = 20;
const DOUBLINGS: u32 = 4;

/// The members to compute, each chain once.
#[derive(Default)]
pub(super) struct Plan {
    pub(super) members: Vec<FollowedChain>,
    pub(super) curves: Vec<PlannedLength>,
    edges: Vec<(Simulation, f64)>,
}

pub(super) struct PlannedLength {
    pub(super) chain: usize,
    pub(super) sense: Sense,
    pub(super) pairs: Vec<Pair>,
    pub(super) edge: Option<f64>,
    pub(super) units: Units,
    pub(super) pattern: Pattern,
}

/// Indices of a member and of its homogeneous reference.
pub(super) struct Pair {
    pub(super) own: usize,
    pub(super) reference: usize,
}

impl Plan {
    /// Adds a member unless the same one is there already, and returns its index.
    fn add(&mut self, member: FollowedChain) -> usize {
        let same = |other: &FollowedChain| {
            other.sense == member.sense
                && other.wanted == member.wanted
                && other.edge == member.edge
                && other.attempts == member.attempts
        };
        if let Some(at) = self.members.iter().position(same) {
            return at;
        }
        self.members.push(member);
        self.members.len() - 1
    }

    fn edge(&mut self, reference: Simulation) -> Result<f64> {
        if let Some((_, edge)) = self.edges.iter().find(|(known, _)| *known == reference) {
            return Ok(*edge);
        }
        let edge = default_edge(&reference)?;
        self.edges.push((reference, edge));
        Ok(edge)
    }
}

impl AttenuationRequest {
    /// Plans the members of one chain in one sense, and of its homogeneous reference.
    pub(super) fn plan(
        &self,
        chain: usize,
        make: &SceneTemplate,
        sense: Sense,
        lengths: &[usize],
        plan: &mut Plan,
    ) -> Result<PlannedLength> {
        let groups: Vec<(usize, Vec<Setup>)> = match sense {
            Sense::Chain if make.extends => {
                let margins = (0..=DOUBLINGS).map(|k| (MARGIN + self.length / 4) << k);
                let chains: Result<Vec<Setup>> = margins
                    .map(|margin| make.with_bodies(self.length + margin))
                    .collect();
                vec![(self.length, chains?)]
            }
            Sense::Chain => vec![(self.length, vec![make.setup()?])],
            Sense::Wall if make.extends => {
                let chains = lengths.iter().map(|&n| Ok((n, vec![make.with_bodies(n)?])));
                chains.collect::<Result<_>>()?
            }
            Sense::Wall => {
                let setup = make.setup()?;
                vec![(setup.simulation.chain.n_sites() - 1, vec![setup])]
            }
        };
        let pattern = make.pattern()?;
        let units = groups[0].1[0].units;
        for setup in groups.iter().flat_map(|(_, setups)| setups) {
            contacts(&setup.simulation, sense)?;
        }
        let edge = match (sense, self.high_band, self.band_edge_frequency) {
            (Sense::Wall, _, _) | (_, false, _) => None,
            (Sense::Chain, true, Some(edge)) => Some(edge),
            (Sense::Chain, true, None) => {
                let reference = homogeneous(&groups[0].1[0].simulation, &pattern);
                Some(plan.edge(reference)?)
            }
        };
        let mut pairs = Vec::new();
        for (wanted, setups) in groups {
            let attempts: Vec<Simulation> = setups.into_iter().map(|s| s.simulation).collect();
            let references = attempts.iter().map(|s| homogeneous(s, &pattern)).collect();
            let mut add = |make: &str, attempts: Vec<Simulation>| {
                plan.add(FollowedChain {
                    key: format!("{make} {}, {}, {wanted} bodies", chain + 1, sense.name()),
                    attempts,
                    sense,
                    wanted,
                    edge,
                })
            };
            pairs.push(Pair {
                own: add("chain", attempts),
                reference: add("homogeneous chain of", references),
            });
        }
        Ok(PlannedLength {
            chain,
            sense,
            pairs,
            edge,
            units,
            pattern,
        })
    }
}
