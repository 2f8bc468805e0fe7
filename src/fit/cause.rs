//! Why a chain does not explain records: a number that the fit holds, or an end, named where it explains what is left.
//!
//! Each alternative is tried by its score: the share of the residual that its derivative, beside those of the unknowns,
//! explains. The chain is then fitted again with each of the best ones free.
//!
//! Source: C. R. Rao, Proc. Camb. Phil. Soc. 44 (1948) 50 (score tests).

use rayon::prelude::*;
use serde::Serialize;

use super::model::Model;
use super::result::{has_misfit, judge};
use super::solver::{Beside, Minimum, dot, minimize};
use crate::chain::scene::{SceneSource, Setting};
use crate::chain::{Ends, Law, Laws, Scheme, Simulation};
use crate::field::Quantity;
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

/// One number of a chain or of its records that a scene fixes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Freed {
    Dashpot,
    Tangent,
    Drag,
    Exponent,
    Speeds,
    Coefficients,
    Mass(usize),
    Contact(usize),
    /// Of a record.
    Gain(usize),
    /// By how much the records are late.
    Clock,
}

/// A number as a coordinate: in units of its own, or the logarithm of a factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extra {
    freed: Freed,
    /// Of its coordinate.
    unit: f64,
    base: f64,
}

impl Extra {
    fn of(freed: Freed, simulation: &Simulation, step: f64) -> Extra {
        let chain = &simulation.chain;
        let time = simulation.contact_time(simulation.speed());
        let mass = chain.mass.iter().sum::<f64>() / chain.n_sites() as f64;
        let losses = chain.losses;
        let (unit, base) = match freed {
            Freed::Dashpot => (mass / time, losses.dashpot),
            Freed::Tangent => (time, losses.tangent),
            Freed::Drag => (mass / time, losses.drag),
            Freed::Exponent => (1.0, exponent(chain.law.of(0)).unwrap_or(0.0)),
            Freed::Clock => (step, 0.0),
            _ => (1.0, 1.0),
        };
        Extra { freed, unit, base }
    }

    fn is_factor(&self) -> bool {
        let factors = [Freed::Speeds, Freed::Coefficients];
        factors.contains(&self.freed)
            || matches!(
                self.freed,
                Freed::Mass(_) | Freed::Contact(_) | Freed::Gain(_)
            )
    }

