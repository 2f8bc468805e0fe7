//! Why a chain does not explain records: a number that the fit holds, another end, or records of other bodies or signs, named where
//! it leaves noise alone.
//!
//! Each alternative is tried by its score: the share of the residual that its derivative, beside those of the unknowns,
//! explains. The chain is then fitted again with each of the best ones free, and with each that is no small change.
//!
//! Source: C. R. Rao, Proc. Camb. Phil. Soc. 44 (1948) 50 (score tests).

use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde::Serialize;

use super::key::{FreeKey, numbers};
use super::model::{Model, Other};
use super::records::Records;
use super::result::{judge, misfit};
use super::shown::{place, some_places};
use super::solver::{Beside, Minimum, Problem, dot, minimize, square};
use super::verdict::RARE;
use crate::chain::scene::{SceneSource, Setting};
use crate::chain::{Ends, Law, Simulation};
use crate::numeric::fisher_tail;
use crate::observer::Observer;
use crate::{Error, Result};

/// How long causes are searched, and how much longer than the search of the chain, if that is more.
const PATIENCE: Duration = Duration::from_secs(60);
const LONGER: u32 = 30;

/// Alternatives that are fitted since their scores are best.
const FITTED: usize = 5;

/// Bodies, and contacts, that are tried, at most.
const PLACES: usize = 24;

/// Share of a derivative beside those of the unknowns below which it is one of them.
const OWN: f64 = 1e-3;

/// Relative difference of scores up to which two changes are the same one.
const SAME: f64 = 1e-6;

/// Level at which the decrease of the squares is no chance, for all alternatives together.
const LEVEL: f64 = 1e-3;

/// Decrease of the squares, in variances of the noise, by which the best alternative is told from another one.
const TOLD: f64 = 10.0;

/// Alternatives that explain as much, from which on none is named.
const RIVALS: usize = 2;

/// What explains a misfit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cause {
    /// A key of the scene, or what it is of: `tangent`, `mass of body 6`, `ends = "wall"`.
    pub name: String,
    /// What it is in the scene and with the best fit; the factor of masses, coefficients, speeds and gains. NaN for what is no
    /// number.
    pub held: f64,
    pub free: f64,
    /// Share of the squares of what is left that goes.
    pub explained: f64,
    /// Whether noise alone is left; no other cause is named.
    pub is_all: bool,
    /// Others that explain as much.
    pub rivals: Vec<String>,
    /// What takes it into account.
    #[serde(skip)]
    pub cure: String,
}

/// Numbers of a chain that are no keys of its scene, as factors of what they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Factor {
    Coefficients,
    Mass(usize),
    Contact(usize),
}

impl Factor {
    pub fn apply(self, simulation: &mut Simulation, by: f64) {
        let chain = &mut simulation.chain;
        match self {
            Factor::Coefficients => chain.coefficient.iter_mut().for_each(|c| *c *= by),
            Factor::Mass(body) => chain.mass[body] *= by,
            Factor::Contact(contact) => chain.coefficient[contact] *= by,
        }
    }
}

/// What is tried in place of a model: one more unknown, another scene, other records.
struct Alternative {
    name: String,
    /// What it is one of.
    kind: String,
    scene: Option<SceneSource>,
    records: Option<Records>,
    /// Where its unknown starts.
    start: f64,
    /// Whether it is no small change, which a derivative would tell.
    is_whole: bool,
    /// Those of the model, with one more if it is a number.
    keys: Vec<FreeKey>,
    others: Vec<Other>,
}

impl Alternative {
    fn of(model: &Model, name: impl Into<String>, kind: &str) -> Alternative {
        let name = name.into();
        let kind = if kind.is_empty() { &name } else { kind };
        Alternative {
            kind: kind.to_owned(),
            name,
            scene: None,
            records: None,
            start: 0.0,
            is_whole: false,
            keys: model.keys.to_vec(),
            others: model.others.to_vec(),
        }
    }

