//! Attenuation against length.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::chains::{ContactKind, Make, homogeneous};
use super::fit::{Criterion, Fits, Law, Length, fit};
use super::high_band::default_edge;
use super::members::{Known, Member, Seen};
use super::pulse::{Pulse, Sense, refuse};
use crate::Result;
use crate::analyze::Observer;
use crate::chain::Simulation;
use crate::chain::scene::{SceneSource, Setup, Units};
use crate::ledger::{Asked, Outcome};

/// Bodies behind the last contact that is asked for, at first, so that its pulse is whole before
/// the front reaches the wall; doubled as often as needed.
const MARGIN: usize = 20;
const DOUBLINGS: u32 = 4;

/// Up to this length every length has a chain of its own in the sense of the wall.
const EVERY: usize = 40;

/// A chain by its name.
#[derive(Debug, Clone)]
pub struct Named {
    pub name: String,
    pub scene: SceneSource,
}

/// What is asked of attenuation against length.
#[derive(Debug, Clone)]
pub struct AttenuationRequest {
    pub chains: Vec<Named>,
    /// Bodies behind the striker.
    pub length: usize,
    pub senses: Vec<Sense>,
    /// Lengths in the sense of the wall; `None`: all up to 40, from there on in equal ratios.
    pub lengths: Option<Vec<usize>>,
    /// The contacts that are fitted and compared with the target; those of the striker and of the
    /// wall with coefficients of their own always are.
    pub kind: ContactKind,
    pub criterion: Criterion,
    /// The attenuation whose length is asked for, relative to the homogeneous chain.
    pub target: Option<f64>,
    /// Whether the share of the high band is computed.
    pub high_band: bool,
    /// Upper edge of the low band; `None`: below it lie 90 % of the energy of the force in the
    /// first contact of the homogeneous chain.
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

/// What was found, curve by curve.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Attenuation {
    pub length: usize,
    pub kind: ContactKind,
    pub target: Option<f64>,
    pub curves: Vec<AttenuationCurve>,
    /// Members whose run failed, with the reason.
    pub failed: Vec<(String, String)>,
    /// How many chains were followed just now; the others were known.
    #[serde(skip)]
    pub computed: usize,
}

/// One chain in one sense.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AttenuationCurve {
    pub name: String,
    pub sense: Sense,
    pub units: Units,
    /// Largest over smallest coefficient between bodies.
    pub stiffness_ratio: Option<f64>,
    pub band_edge_frequency: Option<f64>,
    pub rows: Vec<Row>,
    /// The contact at which a reflection would have entered, where that is before the length asked
    /// for.
    pub stopped_at: Option<usize>,
    pub fits: Option<Fits>,
    pub reach: Option<Reach>,
}

/// A place on a curve.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Bodies before the contact, the striker not counted.
    pub bodies: usize,
    pub kind: ContactKind,
    pub pulse: Pulse,
    /// Share of the energy passed above the band edge.
    pub high_share: Option<f64>,
    /// Relative to the same contact of the homogeneous chain.
    pub relative_force: Option<f64>,
    pub relative_velocity: Option<f64>,
    pub relative_energy: Option<f64>,
}

/// The length that reaches the target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "found")]
pub enum Reach {
    /// From this number of bodies on the curve is at the target or below it.
    Within { bodies: usize },
    /// The curve does not end below it, but the chosen law reaches it here.
    Beyond { law: Law, length: Length },
    /// The chosen law settles above it.
    Never { law: Law, settles_at: f64 },
    /// The curve does not end below it and no law could be fitted.
    Unknown,
}

/// What a directory of kept members was made for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct AskedLength {
    version: String,
    /// Scenes as text.
    scenes: Vec<String>,
    length: usize,
    lengths: Vec<usize>,
    senses: Vec<Sense>,
    high_band: bool,
    band_edge_frequency: Option<f64>,
}

impl Asked for AskedLength {
    const FILE: &'static str = "attenuation-request.json";
    const WORD: &'static str = "attenuation curve";

