//! Why a chain does not explain records: a number that the fit holds, or an end, named where it explains what is left.
//!
//! Each alternative is tried by its score: the share of the residual that its derivative, beside those of the unknowns,
//! explains. The chain is then fitted again with each of the best ones free.
//!
//! Source: C. R. Rao, Proc. Camb. Phil. Soc. 44 (1948) 50 (score tests).

use rayon::prelude::*;
use serde::Serialize;

use super::model::{Model, Other};
use super::result::judge;
use super::shown::place;
use super::solver::{Beside, Minimum, dot, minimize};
use super::verdict::misfit;
use crate::chain::scene::{SceneSource, Setting};
use crate::chain::{Ends, Law, Laws, Scheme, Simulation};
use crate::numeric::fisher_tail;
use crate::{Error, Result};

/// Alternatives that are fitted.
const FITTED: usize = 5;

/// Bodies, and contacts, that are tried, at most.
const PLACES: usize = 48;

/// Share of a derivative beside those of the unknowns below which it is one of them.
const OWN: f64 = 1e-3;

/// Level at which the decrease of the squares is no chance, for all alternatives together.
const LEVEL: f64 = 1e-3;

/// Share of what is left that a cause must explain, unless it leaves noise alone.
const LEAST: f64 = 0.5;

/// Decrease of the squares, in variances of the noise, by which the best alternative is told from another one.
const TOLD: f64 = 10.0;

/// Alternatives that explain as much, from which on none is named.
const RIVALS: usize = 2;

/// What explains a misfit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cause {
    /// A key of the scene, or what it is of: `tangent`, `mass of body 6`, `ends = "wall"`.
    pub name: String,
    /// What it is in the scene and with the best fit; the factor of masses, coefficients, speeds and gains. NaN for ends.
    pub held: f64,
    pub free: f64,
    /// Share of the squares of what is left that goes.
    pub explained: f64,
    /// Whether noise alone is left.
    pub is_all: bool,
    /// Others that explain as much.
    pub rivals: Vec<String>,
}

/// One number of a chain that a scene fixes.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Number {
    Dashpot,
    Tangent,
    Drag,
    Exponent,
    Speeds,
    Coefficients,
    Mass(usize),
    Contact(usize),
}

/// A number as a coordinate: in units of its own, or the logarithm of a factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Held {
    number: Number,
    /// Of its coordinate; `None` for a factor.
    unit: Option<f64>,
    base: f64,
    least: f64,
}

impl Held {
    fn of(number: Number, simulation: &Simulation) -> Held {
        let chain = &simulation.chain;
        let time = simulation.contact_time(simulation.speed());
        let mass = chain.mass.iter().sum::<f64>() / chain.n_sites() as f64;
        let losses = chain.losses;
        let (unit, base, least) = match number {
            Number::Dashpot => (Some(mass / time), losses.dashpot, 0.0),
            Number::Tangent => (Some(time), losses.tangent, 0.0),
            Number::Drag => (Some(mass / time), losses.drag, 0.0),
            Number::Exponent => (Some(1.0), exponent(chain.law.of(0)).unwrap_or(0.0), 1.0),
            _ => (None, 1.0, f64::NEG_INFINITY),
        };
        Held {
            number,
            unit,
            base,
            least,
        }
    }

    pub fn bounds(&self) -> [f64; 2] {
        let unit = self.unit.unwrap_or(1.0);
        [(self.least - self.base) / unit, f64::INFINITY]
    }

    fn value(&self, u: f64) -> f64 {
        match self.unit {
            None => u.exp(),
            Some(unit) => self.base + unit * u,
        }
    }

    pub fn set(&self, simulation: &mut Simulation, u: f64) {
        let (value, speed) = (self.value(u), simulation.speed());
        let chain = &mut simulation.chain;
        match self.number {
            Number::Dashpot => chain.losses.dashpot = value.max(0.0),
            Number::Tangent => chain.losses.tangent = value.max(0.0),
            Number::Drag => chain.losses.drag = value.max(0.0),
            Number::Exponent => {
                // At the overlap of a body that flies against the contact the force stays what it is.
                let masses: f64 = chain.mass.iter().sum();
                let energy = 0.5 * masses / chain.n_sites() as f64 * speed * speed;
                let power = self.base + 1.0;
                for coefficient in &mut chain.coefficient {
                    let overlap = (power * energy / *coefficient).powf(1.0 / power);
                    *coefficient *= overlap.powf(self.base - value);
                }
                chain.law = Laws::from(Law::Power { exponent: value });
            }
            Number::Speeds => simulation.velocity.iter_mut().for_each(|v| *v *= value),
            Number::Coefficients => chain.coefficient.iter_mut().for_each(|c| *c *= value),
            Number::Mass(body) => chain.mass[body] *= value,
            Number::Contact(contact) => chain.coefficient[contact] *= value,
        }
        if simulation.chain.losses.any() && !simulation.scheme.takes_losses() {
            simulation.scheme = Scheme::RungeKutta;
        }
    }
}