    fn with_key(model: &Model, key: FreeKey) -> Alternative {
        let mut own = Alternative::of(model, key.name.clone(), "");
        own.keys.push(key);
        own
    }

    fn with_other(model: &Model, name: String, kind: &str, other: Other) -> Alternative {
        let mut own = Alternative::of(model, name, kind);
        own.others.push(other);
        own
    }

    fn model<'a>(&'a self, model: &Model<'a>) -> Model<'a> {
        Model {
            scene: self.scene.as_ref().unwrap_or(model.scene),
            records: self.records.as_ref().unwrap_or(model.records),
            keys: &self.keys,
            others: &self.others,
            ..*model
        }
    }

    /// The coordinate that is its own.
    fn own(&self, model: &Model) -> Option<usize> {
        let of_key = self.key(model).map(|_| model.keys.len());
        of_key.or(self.other(model).map(|_| model.unknowns()))
    }

    fn key(&self, model: &Model) -> Option<&FreeKey> {
        self.keys.get(model.keys.len())
    }

    fn other(&self, model: &Model) -> Option<&Other> {
        self.others.get(model.others.len())
    }

    /// A point of the model as one of its own.
    fn point(&self, model: &Model, at: &[f64]) -> Vec<f64> {
        let mut point = at.to_vec();
        if let Some(own) = self.own(model) {
            point.insert(own, self.start);
        }
        point
    }

    /// The share of the residual that a small change explains beside the unknowns; 0 of others.
    fn score(&self, model: &Model, found: &Minimum, beside: &Beside) -> Result<f64> {
        let residual = beside.rest(&found.residual);
        let (own, point) = (self.model(model), self.point(model, &found.at));
        let Some(k) = self.own(model).filter(|_| !self.is_whole) else {
            return Ok(0.0);
        };
        let mut change = own.column(&point, k)?;
        change.resize(found.residual.len(), 0.0);
        let rest = beside.rest(&change);
        let left = square(&rest);
        if left.is_nan() || left <= OWN * OWN * square(&change) {
            return Ok(0.0);
        }
        Ok(dot(&rest, &residual).powi(2) / (left * square(&residual)))
    }

    /// The chain fitted with it, from the fit or from the scene, whichever is nearer.
    fn fit(&self, model: &Model, found: &Minimum) -> Result<Minimum> {
        let own = self.model(model);
        let mut start = self.point(model, &found.at);
        if self.is_whole {
            let first = self.point(model, &vec![0.0; found.at.len()]);
            let squares = |at: &[f64]| own.residual(at).map_or(f64::INFINITY, |r| square(&r));
            if squares(&first) < squares(&start) {
                start = first;
            }
        }
        minimize(&own, &start)
    }

    /// The value of the unknown at a coordinate; NaN of what is no number.
    fn value(&self, model: &Model, u: f64) -> f64 {
        match (self.key(model), self.other(model)) {
            (Some(key), _) => key.value_at(u),
            (None, Some(Other::Clock)) => u * model.records.step(),
            (None, Some(_)) => u.exp(),
            (None, None) => f64::NAN,
        }
    }
}

/// Numbers of the scene: those that it states, and losses, precompression and the exponent where it does not.
fn of_scene(model: &Model, simulation: &Simulation) -> Vec<Alternative> {
    let chain = &simulation.chain;
    let (speed, count) = (simulation.speed(), chain.n_sites() as f64);
    let (time, mass) = (
        simulation.contact_time(speed),
        chain.mass.iter().sum::<f64>() / count,
    );
    let scales = [
        ("dashpot", mass / time),
        ("tangent", time),
        ("drag", mass / time),
        ("precompression", mass * speed / time),
    ];
    let keys = numbers(model.scene, &scales).into_iter();
    let is_held = |key: &FreeKey| model.keys.iter().all(|free| free.name != key.name);
    let keys = keys
        .filter(is_held)
        .map(|key| Alternative::with_key(model, key));
    let power = [("law", "power"), ("exponent", "1.5")];
    let power = power.map(|(key, value)| Setting::new(key, value, key));
    let scene = model.scene.with(power);
    let exponent = FreeKey::of("exponent", &scene).ok();
    let exponent = exponent.filter(|_| chain.law.only() == Some(&Law::Hertz));
    let exponent = exponent.map(|key| Alternative {
        scene: Some(scene),
        ..Alternative::with_key(model, key)
    });
    keys.chain(exponent).collect()
}