    pub fn bounds(&self) -> [f64; 2] {
        match self.freed {
            Freed::Exponent => [1.0 - self.base, f64::INFINITY],
            Freed::Dashpot | Freed::Tangent | Freed::Drag => {
                [-self.base / self.unit, f64::INFINITY]
            }
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    fn value(&self, u: f64) -> f64 {
        match self.is_factor() {
            true => u.exp(),
            false => self.base + self.unit * u,
        }
    }

    pub fn set(&self, simulation: &mut Simulation, u: f64) {
        let (value, speed) = (self.value(u), simulation.speed());
        let chain = &mut simulation.chain;
        match self.freed {
            Freed::Dashpot => chain.losses.dashpot = value.max(0.0),
            Freed::Tangent => chain.losses.tangent = value.max(0.0),
            Freed::Drag => chain.losses.drag = value.max(0.0),
            Freed::Exponent => {
                // At the overlap of a body that flies against the contact the force stays what it is.
                let masses: f64 = chain.mass.iter().sum();
                let energy = 0.5 * masses / chain.n_sites() as f64 * speed * speed;
                for coefficient in &mut chain.coefficient {
                    let overlap =
                        ((self.base + 1.0) * energy / *coefficient).powf(1.0 / (self.base + 1.0));
                    *coefficient *= overlap.powf(self.base - value);
                }
                chain.law = Laws::from(Law::Power { exponent: value });
            }
            Freed::Speeds => simulation.velocity.iter_mut().for_each(|v| *v *= value),
            Freed::Coefficients => chain.coefficient.iter_mut().for_each(|c| *c *= value),
            Freed::Mass(body) => chain.mass[body] *= value,
            Freed::Contact(contact) => chain.coefficient[contact] *= value,
            Freed::Gain(_) | Freed::Clock => {}
        }
        if simulation.chain.losses.any() && !simulation.scheme.takes_losses() {
            simulation.scheme = Scheme::RungeKutta;
        }
    }

    /// By how much it makes the records late.
    pub fn shift(&self, u: f64) -> f64 {
        if self.freed == Freed::Clock {
            self.value(u)
        } else {
            0.0
        }
    }

    /// What it makes of the records.
    pub fn scale(&self, records: &mut [f64], times: usize, u: f64) {
        if let Freed::Gain(site) = self.freed {
            let record = &mut records[times * site..times * (site + 1)];
            record.iter_mut().for_each(|value| *value *= u.exp());
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

/// What is tried: a number, or another end.
struct Alternative {
    name: String,
    extra: Option<Extra>,
    scene: Option<SceneSource>,
}

impl Alternative {
    fn model<'a>(&'a self, model: &Model<'a>) -> Model<'a> {
        Model {
            scene: self.scene.as_ref().unwrap_or(model.scene),
            extra: self.extra,
            ..*model
        }
    }

    /// A point of the model as one of its own.
    fn point(&self, model: &Model, at: &[f64]) -> Vec<f64> {
        let mut point = at.to_vec();
        if self.extra.is_some() {
            point.insert(model.moved(), 0.0);
        }
        point
    }

    /// The derivative of the records along it, or by how much they differ.
    fn change(&self, model: &Model, found: &Minimum) -> Result<Vec<f64>> {
        let own = self.model(model);
        let point = self.point(model, &found.at);
        let change = match self.extra {
            Some(_) => own.column(&point, model.moved())?,
            None => {
                let pairs = own.predicted(&point)?.into_iter();
                let pairs = pairs.zip(model.predicted(&found.at)?);
                pairs.map(|(a, b)| a - b).collect()
            }
        };
        let mut change = model.records.masked(change);
        change.resize(found.residual.len(), 0.0);
        Ok(change)
    }
}

/// All that can be tried of a chain and its records.
fn alternatives(model: &Model, at: &[f64], bodies: &[usize]) -> Result<Vec<Alternative>> {
    let simulation = model.simulation(at)?;
    let chain = &simulation.chain;
    let is_free = |name: &str| model.keys.iter().any(|key| key.name == name);
    let mut all: Vec<(String, Freed)> = Vec::new();
    let named = [
        ("dashpot", Freed::Dashpot),
        ("tangent", Freed::Tangent),
        ("drag", Freed::Drag),
    ];
    all.extend(
        named
            .into_iter()
            .filter(|(name, _)| !is_free(name))
            .map(|(name, freed)| (name.into(), freed)),
    );
    if chain.law.only().is_some_and(|law| exponent(law).is_some()) && !is_free("exponent") {
        all.push(("exponent of the law".into(), Freed::Exponent));
    }
    if simulation.drive.is_none() && simulation.velocity.iter().any(|v| *v != 0.0) {
        all.push(("speed at the start".into(), Freed::Speeds));
    }
    all.push(("coefficients of all contacts".into(), Freed::Coefficients));
    let near = |count: usize| {
        let mut places: Vec<usize> = (0..count).collect();
        places.sort_by_key(|place| bodies.iter().map(|body| body.abs_diff(*place)).min());
        places.truncate(PLACES);
        places.sort_unstable();
        places
    };
    let masses = near(chain.n_sites()).into_iter();
    all.extend(masses.map(|body| (format!("mass of body {body}"), Freed::Mass(body))));
    let contacts = near(chain.n_contacts()).into_iter();
    all.extend(contacts.map(|j| {
        let name = match chain.ends {
            Ends::Periodic => format!("coefficient of contact {j}"),
            _ if j + 1 == chain.n_sites() => "coefficient of the wall".into(),
            _ => format!("coefficient between bodies {j} and {}", j + 1),
        };
        (name, Freed::Contact(j))
    }));
    if !model.nuisances.gains && model.records.bodies.len() > 1 {
        let place = if model.records.quantity == Quantity::Force {
            "contact"
        } else {
            "body"
        };
        let gains = model.records.bodies.iter().enumerate();
        all.extend(
            gains.map(|(site, body)| (format!("gain at {place} {body}"), Freed::Gain(site))),
        );
    }
    if !model.nuisances.shift {
        all.push(("clock of the records".into(), Freed::Clock));
    }
    let numbers = all.into_iter().map(|(name, freed)| Alternative {
        name,
        extra: Some(Extra::of(freed, &simulation, model.records.step())),
        scene: None,
    });
    let mut found: Vec<Alternative> = numbers.collect();
    for (is_other, end) in [
        (chain.ends == Ends::Free, "wall"),
        (chain.ends == Ends::Wall, "free"),
    ] {
        let scene = model.scene.with([Setting::new("ends", end, "ends")]);
        let has_contacts = |scene: &SceneSource| {
            // Of forces the last contact may be measured.
            let count = scene
                .setup()
                .map_or(0, |setup| setup.simulation.chain.n_contacts());
            model.records.quantity != Quantity::Force
                || model.records.bodies.iter().all(|j| *j < count)
        };
        if is_other && scene.setup().is_ok() && has_contacts(&scene) {
            found.push(Alternative {
                name: format!("ends = \"{end}\""),
                extra: None,
                scene: Some(scene),
            });
        }
    }
    Ok(found)
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
    let is_tried = |(rank, i): &(usize, usize)| *rank < FITTED || all[*i].extra.is_none();
    let tried: Vec<usize> = order
        .into_iter()
        .enumerate()
        .filter(is_tried)
        .map(|(_, i)| i)
        .collect();
    let fits: Vec<Result<Minimum>> = tried
        .par_iter()
        .map(|i| minimize(&all[*i].model(model), &all[*i].point(model, &found.at)))
        .collect();
    let mut ends: Vec<(usize, Minimum)> = Vec::new();
    for (i, fit) in tried.into_iter().zip(fits) {
        match fit {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(_) => {}
            Ok(fit) => ends.push((i, fit)),
        }
    }
    ends.sort_by(|a, b| a.1.squares.total_cmp(&b.1.squares));
    let Some((best, fit)) = ends.first() else {
        return Ok(None);
    };
    let own = all[*best].model(model);
    let noted = judge(&own, fit);
    let known = model.records.known() as f64;
    let inflation = (noted.gain_scale() / noted.noise.sigma).powi(2);
    let variance = fit.squares / known * inflation;
    let chance = fisher_tail(
        (found.squares - fit.squares) / variance,
        [1.0, known / inflation],
    );
    let explained = 1.0 - fit.squares / found.squares;
    let is_all = !has_misfit(&own, fit)?;
    let rivals = ends[1..]
        .iter()
        .filter(|(_, other)| other.squares - fit.squares < TOLD * variance);
    let rivals: Vec<String> = rivals.map(|(i, _)| all[*i].name.clone()).collect();
    let is_little = chance * all.len() as f64 > LEVEL || !(is_all || explained > LEAST);
    if is_little || rivals.len() > RIVALS {
        return Ok(None);
    }
    let value = |u: f64| all[*best].extra.map_or(f64::NAN, |extra| extra.value(u));
    Ok(Some(Cause {
        name: all[*best].name.clone(),
        held: value(0.0),
        free: value(fit.at.get(model.moved()).copied().unwrap_or(0.0)),
        explained,
        is_all,
        rivals,
    }))
}