fn exponent(law: &Law) -> Option<f64> {
    match law {
        Law::Hertz => Some(1.5),
        Law::Power { exponent } => Some(*exponent),
        _ => None,
    }
}

/// What is tried: one more unknown, or another end.
struct Alternative {
    name: String,
    others: Vec<Other>,
    scene: Option<SceneSource>,
}

impl Alternative {
    fn model<'a>(&'a self, model: &Model<'a>) -> Model<'a> {
        Model {
            scene: self.scene.as_ref().unwrap_or(model.scene),
            others: &self.others,
            ..*model
        }
    }

    /// A point of the model as one of its own.
    fn point(&self, model: &Model, at: &[f64]) -> Vec<f64> {
        let mut point = at.to_vec();
        point.resize(self.model(model).unknowns(), 0.0);
        point
    }

    /// The derivative of the records along it, or by how much they differ.
    fn change(&self, model: &Model, found: &Minimum) -> Result<Vec<f64>> {
        let (own, point) = (self.model(model), self.point(model, &found.at));
        let mut change = match self.scene {
            None => own.column(&point, model.unknowns())?,
            Some(_) => {
                let pairs = own.predicted(&point)?.into_iter();
                let pairs = pairs.zip(model.predicted(&found.at)?);
                model.records.masked(pairs.map(|(a, b)| a - b))
            }
        };
        change.resize(found.residual.len(), 0.0);
        Ok(change)
    }

    /// The value of the unknown at a coordinate; NaN of an end.
    fn value(&self, model: &Model, u: f64) -> f64 {
        match self.others.last() {
            _ if self.scene.is_some() => f64::NAN,
            Some(Other::Clock) => u * model.records.step(),
            Some(Other::Gain(_) | Other::Gains) => u.exp(),
            Some(Other::Held(held)) => held.value(u),
            None => f64::NAN,
        }
    }
}

/// All that can be tried of a chain and its records.
fn alternatives(model: &Model, at: &[f64], bodies: &[usize]) -> Result<Vec<Alternative>> {
    let simulation = model.simulation(at)?;
    let chain = &simulation.chain;
    let records = model.records;
    let held = |number| Other::Held(Held::of(number, &simulation));
    let is_held = |name: &str| model.keys.iter().all(|key| key.name != name);
    let has_exponent = chain.law.only().is_some_and(|law| exponent(law).is_some());
    let flies = simulation.drive.is_none() && simulation.velocity.iter().any(|v| *v != 0.0);
    let exponent = has_exponent && is_held("exponent");
    let of_chain = [
        (is_held("dashpot"), "dashpot", Number::Dashpot),
        (is_held("tangent"), "tangent", Number::Tangent),
        (is_held("drag"), "drag", Number::Drag),
        (exponent, "exponent of the law", Number::Exponent),
        (flies, "speed at the start", Number::Speeds),
        (true, "coefficients of all contacts", Number::Coefficients),
    ];
    let of_chain = of_chain.into_iter().filter(|(is_held, ..)| *is_held);
    let of_chain = of_chain.map(|(_, name, number)| (name.to_owned(), held(number)));
    let mut all: Vec<(String, Other)> = of_chain.collect();
    let near = |count: usize| {
        let mut places: Vec<usize> = (0..count).collect();
        places.sort_by_key(|place| bodies.iter().map(|body| body.abs_diff(*place)).min());
        places.truncate(PLACES);
        places.sort_unstable();
        places.into_iter()
    };
    let mass = |body| (format!("mass of body {body}"), held(Number::Mass(body)));
    all.extend(near(chain.n_sites()).map(mass));
    all.extend(near(chain.n_contacts()).map(|j| {
        let name = match chain.ends {
            Ends::Periodic => format!("coefficient of contact {j}"),
            _ if j + 1 == chain.n_sites() => "coefficient of the wall".into(),
            _ => format!("coefficient between bodies {j} and {}", j + 1),
        };
        (name, held(Number::Contact(j)))
    }));
    let is_gain = |other: &Other| matches!(other, Other::Gain(_));
    let has_gains = model.others.iter().any(is_gain);
    if !has_gains && records.bodies.len() > 1 {
        let place = place(records.quantity);
        let gain = |(site, body)| (format!("gain at {place} {body}"), Other::Gain(site));
        all.extend(records.bodies.iter().enumerate().map(gain));
        all.push(("gain of all records".into(), Other::Gains));
    }
    if !model.others.contains(&Other::Clock) {
        all.push(("clock of the records".into(), Other::Clock));
    }
    let numbers = all.into_iter().map(|(name, other)| Alternative {
        name,
        others: [model.others, &[other]].concat(),
        scene: None,
    });
    let end = match chain.ends {
        Ends::Free => Some("wall"),
        Ends::Wall => Some("free"),
        _ => None,
    };
    let other = end.and_then(|end| {
        let scene = model.scene.with([Setting::new("ends", end, "ends")]);
        // Of forces the last contact may be measured.
        records.check(&scene.setup().ok()?).ok()?;
        Some(Alternative {
            name: format!("ends = \"{end}\""),
            others: model.others.to_vec(),
            scene: Some(scene),
        })
    });
    Ok(numbers.chain(other).collect())
}