/// Factors of the chain, of masses and contacts near some bodies.
fn of_chain(model: &Model, simulation: &Simulation, bodies: &[usize]) -> Vec<Alternative> {
    let chain = &simulation.chain;
    let near = |count: usize| {
        let mut places: Vec<usize> = (0..count).collect();
        places.sort_by_key(|place| bodies.iter().map(|body| body.abs_diff(*place)).min());
        places.truncate(PLACES);
        places.sort_unstable();
        places
    };
    let factor = |name: String, kind: &str, factor| {
        Alternative::with_other(model, name, kind, Other::Factor(factor))
    };
    let all = factor(
        "coefficients of all contacts".into(),
        "",
        Factor::Coefficients,
    );
    let masses = near(chain.n_sites()).into_iter();
    let masses = masses.map(|body| {
        factor(
            format!("mass of body {body}"),
            "one mass",
            Factor::Mass(body),
        )
    });
    let contacts = near(chain.n_contacts()).into_iter().map(|j| {
        let name = match chain.ends {
            Ends::Periodic => format!("coefficient of contact {j}"),
            _ if j + 1 == chain.n_sites() => "coefficient of the wall".into(),
            _ => format!("coefficient between bodies {j} and {}", j + 1),
        };
        factor(name, "one coefficient", Factor::Contact(j))
    });
    let end = match chain.ends {
        Ends::Free => Some("wall"),
        Ends::Wall => Some("free"),
        _ => None,
    };
    let end = end.and_then(|end| {
        let scene = model.scene.with([Setting::new("ends", end, "ends")]);
        // Of forces the last contact may be measured.
        model.records.check(&scene.setup().ok()?).ok()?;
        Some(Alternative {
            scene: Some(scene),
            is_whole: true,
            ..Alternative::of(model, format!("ends = \"{end}\""), "")
        })
    });
    [all]
        .into_iter()
        .chain(masses)
        .chain(contacts)
        .chain(end)
        .collect()
}

/// Gains, the clock, and records that are of other bodies, or upside down.
fn of_instruments(model: &Model) -> Result<Vec<Alternative>> {
    let records = model.records;
    let mut all = Vec::new();
    let has_gains = model
        .others
        .iter()
        .any(|other| matches!(other, Other::Gain(_)));
    if !has_gains {
        let name = place(records.quantity);
        let gain = |(site, body)| {
            let name = format!("gain at {name} {body}");
            Alternative::with_other(model, name, "one gain", Other::Gain(site))
        };
        let gains = records.bodies.iter().enumerate().map(gain);
        all.extend(gains);
        if records.bodies.len() > 1 {
            let name = "gain of all records".to_owned();
            all.push(Alternative::with_other(model, name, "", Other::Gains));
        }
    }
    let origin = vec![0.0; model.unknowns()];
    if !model.others.contains(&Other::Clock) {
        let name = "clock of the records".to_owned();
        let clock = Alternative::with_other(model, name, "", Other::Clock);
        let start = records.delay(&model.records_at(&origin, model.local_error)?);
        all.push(Alternative {
            start,
            is_whole: true,
            ..clock
        });
    }
    let [stated, fitting] = placed(model, &origin)?;
    let others = (0..stated.len()).filter(|site| stated[*site] != fitting[*site]);
    let others: Vec<usize> = others.collect();
    let together = [others.clone()].into_iter().filter(|all| all.len() > 1);
    let singles = others.iter().map(|site| vec![*site]);
    all.extend(together.chain(singles).filter_map(|sites| {
        let mut places = stated.clone();
        sites.iter().for_each(|site| places[*site] = fitting[*site]);
        let placed = records.placed(&places);
        let bodies = &placed.bodies;
        let is_once = (1..bodies.len()).all(|i| !bodies[..i].contains(&bodies[i]));
        let own: Vec<usize> = sites.iter().map(|site| records.bodies[*site]).collect();
        let some = |bodies: &[usize]| some_places(records.quantity, bodies, PLACES);
        let (name, kind) = match *bodies != records.bodies {
            true => (
                format!("records of {}", some(bodies)),
                "records of other bodies",
            ),
            false if own.len() == bodies.len() => ("sign of all records".into(), "signs"),
            false => (format!("sign at {}", some(&own)), "signs"),
        };
        is_once.then(|| Alternative {
            records: Some(placed),
            is_whole: true,
            ..Alternative::of(model, name, kind)
        })
    }));
    Ok(all)
}

