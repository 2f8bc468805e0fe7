//! Sweeps: many chains that differ in a few keys of one scene.
//!
//! A [`Sweep`] is a scene and its [`SweptKey`]s. Its members are the Cartesian product of the keys'
//! values, each named by its values. Every result is saved in a directory as soon as it is known,
//! so a killed sweep resumes, and parts can be computed on several machines and merged. The final
//! table is the same, byte for byte.

mod axis;
mod ensemble;
mod measures;
mod request;
mod sheet;
mod table;

use std::path::{Path, PathBuf};

use crate::system::memory::available_memory;

pub use axis::SweptKey;
pub(crate) use axis::{combinations, quantity};
pub use ensemble::{Ensemble, Spread};
pub use measures::{Measures, Needs};
pub use request::{Outcome, Outcomes, Request, read};
pub use sheet::Swept;
pub(crate) use sheet::{ORDER, in_order, wide};

use rayon::prelude::*;

use crate::chain::Simulation;
use crate::chain::scene::SceneSource;
use crate::observer::{CancelOnly, Observer};
use crate::system::journal::{Journal, difference, write_whole};
use crate::{Error, Result};

/// The name of the table in a sweep's directory.
pub const TABLE: &str = "table.csv";

/// The name of the table of its ensembles, where the seed is varied.
pub const ENSEMBLES: &str = "ensembles.csv";

/// One of the parts that a sweep is split into: every `of`-th member, from `index` on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    index: usize,
    of: usize,
}

impl Part {
    pub const WHOLE: Part = Part { index: 0, of: 1 };

    /// Part `number` of `of`, counted from 1.
    ///
    /// # Errors
    /// [`Error::Request`] unless `1 <= number <= of`.
    pub fn new(number: usize, of: usize) -> Result<Part> {
        let is_so = (1..=of).contains(&number);
        let expected = "K/N with K from 1 to N, such as 2/4";
        Error::require(is_so, "part", expected, format!("{number}/{of}"))?;
        let index = number - 1;
        Ok(Part { index, of })
    }

    fn holds(self, member: usize) -> bool {
        member % self.of == self.index
    }
}

/// A scene and its varied keys.
#[derive(Debug, Clone)]
pub struct Sweep {
    scene: SceneSource,
    request: Request,
}

/// How far a sweep is.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Standing {
    pub members: usize,
    /// Of these, how many are known, and how many of those failed.
    pub known: usize,
    pub failed: usize,
    /// How many were computed just now.
    pub computed: usize,
    /// The table, written once all members are known.
    pub table: Option<PathBuf>,
}

impl Sweep {
    /// A sweep over the product of `vary`, each in the syntax of [`SweptKey::parse`], the last key
    /// fastest.
    ///
    /// # Errors
    /// [`Error::Request`] for invalid syntax, an unknown key, or too many members; [`Error::Scene`]
    /// for a scene that is invalid for all values of its keys.
    pub fn new(scene: SceneSource, vary: &[String]) -> Result<Sweep> {
        let axes = vary.iter().map(|text| SweptKey::parse(text));
        let vary = axes.collect::<Result<Vec<SweptKey>>>()?;
        axis::count(&vary)?;
        let request = Request {
            version: env!("CARGO_PKG_VERSION").into(),
            scene: scene.whole_text()?,
            vary,
        };
        let sweep = Sweep { scene, request };
        sweep.simulation(0)?;
        Ok(sweep)
    }

    /// What a member runs.
    ///
    /// # Errors
    /// [`Error::Scene`] that names the member's value at fault.
    pub fn simulation(&self, member: usize) -> Result<Simulation> {
        let settings = self.request.settings(member);
        Ok(self.scene.with(settings).setup()?.simulation)
    }

    /// Computes the members of a part that `directory` does not hold yet, and writes the table once
    /// none is missing. A member whose run fails is kept with its reason.
    ///
    /// Runs on all threads of the current pool; neither their number nor the order of the work
    /// changes the table.
    ///
    /// # Errors
    /// Before any work, [`Error::OutputInUse`] for a directory that holds something else,
    /// [`Error::Scene`] for an invalid member, and [`Error::Memory`] if one run per thread does not
    /// fit, [`Error::Cancelled`] when the observer cancels; later [`Error::Write`], and
    /// [`Error::Paused`] when it cancels then. Finished
    /// members are kept.
    pub fn run(&self, directory: &Path, part: Part, observer: &dyn Observer) -> Result<Standing> {
        self.check(&CancelOnly(observer))?;
        let journal = Journal::open(Some(directory), &self.request)?;
        self.compute_part(&journal, part, observer)?;
        self.standing(directory, &journal.outcomes(), journal.computed())
    }

