//! The chain that does what is wanted: keys of a scene for which a measure of its run is least or largest.
//!
//! A single key is searched on a grid, whose best cell is narrowed by golden sections; several by descents along
//! differences from the best of random points; with limits or lists of values by evolution. As many random designs are run
//! beside it: a search that does not beat them has found nothing of its own.

mod aim;
mod search;
mod sheet;
mod space;

use crate::chain::scene::SceneSource;
use crate::chain::{Accuracy, Run, Simulation, run_each};
use crate::observer::{CancelOnly, Observer};
use crate::{Error, Result};
use std::sync::{Mutex, PoisonError};

pub use aim::{Aim, Limit};
use search::Evaluate;
use space::{Free, Space, Tolerance};

/// Local error of the runs of a search, over the speed of the motion.
const LOCAL_ERROR: f64 = 1e-8;
/// What a design loses that exceeds a limit by all of it, over the size of the measure.
const PENALTY: f64 = 10.0;

/// By which of its members a design with tolerances is judged.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Judge {
    #[default]
    Worst,
    Mean,
}

/// What is designed, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignRequest {
    /// Free keys with bounds or values: `angle=2..90`, `radius=5mm|10mm`, `coefficients[]=0.2..5`.
    pub free: Vec<String>,
    pub aim: Aim,
    /// Whether the largest value is wanted.
    pub is_most: bool,
    pub limits: Vec<Limit>,
    /// Spreads of free keys: `angle=2deg`, `coefficients=10%`.
    pub tolerances: Vec<String>,
    pub judge: Judge,
    /// Designs off the nominal one, within the tolerances.
    pub members: usize,
    /// Designs that are tried; by default 60, or 100 and 60 for each of several keys.
    pub tries: Option<usize>,
    pub seed: u64,
}

impl DesignRequest {
    /// Makes a measure least, with all else as it is by default.
    pub fn least(aim: Aim, free: impl IntoIterator<Item = impl Into<String>>) -> DesignRequest {
        DesignRequest {
            free: free.into_iter().map(Into::into).collect(),
            aim,
            is_most: false,
            limits: Vec::new(),
            tolerances: Vec::new(),
            judge: Judge::default(),
            members: 20,
            tries: None,
            seed: 0,
        }
    }
}

/// A design and how it does.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// One for each free key.
    pub values: Vec<f64>,
    /// The measure of the nominal design; `None` where its run does not tell.
    pub measure: Option<f64>,
    /// That of each design within the tolerances; empty without.
    pub members: Vec<f64>,
    /// Force of the last contact.
    pub time: Vec<f64>,
    pub force: Vec<f64>,
    /// Of the velocities of its run, relative to their scale.
    pub error: Option<f64>,
}

/// A free key as it was searched.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignKey {
    pub name: String,
    pub unit: String,
    pub bounds: [f64; 2],
    /// Number of values of a list; 0 for all between the bounds.
    pub listed: usize,
}

/// What a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct Designed {
    pub request: DesignRequest,
    pub keys: Vec<DesignKey>,
    /// With the scene's own values.
    pub before: Design,
    pub after: Design,
    /// Judged values of the best design after so many tries, by search and by random tries; NaN before one is known.
    pub search: Vec<f64>,
    pub random: Vec<f64>,
    /// Judged values of the scene and of the result.
    pub judged: [f64; 2],
    /// Whether a random try is the result.
    pub is_random: bool,
    /// Tries whose run did not tell, and those beyond a limit.
    pub untold: usize,
    pub beyond: usize,
    pub method: &'static str,
    pub units: crate::chain::scene::Units,
    /// The scene with the values found.
    pub scene: String,
}