/// The body and the sign of each record: as they are stated, and as they fit the run best, of measured bodies and those beside them.
fn placed(model: &Model, at: &[f64]) -> Result<[Vec<(usize, f64)>; 2]> {
    let records = model.records;
    let mut bodies = records.bodies.clone();
    let beside = records
        .bodies
        .iter()
        .flat_map(|body| [body.checked_sub(1), Some(body + 1)]);
    let mut beside: Vec<usize> = beside.flatten().collect();
    let setup = model.scene.setup()?;
    beside.retain(|body| {
        *body < super::records::places_in(&setup.simulation.chain, records.quantity)
    });
    bodies.extend(beside);
    let all = Records {
        values: Vec::new(),
        bodies,
        ..records.clone()
    };
    let of_all = Model {
        records: &all,
        ..*model
    };
    let run = of_all.records_at(at, model.local_error)?;
    let stated: Vec<(usize, f64)> = records.bodies.iter().map(|body| (*body, 1.0)).collect();
    let fitting = stated.iter().enumerate().map(|(site, own)| {
        let left = |index: usize, sign: f64| {
            let of_run = &run[records.times.len() * index..][..records.times.len()];
            let pairs = records.record(site).iter().zip(of_run);
            let known = pairs.filter(|(y, _)| y.is_finite());
            known.map(|(y, p)| (sign * y - p).powi(2)).sum::<f64>()
        };
        let mut best = (left(site, 1.0), *own);
        for (index, body) in all.bodies.iter().enumerate() {
            for sign in [1.0, -1.0] {
                let tried = left(index, sign);
                if tried < best.0 {
                    best = (tried, (*body, sign));
                }
            }
        }
        best.1
    });
    let fitting = fitting.collect();
    Ok([stated, fitting])
}

/// What was tried to explain a misfit.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Causes {
    /// What explains it, if anything does.
    pub cause: Option<Cause>,
    /// Kinds of what was tried.
    pub tried: Vec<String>,
    /// Whether work was stopped, or took too long, before all was tried.
    pub is_cut: bool,
}

/// Ends work at a time.
struct Until<'a>(&'a dyn Observer, Instant);

impl Observer for Until<'_> {
    fn cancelled(&self) -> bool {
        self.0.cancelled() || Instant::now() > self.1
    }
}

impl Causes {
    /// Of the misfit at the minimum of a search that took so long, at some bodies.
    ///
    /// # Errors
    /// Those of the chain at the minimum; alternatives whose runs fail are none.
    pub(super) fn of(
        model: &Model,
        found: &Minimum,
        bodies: &[usize],
        searched: Duration,
    ) -> Result<Causes> {
        let until = Instant::now() + PATIENCE.max(LONGER * searched);
        match causes(model, found, bodies, &Until(model.observer, until)) {
            Err(Error::Cancelled) => Ok(Causes {
                is_cut: true,
                ..Causes::default()
            }),
            found => found,
        }
    }
}