    /// Computes all members without a directory: nothing is saved, and nothing resumes.
    ///
    /// # Errors
    /// As [`Sweep::run`] before any work; [`Error::Cancelled`] when the observer cancels.
    pub fn compute(&self, observer: &dyn Observer) -> Result<(Request, Outcomes)> {
        self.check(&CancelOnly(observer))?;
        let journal = Journal::open(None, &self.request)?;
        self.compute_part(&journal, Part::WHOLE, observer)?;
        let outcomes = journal.outcomes().clone();
        Ok((self.request.clone(), outcomes))
    }

    fn compute_part(
        &self,
        journal: &Journal<usize, Measures>,
        part: Part,
        observer: &dyn Observer,
    ) -> Result<()> {
        let is_open = |member: &usize| part.holds(*member) && journal.known(member).is_none();
        let members: Vec<usize> = (0..self.request.members()).filter(is_open).collect();
        let computed = journal.each("chains", &members, observer, |member, observer| {
            let run = || Measures::of_run(self.simulation(*member)?, observer);
            journal.member(member, run).map(drop)
        });
        computed.map_err(|error| match error {
            Error::Paused { known, .. } => {
                let members = self.request.members();
                Error::Paused { known, members }
            }
            error => error,
        })?;
        journal.sync()
    }

    /// Checks that every member is valid, and that one run per thread fits into memory.
    fn check(&self, observer: &dyn Observer) -> Result<()> {
        let sizes: Result<Vec<(u64, Option<u64>)>> = (0..self.request.members())
            .into_par_iter()
            .map(|member| {
                observer.go_on()?;
                let simulation = self.simulation(member)?;
                Ok((simulation.bytes(), simulation.memory))
            })
            .collect();
        let sizes = sizes?;
        let allowed = sizes.iter().filter_map(|(_, memory)| *memory).min();
        let allowed = allowed.unwrap_or_else(available_memory);
        let threads = rayon::current_num_threads().min(self.request.members()) as u64;
        let largest = sizes.iter().map(|(bytes, _)| *bytes).max().unwrap_or(0);
        let needed = largest.saturating_mul(threads);
        Error::beyond_memory("a run on every thread", needed, allowed)
    }

    /// Puts together what directories hold of one and the same sweep.
    ///
    /// # Errors
    /// [`Error::Read`] for a directory that holds no sweep, [`Error::OutputInUse`] where they hold
    /// different ones, and as [`Sweep::run`].
    pub fn merge(directories: &[PathBuf], out: &Path) -> Result<Standing> {
        let Some((first, rest)) = directories.split_first() else {
            return Err(Error::request("merge", "directories of sweeps", "none"));
        };
        let (request, mut outcomes) = read(first)?;
        for directory in rest {
            let (other, more) = read(directory)?;
            if let Some(difference) = difference(&other, &request) {
                return Err(Error::OutputInUse {
                    path: directory.clone(),
                    found: format!("holds another sweep than {}: {difference}", first.display()),
                });
            }
            outcomes.extend(more);
        }
        let scene = SceneSource::new(None, request.scene.clone());
        axis::count(&request.vary)?;
        let sweep = Sweep { scene, request };
        let journal = Journal::open(Some(out), &sweep.request)?;
        for (member, outcome) in outcomes {
            if journal.known(&member).is_none() {
                journal.add(&member, outcome)?;
            }
        }
        journal.sync()?;
        sweep.standing(out, &journal.outcomes(), 0)
    }

    fn standing(&self, directory: &Path, outcomes: &Outcomes, computed: usize) -> Result<Standing> {
        let failed = outcomes.values().filter(|outcome| outcome.done().is_none());
        let write = |name: &str, text: Result<String, csv::Error>| {
            let path = directory.join(name);
            let text = text.map_err(|error| Error::write("write", &path)(error.into()))?;
            write_whole(directory, name, text.as_bytes())
        };
        let mut table = None;
        if outcomes.len() == self.request.members() {
            let ensembles = self.request.ensembles(outcomes);
            if !ensembles.is_empty() {
                write(ENSEMBLES, table::of_ensembles(&self.request, &ensembles))?;
            }
            table = Some(write(TABLE, table::of_members(&self.request, outcomes))?);
        }
        Ok(Standing {
            members: self.request.members(),
            known: outcomes.len(),
            failed: failed.count(),
            computed,
            table,
        })
    }
}