impl DesignRequest {
    /// Searches the design.
    ///
    /// Runs use all threads of the current pool; the result does not depend on their number.
    ///
    /// # Errors
    /// [`Error::Request`] for keys that cannot be searched, limits that the scene exceeds, a measure that the
    /// scene's own run does not tell; [`Error::Scene`]; [`Error::Cancelled`].
    pub fn run(&self, scene: &SceneSource, observer: &dyn Observer) -> Result<Designed> {
        let free = self.free.iter().map(|text| Free::all_of(text, scene));
        let free = free.collect::<Result<Vec<Vec<Free>>>>()?.concat();
        let expected = "keys of the scene with bounds";
        Error::require(!free.is_empty(), "free", expected, "none")?;
        let tolerances = self.tolerances.iter();
        let tolerances = tolerances.map(|text| Tolerance::parse(text, &free));
        let tolerances = tolerances.collect::<Result<Vec<Tolerance>>>()?;
        let space = Space::new(free, &tolerances, self.members, self.seed);
        let units = scene.setup().map_err(|error| scene.locate(error))?.units;
        let start = space.start();
        let mut trial = Trial {
            request: self,
            scene,
            space: &space,
            observer,
            size: 0.0,
            best: None,
            course: Vec::new(),
            untold: 0,
            beyond: 0,
        };
        // What is wrong with the scene or its run is said here.
        let before = trial.shown(&start)?;
        let dimensions = space.free.len();
        let tries = self.tries.unwrap_or(match dimensions {
            1 => 60,
            n => 100 + 60 * n,
        });
        observer.stage("designs", 2 * (tries * space.members()) as u64);
        let begun = trial.judged(std::slice::from_ref(&start))?[0];
        let first = value_of(&trial.best);
        let option = if self.is_most { "maximize" } else { "minimize" };
        let expected = "a scene whose run tells the measure";
        let found = "none: a later end_time or more samples may show it";
        Error::require(begun.is_finite(), option, expected, found)?;
        let listed: Vec<usize> = space.free.iter().map(Free::listed).collect();
        // Descents stop at limits, evolution goes along them.
        let is_smooth = self.limits.is_empty() && listed.iter().all(|count| *count == 0);
        let mut evaluate = |points: &[Vec<f64>]| trial.judged(points);
        let search: Evaluate = &mut evaluate;
        let (method, searched) = match (&listed[..], is_smooth) {
            ([0], _) => ("grid and golden sections", search::bracket(tries, search)),
            (_, true) => (
                "descents by differences (BFGS)",
                search::descend(&start, tries, self.seed, search),
            ),
            _ => (
                "evolution",
                search::evolve(&start, &listed, tries, self.seed, search),
            ),
        };
        searched?;
        let (searched, course) = trial.restart();
        let mut evaluate = |points: &[Vec<f64>]| trial.judged(points);
        search::random(dimensions, tries, self.seed, &mut evaluate)?;
        let (untold, beyond) = (trial.untold, trial.beyond);
        let (tried, random) = trial.restart();
        let is_random = value_of(&tried) < value_of(&searched);
        let Some((best, point)) = (if is_random { tried } else { searched }) else {
            let expected = "keys for which a run tells the measure";
            return Err(Error::request("free", expected, "none among all tries"));
        };
        let sign = |value: f64| match (value.is_infinite(), self.is_most) {
            (true, _) => f64::NAN,
            (false, true) => -value,
            (false, false) => value,
        };
        let after = trial.shown(&point)?;
        let keys = space.free.iter().map(|free| DesignKey {
            name: free.key.name.clone(),
            unit: free.key.unit.clone(),
            bounds: free.key.bounds,
            listed: free.listed(),
        });
        Ok(Designed {
            keys: keys.collect(),
            search: course.into_iter().map(sign).collect(),
            random: random.into_iter().map(sign).collect(),
            judged: [first, best].map(sign),
            is_random,
            untold,
            beyond,
            method,
            units,
            scene: scene.with(space.settings(&after.values, 0)).whole_text()?,
            before,
            after,
            request: self.clone(),
        })
    }

    /// What counts of a design by its members, smaller ones better; infinite if one does not tell.
    fn counted(&self, members: impl ExactSizeIterator<Item = Option<f64>>) -> f64 {
        let number = members.len() as f64;
        let sign = if self.is_most { -1.0 } else { 1.0 };
        let each = members.map(|measure| measure.map_or(f64::INFINITY, |m| sign * m));
        match self.judge {
            Judge::Worst => each.fold(f64::NEG_INFINITY, f64::max),
            Judge::Mean => each.sum::<f64>() / number,
        }
    }

    /// By how much limits are exceeded, relative to them.
    fn excess(&self, run: &Run) -> f64 {
        let over = self.limits.iter().filter_map(|limit| {
            let over =
                (limit.aim.of_run(run)? - limit.most) / limit.most.abs().max(f64::MIN_POSITIVE);
            (over > 0.0).then_some(over)
        });
        over.sum()
    }
}

/// What one run tells: the measure, and by how much it exceeds limits.
type Told = (Option<f64>, f64);

/// The best design by its judged value, and its point.
type Best = Option<(f64, Vec<f64>)>;