fn causes(
    model: &Model,
    found: &Minimum,
    bodies: &[usize],
    until: &dyn Observer,
) -> Result<Causes> {
    let simulation = model.simulation(&found.at)?;
    let mut all = of_scene(model, &simulation);
    all.extend(of_chain(model, &simulation, bodies));
    all.extend(of_instruments(model)?);
    let mut kinds: Vec<String> = all.iter().map(|one| one.kind.clone()).collect();
    kinds.dedup();
    let brief = &Model {
        observer: until,
        ..*model
    };
    model.observer.stage("causes", all.len() as u64);
    let beside = Beside::of(&found.columns, 1e-12);
    let score = |alternative: &Alternative| {
        let score = alternative.score(brief, found, &beside);
        model.observer.advance(1);
        score.unwrap_or(0.0)
    };
    let scores: Vec<f64> = all.par_iter().map(score).collect();
    let mut order: Vec<usize> = (0..all.len()).filter(|i| scores[*i] > 0.0).collect();
    order.sort_by(|a, b| scores[*b].total_cmp(&scores[*a]));
    // Of names of one change the first.
    order.dedup_by(|b, a| {
        let is_same = (scores[*a] - scores[*b]).abs() <= SAME * scores[*a];
        *a = if is_same { (*a).min(*b) } else { *a };
        is_same
    });
    let best = order.iter().take(FITTED).copied();
    let tried: Vec<usize> = best
        .chain((0..all.len()).filter(|i| all[*i].is_whole))
        .collect();
    model.observer.stage("fits of causes", tried.len() as u64);
    let fit = |i: &usize| {
        let fit = all[*i].fit(brief, found);
        model.observer.advance(1);
        Some((*i, fit.ok()?))
    };
    let mut ends: Vec<(usize, Minimum)> = tried.par_iter().filter_map(fit).collect();
    let is_cut = until.cancelled();
    ends.sort_by(|a, b| a.1.squares.total_cmp(&b.1.squares));
    let Some((best, fit)) = ends.first() else {
        return Ok(Causes {
            cause: None,
            tried: kinds,
            is_cut,
        });
    };
    let (alternative, own) = (&all[*best], all[*best].model(model));
    let noted = judge(&own, fit);
    let known = model.records.known() as f64;
    let inflation = (noted.gain_scale() / noted.noise.sigma).powi(2);
    let variance = fit.squares / known * inflation;
    let decrease = (found.squares - fit.squares) / variance;
    let chance = fisher_tail(decrease, [1.0, known / inflation]);
    let left = misfit(&own, fit, &own.predicted(&fit.at)?, &noted);
    let is_all = left.is_none_or(|left| left.level > RARE);
    let as_good = |end: &&(usize, Minimum)| end.1.squares - fit.squares < TOLD * variance;
    let rivals = ends[1..].iter().filter(as_good);
    let rivals: Vec<String> = rivals.map(|(i, _)| all[*i].name.clone()).collect();
    let is_named = is_all && chance * all.len() as f64 <= LEVEL && rivals.len() <= RIVALS;
    let value = |u: f64| alternative.value(model, u);
    let at = alternative.own(model).map_or(f64::NAN, |own| fit.at[own]);
    let cause = is_named.then(|| Cause {
        name: alternative.name.clone(),
        cure: match alternative.other(model) {
            Some(Other::Clock) => "`--free-time-shift` fits it".into(),
            Some(Other::Gain(_) | Other::Gains) => "`--free-gains` fits it".into(),
            _ => format!("free or correct it: {}", alternative.name),
        },
        held: value(0.0),
        free: value(at),
        explained: 1.0 - fit.squares / found.squares,
        is_all,
        rivals,
    });
    Ok(Causes {
        cause,
        tried: kinds,
        is_cut,
    })
}
