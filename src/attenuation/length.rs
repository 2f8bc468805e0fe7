//! Attenuation against length.

use std::path::Path;

use rayon::prelude::*;

use super::chains::{ContactKind, Pattern, SceneTemplate};
use super::curve::{
    Attenuation, AttenuationCurve, CurveRow, Reach, Stop, StopCause, compared, reach, rows_of,
};
use super::fit::{Criterion, fit};
use super::high_band::default_edge;
use super::members::{Known, Pair, See, StoredChains, follow};
use super::pulse::Sense;
use crate::chain::Simulation;
use crate::chain::scene::{SceneSource, Units};
use crate::observer::Observer;
use crate::{Error, Result};

/// Most bodies of a chain.
const MOST: usize = 100_000;

/// Every length up to this one is simulated in the wall sense.
const EVERY: usize = 40;

/// Initial margin of bodies behind the last requested contact, to which a quarter of the length is
/// added. It makes the contact's pulse complete before the front reaches the wall, and is doubled
/// as needed, at most [`DOUBLINGS`] times.
const MARGIN: usize = 20;
const DOUBLINGS: u32 = 4;

/// Lengths behind one that is at or below the target, of which none may be above it: a period of a dimer.
const PERIOD: usize = 2;

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

impl AttenuationRequest {
    /// # Errors
    /// [`crate::Error::Request`] for missing or invalid values.
    fn check(&self) -> Result<()> {
        let is_so = !self.chains.is_empty();
        Error::require(is_so, "chains", "at least one chain", "none")?;
        let is_so = (2..=MOST).contains(&self.length);
        Error::require(is_so, "bodies", format!("2 to {MOST}"), self.length)?;
        let is_so = !self.senses.is_empty();
        Error::require(is_so, "sense", "chain, wall or both", "none")?;
        let target = self.target.unwrap_or(0.5);
        let is_so = target > 0.0 && target < 1.0;
        Error::require(is_so, "target", "a number between 0 and 1", target)?;
        let edge = self.band_edge_frequency.unwrap_or(0.0);
        let is_so = edge.is_finite() && edge >= 0.0;
        Error::require(is_so, "band-edge-frequency", "0 or more", edge)?;
        let own = [self.length];
        let lengths = self.lengths.as_deref().unwrap_or(&own);
        let is_so = !lengths.is_empty();
        Error::require(is_so, "lengths", "at least one length", "none")?;
        lengths.iter().try_for_each(|n| {
            let expected = format!("1 to {MOST} bodies each");
            Error::require((1..=MOST).contains(n), "lengths", expected, n)
        })
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

    /// Follows the pulses of all chains and of their homogeneous references, fits the curves, and finds the length that
    /// reaches the target by further runs, up to half as long again.
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
        let lengths = self.wall_lengths();
        let (mut scenes, mut courses, mut edges) = (Vec::new(), Vec::new(), Vec::new());
        for chain in &self.chains {
            let make = SceneTemplate::new(chain.scene.clone())?;
            scenes.push(make.text()?);
            for &sense in &self.senses {
                let course = self.course(&chain.name, make.clone(), sense, &mut edges)?;
                let lengths = match (sense, course.make.extends) {
                    (Sense::Wall, true) => &lengths[..],
                    _ => &[self.length],
                };
                let pairs: Result<Vec<Pair>> = lengths.iter().map(|n| course.pair(*n)).collect();
                courses.push((course, pairs?));
            }
        }
        let known = Known::open(directory, &StoredChains::new(scenes, "bodies"))?;
        let pairs = courses.iter().flat_map(|(_, pairs)| pairs);
        let (curves, failed, computed) = follow(pairs, &known, observer, |see| {
            let curves = courses.par_iter();
            let curves = curves.map(|(course, pairs)| self.curve(course, pairs, see));
            curves.collect()
        })?;
        Ok(Attenuation {
            length: self.length,
            kind: self.kind,
            target: self.target,
            curves,
            failed,
            computed,
        })
    }

    /// A chain in one sense; `edges` are those of references that are known.
    fn course(
        &self,
        name: &str,
        make: SceneTemplate,
        sense: Sense,
        edges: &mut Vec<(Simulation, Option<f64>)>,
    ) -> Result<Course> {
        let mut course = Course {
            name: name.to_owned(),
            pattern: make.pattern()?,
            units: make.setup()?.units,
            make,
            sense,
            edge: None,
        };
        if sense == Sense::Wall || !self.high_band {
            return Ok(course);
        }
        course.edge = self.band_edge_frequency;
        if course.edge.is_none() {
            let reference = course.pair(self.length)?.reference.attempts.swap_remove(0);
            let known = edges.iter().find(|(known, _)| *known == reference);
            // A reference that cannot be run has no edge; why is said of its member.
            course.edge = known.map_or_else(|| default_edge(&reference).ok(), |(_, edge)| *edge);
            edges.push((reference, course.edge));
        }
        Ok(course)
    }