    fn difference(&self, asked: &AskedLength) -> Option<String> {
        if self == asked {
            return None;
        }
        Some(if self.version != asked.version {
            let (found, asked) = (&self.version, &asked.version);
            format!("it was made by version {found}, this is {asked}")
        } else if self.scenes != asked.scenes {
            "it is of other chains".into()
        } else {
            "its lengths, senses or bands differ".into()
        })
    }
}

impl AttenuationRequest {
    /// # Errors
    /// [`crate::Error::Request`] for what is missing or cannot be.
    fn check(&self) -> Result<()> {
        let no =
            |option, expected: &str, found: String| Err(refuse(option, expected.into(), found));
        if self.chains.is_empty() {
            return no("chains", "at least one chain", "none".into());
        }
        if !(2..=100_000).contains(&self.length) {
            return no("length", "2 to 100000 bodies", self.length.to_string());
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

    /// Follows the pulses of all chains and of their homogeneous ones, and fits what was found.
    ///
    /// With a directory, each chain is kept in it as soon as it is known, and what is there is not
    /// computed again. The results depend neither on that nor on the number of threads.
    ///
    /// # Errors
    /// [`crate::Error::Request`] and [`crate::Error::Scene`] before any work; [`crate::Error::Occupied`] for a directory
    /// that holds something else; [`crate::Error::Paused`] or [`crate::Error::Cancelled`] when the observer asks
    /// to stop; [`crate::Error::Write`].
    pub fn run(&self, directory: Option<&Path>, observer: &dyn Observer) -> Result<Attenuation> {
        self.check()?;
        let makes: Result<Vec<Make>> = self
            .chains
            .iter()
            .map(|c| Make::new(c.scene.clone()))
            .collect();
        let makes = makes?;
        let lengths = self.wall_lengths();
        let scenes: Result<Vec<String>> = makes.iter().map(Make::text).collect();
        let asked = AskedLength {
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
        let known = Known::open(directory, &asked)?;
        let outcomes = known.members(&plan.members, observer)?;
        let computed = known.settle()?;
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

    /// The members of one chain in one sense, and of its homogeneous one.
    fn plan(
        &self,
        chain: usize,
        make: &Make,
        sense: Sense,
        lengths: &[usize],
        plan: &mut Plan,
    ) -> Result<Planned> {
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
        let (units, stiffness_ratio) = {
            let longest = &groups[groups.len() - 1].1[0];
            (longest.units, longest.description().stiffness_ratio)
        };
        let edge = match (sense, self.high_band, self.band_edge_frequency) {
            (Sense::Wall, _, _) | (_, false, _) => None,
            (Sense::Chain, true, Some(edge)) => Some(edge),
            (Sense::Chain, true, None) => {
                let reference = homogeneous(&groups[0].1[0].simulation);
                Some(plan.edge(reference)?)
            }
        };
        let mut pairs = Vec::new();
        for (wanted, setups) in groups {
            let attempts: Vec<Simulation> = setups.into_iter().map(|s| s.simulation).collect();
            let references = attempts.iter().map(homogeneous).collect();
            let mut add = |make: &str, attempts: Vec<Simulation>| {
                plan.add(Member {
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
        Ok(Planned {
            chain,
            sense,
            pairs,
            edge,
            units,
            stiffness_ratio,
        })
    }

    fn curve(
        &self,
        planned: &Planned,
        members: &[Member],
        outcomes: &[Outcome<Seen>],
    ) -> AttenuationCurve {
        let mut rows = Vec::new();
        let mut wanted = 0;
        for pair in &planned.pairs {
            let member = &members[pair.own];
            wanted = wanted.max(member.wanted);
            let Outcome::Done(seen) = &outcomes[pair.own] else {
                continue;
            };
            let reference = match &outcomes[pair.reference] {
                Outcome::Done(reference) => Some(reference),
                Outcome::Failed(_) => None,
            };
            rows.extend(rows_of(member, seen, reference));
        }
        let reached = rows.last().map(|row: &Row| row.bodies);
        let stopped_at = match planned.sense {
            Sense::Chain if reached < Some(wanted) => Some(reached.map_or(0, |n| n + 1)),
            _ => None,
        };
        let (n, y) = self.compared(&rows);
        let fits = fit(&n, &y, self.criterion);
        let reach = self
            .target
            .map(|target| reach(target, &n, &y, fits.as_ref()));
        AttenuationCurve {
            name: self.chains[planned.chain].name.clone(),
            sense: planned.sense,
            units: planned.units,
            stiffness_ratio: planned.stiffness_ratio,
            band_edge_frequency: planned.edge,
            rows,
            stopped_at,
            fits,
            reach,
        }
    }

    /// Lengths and relative forces of the contacts that are compared, like with like.
    fn compared(&self, rows: &[Row]) -> (Vec<f64>, Vec<f64>) {
        let like = |row: &&Row| {
            row.bodies > 0 && (row.kind == self.kind || row.kind == ContactKind::Other)
        };
        let pairs = rows.iter().filter(like);
        pairs
            .filter_map(|row| Some((row.bodies as f64, row.relative_force?)))
            .unzip()
    }
}

/// What is to be computed, each chain once.
#[derive(Default)]
struct Plan {
    members: Vec<Member>,
    curves: Vec<Planned>,
    edges: Vec<(Simulation, f64)>,
}

struct Planned {
    chain: usize,
    sense: Sense,
    pairs: Vec<Pair>,
    edge: Option<f64>,
    units: Units,
    stiffness_ratio: Option<f64>,
}

/// Indices of a member and of its homogeneous one.
struct Pair {
    own: usize,
    reference: usize,
}

impl Plan {
    /// The index of a member, of one and the same chain that is there already, if there is one.
    fn add(&mut self, member: Member) -> usize {
        let same = |other: &Member| {
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

/// The rows of what was seen, beside the homogeneous chain.
fn rows_of<'a>(
    member: &'a Member,
    seen: &'a Seen,
    reference: Option<&'a Seen>,
) -> impl Iterator<Item = Row> + 'a {
    let of_size = |s: &&Simulation| s.chain.n_sites() == seen.sites;
    let chain = member.attempts.iter().find(of_size).map(|s| &s.chain);
    let pulses = seen.pulses.pulses.iter().enumerate();
    pulses.map(move |(i, pulse)| {
        let beside = |pulse: &Pulse| {
            let pulses = &reference?.pulses.pulses;
            pulses.iter().find(|other| other.contact == pulse.contact)
        };
        let other = beside(pulse);
        let relative = |of: fn(&Pulse) -> f64| other.map(|other| of(pulse) / of(other));
        Row {
            bodies: pulse.contact,
            kind: chain.map_or(ContactKind::Other, |c| ContactKind::of(c, pulse.contact)),
            pulse: *pulse,
            high_share: seen.high.as_ref().map(|high| high[i]),
            relative_force: relative(|p| p.peak_force.value),
            relative_velocity: relative(|p| p.peak_velocity.value),
            relative_energy: relative(|p| p.energy_passed.value),
        }
    })
}

/// The length from which on a curve is at the target or below it.
fn reach(target: f64, n: &[f64], y: &[f64], fits: Option<&Fits>) -> Reach {
    let above = y.iter().rposition(|y| *y > target);
    let first = above.map_or(0, |at| at + 1);
    if let Some(n) = n.get(first) {
        return Reach::Within {
            bodies: *n as usize,
        };
    }
    let Some(fit) = fits.map(Fits::chosen) else {
        return Reach::Unknown;
    };
    let last = n.last().copied().unwrap_or(0.0);
    match fit.reaches(target) {
        // What a law says of lengths that are known is not what the curve says.
        Some(length) if length.high >= last => Reach::Beyond {
            law: fit.law,
            length,
        },
        Some(_) => Reach::Unknown,
        None => Reach::Never {
            law: fit.law,
            settles_at: fit.settles_at(),
        },
    }
}