fn value_of(best: &Best) -> f64 {
    best.as_ref().map_or(f64::INFINITY, |(value, _)| *value)
}

/// Designs that are tried.
struct Trial<'a> {
    request: &'a DesignRequest,
    scene: &'a SceneSource,
    space: &'a Space,
    observer: &'a dyn Observer,
    /// Of the first measure.
    size: f64,
    best: Best,
    /// The best so far after each try.
    course: Vec<f64>,
    untold: usize,
    beyond: usize,
}

impl Trial<'_> {
    fn simulation(&self, values: &[f64], member: usize) -> Result<Simulation> {
        let settings = self.space.settings(values, member);
        let mut simulation = self.scene.with(settings).setup()?.simulation;
        simulation.record = self.request.aim.needs();
        Ok(simulation)
    }

    /// A design with the accuracy of its scene, and its members.
    fn shown(&self, point: &[f64]) -> Result<Design> {
        let values = self.space.values(point);
        let run = self.simulation(&values, 0)?;
        let run = run.run(&CancelOnly(self.observer))?;
        let members = (1..self.space.members()).map(|member| (&values[..], member));
        let told = self.told(&members.collect::<Vec<_>>(), &CancelOnly(self.observer))?;
        let members = told.iter().filter_map(|(measure, _)| *measure).collect();
        Ok(Design {
            measure: self.request.aim.of_run(&run),
            members,
            time: run.time.to_vec(),
            force: aim::force_of(&run).unwrap_or_default(),
            error: run.report.error,
            values,
        })
    }

    /// What the runs of members of designs tell, as accurate as a search needs; nothing where there is no run.
    fn told(&self, designs: &[(&[f64], usize)], observer: &dyn Observer) -> Result<Vec<Told>> {
        let quick = |(i, (values, member)): (usize, &(&[f64], usize))| {
            let mut simulation = self.simulation(values, *member).ok()?;
            simulation.estimate_error = false;
            if let Accuracy::Tolerance(_) = simulation.accuracy {
                simulation.accuracy = Accuracy::LocalError(LOCAL_ERROR);
            }
            Some((i, simulation))
        };
        let with_run = designs.iter().enumerate().filter_map(quick);
        let (places, simulations): (Vec<usize>, Vec<Simulation>) = with_run.unzip();
        let told = Mutex::new(vec![(None, 0.0); designs.len()]);
        let request = self.request;
        let ended = |i: usize, run: Result<Run>| {
            if let Ok(run) = run {
                let found = (request.aim.of_run(&run), request.excess(&run));
                told.lock().unwrap_or_else(PoisonError::into_inner)[places[i]] = found;
            }
            observer.advance(1);
        };
        run_each(&simulations, &CancelOnly(observer), &ended);
        observer.go_on()?;
        Ok(told.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    /// Judged values of designs, smaller ones better: larger by a penalty where a limit is exceeded, infinite where a run
    /// does not tell.
    fn judged(&mut self, points: &[Vec<f64>]) -> Result<Vec<f64>> {
        let members = self.space.members();
        let values = points.iter().map(|point| self.space.values(point));
        let values: Vec<Vec<f64>> = values.collect();
        let of = |values| (0..members).map(move |member| (values, member));
        let designs = values.iter().flat_map(|values| of(&values[..]));
        let told = self.told(&designs.collect::<Vec<_>>(), self.observer)?;
        let values = told.chunks(members).zip(points).map(|(told, point)| {
            let (value, excess) = self.value(told);
            let best = value_of(&self.best);
            let is_within = excess == 0.0;
            if is_within && value < best {
                self.best = Some((value, point.clone()));
            }
            self.course
                .push(if is_within { value.min(best) } else { best });
            value + PENALTY * self.size * excess
        });
        Ok(values.collect())
    }

    /// The value of a design, and by how much it exceeds limits.
    fn value(&mut self, told: &[Told]) -> (f64, f64) {
        let excess: f64 = told.iter().map(|(_, excess)| excess).sum();
        let measures = told.iter().map(|(measure, _)| *measure);
        let value = self.request.counted(measures);
        if self.size == 0.0 && value.is_finite() {
            self.size = value.abs();
        }
        self.untold += usize::from(!value.is_finite());
        self.beyond += usize::from(excess > 0.0);
        (value, excess)
    }

    /// The best design and the course up to here; begins anew.
    fn restart(&mut self) -> (Best, Vec<f64>) {
        (self.best.take(), std::mem::take(&mut self.course))
    }
}