/// What explains the misfit of a fit at its minimum; `None` where nothing that was tried does.
///
/// # Errors
/// [`Error::Cancelled`]; alternatives whose runs fail are none.
pub(super) fn cause(model: &Model, found: &Minimum, bodies: &[usize]) -> Result<Option<Cause>> {
    let all = alternatives(model, &found.at, bodies)?;
    model.observer.stage("causes", all.len() as u64);
    let beside = Beside::of(&found.columns, 1e-12);
    let residual = beside.rest(&found.residual);
    let score = |alternative: &Alternative| -> Result<f64> {
        let change = match alternative.change(model, found) {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(_) => return Ok(0.0),
            Ok(change) => change,
        };
        let rest = beside.rest(&change);
        model.observer.advance(1);
        let left = dot(&rest, &rest);
        if left.is_nan() || left <= OWN * OWN * dot(&change, &change) {
            return Ok(0.0);
        }
        Ok(dot(&rest, &residual).powi(2) / (left * dot(&residual, &residual)))
    };
    let scores: Result<Vec<f64>> = all.par_iter().map(score).collect();
    let scores = scores?;
    let mut order: Vec<usize> = (0..all.len()).filter(|i| scores[*i] > 0.0).collect();
    order.sort_by(|a, b| scores[*b].total_cmp(&scores[*a]));
    // Another end is no small change, which a score would tell.
    let best = &order[..FITTED.min(order.len())];
    let is_tried = |i: &&usize| best.contains(i) || all[**i].scene.is_some();
    let tried: Vec<&usize> = order.iter().filter(is_tried).collect();
    let fit = |i: &&usize| {
        let tried = &all[**i];
        match minimize(&tried.model(model), &tried.point(model, &found.at)) {
            Err(Error::Cancelled) => Err(Error::Cancelled),
            fit => Ok(fit.ok().map(|fit| (**i, fit))),
        }
    };
    let fits: Result<Vec<Option<(usize, Minimum)>>> = tried.par_iter().map(fit).collect();
    let mut ends: Vec<(usize, Minimum)> = fits?.into_iter().flatten().collect();
    ends.sort_by(|a, b| a.1.squares.total_cmp(&b.1.squares));
    let Some((best, fit)) = ends.first() else {
        return Ok(None);
    };
    let own = all[*best].model(model);
    let noted = judge(&own, fit);
    let known = model.records.known() as f64;
    let inflation = (noted.gain_scale() / noted.noise.sigma).powi(2);
    let variance = fit.squares / known * inflation;
    let lower = (found.squares - fit.squares) / variance;
    let chance = fisher_tail(lower, [1.0, known / inflation]);
    let explained = 1.0 - fit.squares / found.squares;
    let is_all = misfit(&own, fit, &own.predicted(&fit.at)?, &noted.noise).is_none();
    let rivals = ends[1..].iter();
    let rivals = rivals.filter(|(_, other)| other.squares - fit.squares < TOLD * variance);
    let rivals: Vec<String> = rivals.map(|(i, _)| all[*i].name.clone()).collect();
    let is_little = chance * all.len() as f64 > LEVEL || !(is_all || explained > LEAST);
    if is_little || rivals.len() > RIVALS {
        return Ok(None);
    }
    Ok(Some(Cause {
        name: all[*best].name.clone(),
        held: all[*best].value(model, 0.0),
        free: all[*best].value(model, fit.at.last().copied().unwrap_or(0.0)),
        explained,
        is_all,
        rivals,
    }))
}
