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
use std::sync::{Mutex, PoisonError};

use crate::system::memory::available_memory;

pub use axis::SweptKey;
pub(crate) use axis::quantity;
pub use ensemble::{Ensemble, Spread};
pub use measures::{Measures, Needs};
pub(crate) use request::below;
pub use request::{Outcome, Outcomes, Request, read};
pub use sheet::Swept;

use rayon::prelude::*;

use crate::chain::scene::{Kind, SceneSource, Setting, properties};
use crate::chain::{Run, Simulation, run_each};
use crate::observer::{CancelOnly, Observer};
use crate::system::journal::{Journal, StoredRequest, write_whole};
use crate::{Error, Result};

/// The name of the table in a sweep's directory.
pub const TABLE: &str = "table.csv";

/// The name of the table of its ensembles, where the seed is varied.
pub const ENSEMBLES: &str = "ensembles.csv";

/// Members that are prepared together; preparing a scene costs little compared with its run.
const BATCH: usize = 256;

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
        if number == 0 || number > of {
            return Err(Error::Request {
                option: "part",
                expected: "K/N with K from 1 to N, such as 2/4".into(),
                found: format!("{number}/{of}"),
            });
        }
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
    members: usize,
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
        let axes: Result<Vec<SweptKey>> = vary.iter().map(|text| axis_of_scenes(text)).collect();
        let axes = axes?;
        let members = axis::count(&axes)?;
        let request = Request {
            version: env!("CARGO_PKG_VERSION").into(),
            scene: scene.whole_text()?,
            vary: axes,
        };
        let sweep = Sweep {
            scene,
            request,
            members,
        };
        sweep.simulation(0)?;
        Ok(sweep)
    }

    /// How many members there are.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.members
    }

    /// The varied keys and their values in a member.
    pub fn values(&self, member: usize) -> Vec<(&str, &str)> {
        let keys = self.request.vary.iter().map(|axis| axis.key.as_str());
        keys.zip(axis::member(&self.request.vary, member)).collect()
    }

    /// What a member runs.
    ///
    /// # Errors
    /// [`Error::Scene`] that names the member's value at fault.
    pub fn simulation(&self, member: usize) -> Result<Simulation> {
        let settings = self.values(member).into_iter().map(|(key, value)| Setting {
            key: key.to_owned(),
            text: value.to_owned(),
            source: format!("values of {key}"),
        });
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
        let (journal, mut outcomes): (Journal, Outcomes) =
            Journal::open(directory, &self.request, &below(self.members))?;
        let missing: Vec<usize> = (0..self.members)
            .filter(|member| part.holds(*member) && !outcomes.contains_key(member))
            .collect();
        let computed = self.compute_each(&missing, Some(&journal), &mut outcomes, observer);
        computed.map_err(|error| match error {
            Error::Cancelled => Error::Paused {
                known: outcomes.len(),
                members: self.members,
            },
            error => error,
        })?;
        journal.sync()?;
        self.standing(directory, outcomes, missing.len())
    }

    /// Computes all members without a directory: nothing is saved, and nothing resumes.
    ///
    /// # Errors
    /// As [`Sweep::run`] before any work; [`Error::Cancelled`] when the observer cancels.
    pub fn compute(&self, observer: &dyn Observer) -> Result<(Request, Outcomes)> {
        self.check(&CancelOnly(observer))?;
        let members: Vec<usize> = (0..self.members).collect();
        let mut outcomes = Outcomes::new();
        self.compute_each(&members, None, &mut outcomes, observer)?;
        Ok((self.request.clone(), outcomes))
    }

    /// Computes members, and adds what became of them to `outcomes`; of a batch that is cancelled, those that
    /// are done.
    fn compute_each(
        &self,
        members: &[usize],
        journal: Option<&Journal>,
        outcomes: &mut Outcomes,
        observer: &dyn Observer,
    ) -> Result<()> {
        observer.stage("chains", members.len() as u64);
        for members in members.chunks(BATCH) {
            let simulations: Result<Vec<Simulation>> = members
                .iter()
                .map(|member| self.simulation(*member).map(measures::without_flow))
                .collect();
            let done = Collected::default();
            let watch = SweepObserver {
                observer,
                done: &done,
            };
            run_each(&simulations?, &watch, &|i, result| {
                done.take(members[i], result, journal);
                observer.advance(1);
            });
            let (more, error) = done.finish();
            outcomes.extend(more);
            if let Some(error) = error {
                return Err(error);
            }
        }
        Ok(())
    }

    /// Checks that every member is valid, and that one run per thread fits into memory.
    fn check(&self, observer: &dyn Observer) -> Result<()> {
        let sizes: Result<Vec<(u64, Option<u64>)>> = (0..self.members)
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
        let threads = rayon::current_num_threads().min(self.members) as u64;
        let largest = sizes.iter().map(|(bytes, _)| *bytes).max().unwrap_or(0);
        let needed = largest.saturating_mul(threads);
        if needed > allowed {
            return Err(Error::Memory {
                what: "a run on every thread",
                needed,
                allowed,
            });
        }
        Ok(())
    }

    /// Puts together what directories hold of one and the same sweep.
    ///
    /// # Errors
    /// [`Error::Read`] for a directory that holds no sweep, [`Error::OutputInUse`] where they hold
    /// different ones, and as [`Sweep::run`].
    pub fn merge(directories: &[PathBuf], out: &Path) -> Result<Standing> {
        let Some((first, rest)) = directories.split_first() else {
            return Err(Error::Request {
                option: "merge",
                expected: "directories of sweeps".into(),
                found: "none".into(),
            });
        };
        let (request, mut outcomes) = read(first)?;
        for directory in rest {
            let (other, more) = read(directory)?;
            if let Some(difference) = other.difference(&request) {
                return Err(Error::OutputInUse {
                    path: directory.clone(),
                    found: format!("holds another sweep than {}: {difference}", first.display()),
                });
            }
            more.into_iter().for_each(|(member, outcome)| {
                outcomes.entry(member).or_insert(outcome);
            });
        }
        let scene = SceneSource::new(None, request.scene.clone());
        let members = axis::count(&request.vary)?;
        let sweep = Sweep {
            scene,
            request,
            members,
        };
        let (journal, known): (Journal, Outcomes) =
            Journal::open(out, &sweep.request, &below(sweep.members))?;
        for (member, outcome) in &outcomes {
            if !known.contains_key(member) {
                journal.add(member, outcome)?;
            }
        }
        journal.sync()?;
        outcomes.extend(known);
        sweep.standing(out, outcomes, 0)
    }

    fn standing(&self, directory: &Path, outcomes: Outcomes, computed: usize) -> Result<Standing> {
        let failed = outcomes
            .values()
            .filter(|o| matches!(o, Outcome::Failed(_)));
        let failed = failed.count();
        let known = outcomes.len();
        let table = if known == self.members {
            let path = directory.join(TABLE);
            let text = table::csv(&self.request, &outcomes)
                .map_err(|error| Error::write("write", &path)(error.into()))?;
            let ensembles = self.request.ensembles(&outcomes);
            if !ensembles.is_empty() {
                let path = directory.join(ENSEMBLES);
                let text = ensemble::csv(&self.request, &ensembles)
                    .map_err(|error| Error::write("write", &path)(error.into()))?;
                write_whole(directory, ENSEMBLES, text.as_bytes())?;
            }
            Some(write_whole(directory, TABLE, text.as_bytes())?)
        } else {
            None
        };
        Ok(Standing {
            members: self.members,
            known,
            failed,
            computed,
            table,
        })
    }
}