    fn curve(&self, course: &Course, pairs: &[Pair], see: See) -> Result<AttenuationCurve> {
        let mut rows: Vec<CurveRow> = Vec::new();
        let mut stop = None;
        for pair in pairs {
            let (more, stopped) = course.rows(pair, see)?;
            rows.extend(more);
            stop = stop.or(stopped);
        }
        let fits = fit(&compared(self.kind, &rows), self.criterion);
        let mut found = None;
        if let Some(target) = self.target {
            let mut tried: Vec<usize> = pairs.iter().map(|pair| pair.own.wanted).collect();
            let asked = tried.iter().copied().fold(0, usize::max);
            loop {
                let points = compared(self.kind, &rows);
                let reached = reach(target, &points, fits.as_ref());
                found = Some(reached);
                let Some(bodies) = self.refined(course, reached, &points, (asked, &tried))? else {
                    break;
                };
                tried.push(bodies);
                let (more, _) = course.rows(&course.pair(bodies)?, see)?;
                if course.sense == Sense::Chain && !more.is_empty() {
                    rows.clear();
                }
                rows.extend(more);
                rows.sort_by_key(|row| row.bodies);
            }
        }
        Ok(AttenuationCurve {
            name: course.name.clone(),
            sense: course.sense,
            units: course.units,
            stiffness_ratio: course.pattern.stiffness_ratio(),
            band_edge_frequency: course.edge,
            rows,
            stop,
            fits,
            reach: found,
        })
    }

    /// The next length to run for the one that reaches the target: half as long again as the longest that is asked for,
    /// where none does; at walls then between the last above the target and the first below it, and behind that.
    fn refined(
        &self,
        course: &Course,
        reached: Reach,
        points: &[(f64, f64)],
        (asked, tried): (usize, &[usize]),
    ) -> Result<Option<usize>> {
        let longest = tried.iter().copied().fold(0, usize::max);
        let candidates: Vec<usize> = match reached {
            _ if !course.make.extends => Vec::new(),
            Reach::Beyond { .. } if longest == asked => {
                let end = asked + asked.div_ceil(2);
                (end..end + PERIOD).collect()
            }
            Reach::Within { bodies } if course.sense == Sense::Wall => {
                let mut before = points.iter().rev().map(|(n, _)| *n as usize);
                let above = before.find(|n| *n < bodies).unwrap_or(0);
                let middle = (above + bodies) / 2;
                let mut between: Vec<usize> = (above + 1..bodies).collect();
                between.sort_by_key(|n| n.abs_diff(middle));
                between.extend(bodies + 1..=(bodies + PERIOD).min(longest));
                between
            }
            _ => Vec::new(),
        };
        for bodies in candidates {
            if !tried.contains(&bodies) && course.is_compared(bodies, self.kind)? {
                return Ok(Some(bodies));
            }
        }
        Ok(None)
    }
}

/// A chain in one sense.
struct Course {
    name: String,
    make: SceneTemplate,
    sense: Sense,
    pattern: Pattern,
    edge: Option<f64>,
    units: Units,
}

impl Course {
    /// The chain of a length, or of its own where that is fixed, and its reference.
    fn pair(&self, bodies: usize) -> Result<Pair> {
        let longer = |k| self.make.with_bodies(bodies + ((MARGIN + bodies / 4) << k));
        let setups = match (self.sense, self.make.extends) {
            (_, false) => vec![self.make.setup()],
            (Sense::Wall, true) => vec![self.make.with_bodies(bodies)],
            (Sense::Chain, true) => (0..=DOUBLINGS).map(longer).collect(),
        };
        let attempts = setups.into_iter().map(|setup| Ok(setup?.simulation));
        let attempts = attempts.collect::<Result<Vec<Simulation>>>()?;
        let wanted = match (self.sense, self.make.extends) {
            (Sense::Wall, false) => attempts[0].chain.n_sites() - 1,
            _ => bodies,
        };
        let name = format!("{}, {}, {wanted} bodies", self.name, self.sense.name());
        let place = (self.sense, wanted);
        Pair::new(&name, attempts, &self.pattern, place, self.edge)
    }

    /// Whether the force of a length is among those that are compared.
    fn is_compared(&self, bodies: usize, kind: ContactKind) -> Result<bool> {
        let chain = self.make.with_bodies(bodies)?.simulation.chain;
        let last = chain.coefficient.last().map(|c| self.pattern.kind(*c));
        Ok(self.sense == Sense::Chain || last == Some(kind) || last == Some(ContactKind::Other))
    }

    /// The points of a chain, and where and why they end before the wanted one.
    fn rows(&self, pair: &Pair, see: See) -> Result<(Vec<CurveRow>, Option<Stop>)> {
        let [own, reference] = see(pair)?;
        let wanted = pair.own.wanted;
        let Some(seen) = own.done() else {
            let (bodies, cause) = (wanted, StopCause::Failed);
            return Ok((Vec::new(), Some(Stop { bodies, cause })));
        };
        let rows = rows_of(&pair.own, seen, reference.done(), &self.pattern);
        let last = rows.last().map(|row| row.bodies);
        let stop = (last < Some(wanted)).then(|| Stop {
            bodies: match self.sense {
                Sense::Chain => last.map_or(0, |n| n + 1),
                Sense::Wall => wanted,
            },
            cause: match seen.pulses.arrived {
                true => StopCause::Reflection,
                false => StopCause::Faded,
            },
        });
        Ok((rows, stop))
    }
}