/// An axis whose key is one of scenes.
pub(crate) fn axis_of_scenes(text: &str) -> Result<SweptKey> {
    let axis = SweptKey::parse(text, is_whole)?;
    match properties().iter().any(|p| p.name == axis.key) {
        true => Ok(axis),
        false => Err(Error::Request {
            option: "vary",
            expected: "a key of scenes (`cascade scene` prints them)".into(),
            found: format!("`{}`", axis.key),
        }),
    }
}

/// All combinations of the values of axes, as keys with values, the last axis fastest; of no axes,
/// one without any.
pub(crate) fn combinations(axes: &[SweptKey]) -> Result<Vec<Vec<(String, String)>>> {
    if axes.is_empty() {
        return Ok(vec![Vec::new()]);
    }
    let keys = || axes.iter().map(|axis| axis.key.clone());
    let of = |member| {
        let values = axis::member(axes, member).into_iter().map(str::to_owned);
        keys().zip(values).collect()
    };
    Ok((0..axis::count(axes)?).map(of).collect())
}

fn is_whole(key: &str) -> bool {
    let mut all = properties().iter();
    all.any(|p| p.name == key && matches!(p.kind, Kind::Whole))
}

/// The results of a batch.
#[derive(Default)]
struct Collected(Mutex<(Outcomes, Option<Error>)>);

impl Collected {
    fn take(&self, member: usize, result: Result<Run>, journal: Option<&Journal>) {
        let outcome = match result {
            Ok(run) => Outcome::Done(Measures::of(&run)),
            // Neither is the fault of the member.
            Err(error @ (Error::Cancelled | Error::Memory { .. })) => return self.stop(error),
            Err(error) => Outcome::Failed(error.to_string()),
        };
        if let Some(Err(error)) = journal.map(|journal| journal.add(&member, &outcome)) {
            return self.stop(error);
        }
        self.lock().0.insert(member, outcome);
    }

    fn stop(&self, error: Error) {
        self.lock().1.get_or_insert(error);
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, (Outcomes, Option<Error>)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn finish(self) -> (Outcomes, Option<Error>) {
        self.0.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Cancels when the observer does, or when results can no longer be saved.
struct SweepObserver<'a> {
    observer: &'a dyn Observer,
    done: &'a Collected,
}

impl Observer for SweepObserver<'_> {
    fn cancelled(&self) -> bool {
        self.observer.cancelled() || self.done.lock().1.is_some()
    }
}
