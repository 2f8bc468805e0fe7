//! Transmission through a chain against a key of its scene.

use std::path::Path;

use rayon::prelude::*;
use serde::Serialize;

use super::chains::{Pattern, SceneTemplate};
use super::extremum::{CurvePoint, Extremum, extrema, resolved};
use super::marks::{LocalizedMark, Waves, localized_marks};
use super::members::{Known, Pair, See, StoredChains, follow};
use super::pulse::{Located, Pulse, Sense};
use crate::chain::scene::{SceneSource, Setup, Units};
use crate::observer::Observer;
use crate::sweep::SweptKey;
use crate::{Error, Result};

/// A request for transmission curves.
#[derive(Debug, Clone)]
pub struct TransmissionRequest {
    pub scene: SceneSource,
    /// The key whose numbers are the abscissa, written as for a sweep: `angle=2:90:45`.
    pub over: String,
    /// Further values of the key, such as measured ones.
    pub also: Vec<f64>,
    /// Other keys with their values; one curve per combination.
    pub vary: Vec<String>,
    /// Whether the extrema between the values are located.
    pub locate: bool,
}

/// The transmission curves of a request.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Transmission {
    pub key: String,
    pub units: Units,
    pub curves: Vec<TransmissionCurve>,
    pub failed: Vec<(String, String)>,
    #[serde(skip)]
    pub computed: usize,
}

/// The curve of one combination of the other keys.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TransmissionCurve {
    /// The other keys and their values.
    pub settings: Vec<(String, String)>,
    pub points: Vec<TransmissionPoint>,
    /// Values at which nothing arrived at the wall, or whose run failed.
    pub nothing_at: Vec<f64>,
    /// Extrema of the force on the wall, located between the values of the key.
    pub extremes: Vec<TransmissionExtremum>,
    /// Intervals of the key that may hide further ones.
    pub unresolved: Vec<[f64; 2]>,
    /// Values of the key at which the dimer carries a localized wave.
    pub localized: Vec<LocalizedMark>,
    /// Orders whose wave could not be resolved; they may be missing from `localized`.
    pub unresolved_orders: Vec<usize>,
}

/// The pulse at the wall for one value of the key.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TransmissionPoint {
    pub value: f64,
    /// Largest over smallest coefficient between bodies.
    pub stiffness_ratio: f64,
    /// Peak force on the wall; `relative_force` is relative to the homogeneous chain.
    pub peak_force: Located,
    pub relative_force: f64,
    pub relative_force_error: f64,
    /// From the impact until the force on the wall is [`super::FRONT`] of its peak.
    pub time_of_flight: Located,
    /// Bodies behind the striker times their pitch (1 in a scene without units), divided by that
    /// time.
    pub mean_speed: f64,
    /// The whole pulse at the wall.
    pub pulse: Pulse,
}

/// An extremum of the force on the wall.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TransmissionExtremum {
    pub is_maximum: bool,
    /// Half the width of the interval that brackets it.
    pub value_error: f64,
    pub point: TransmissionPoint,
}

impl TransmissionRequest {
    /// Transmission over `key`, written as for a sweep.
    pub fn new(scene: SceneSource, over: impl Into<String>) -> TransmissionRequest {
        TransmissionRequest {
            scene,
            over: over.into(),
            also: Vec::new(),
            vary: Vec::new(),
            locate: true,
        }
    }

    /// Follows the pulse to the wall for every value and combination, locates the extrema by
    /// further runs, and marks the localized ratios.
    ///
    /// Intervals between values in which the curve is not smooth are halved, up to five times, since they may hide
    /// extrema; those that stay so are named.
    ///
    /// With a directory, each chain's result is saved as soon as it is computed, and saved results
    /// are not computed again. The results depend neither on that nor on the number of threads.
    ///
    /// # Errors
    /// [`crate::Error::Request`] and [`crate::Error::Scene`] before any work;
    /// [`crate::Error::OutputInUse`] for a directory in use for something else;
    /// [`crate::Error::Paused`] or [`crate::Error::Cancelled`] when the observer cancels;
    /// [`crate::Error::Write`].
    pub fn run(&self, directory: Option<&Path>, observer: &dyn Observer) -> Result<Transmission> {
        let over = SweptKey::parse(&self.over);
        let over = over.map_err(|error| error.of_option("vary", "against"))?;
        let values = self.values(&over)?;
        let axes = self.vary.iter().map(|text| SweptKey::parse(text));
        let axes = axes.collect::<Result<Vec<SweptKey>>>()?;
        if let Some(axis) = axes.iter().find(|axis| axis.key == over.key) {
            let expected = "another key than the abscissa";
            return Err(Error::request("vary", expected, &axis.key));
        }
        let make = SceneTemplate::new(self.scene.clone())?;
        let scene = make.text()?;
        let others = crate::sweep::combinations(&axes)?.into_iter();
        let families = others.map(|settings| ChainSeries::new(&make, &over.key, settings));
        let families: Vec<ChainSeries> = families.collect();
        // All scenes are checked before any simulation.
        let of = |family| values.iter().map(move |at| ChainSeries::chain(family, *at));
        let chains = families.iter().flat_map(of);
        let chains = chains.collect::<Result<Vec<SeriesChain>>>()?;
        let known = Known::open(directory, &StoredChains::new(vec![scene], &over.key))?;
        let pairs = chains.iter().map(|(pair, ..)| pair);
        let (curves, failed, computed) = follow(pairs, &known, observer, |see| {
            let mut waves = Waves::default();
            let curves = families.iter();
            let curves = curves.map(|of| self.curve(of, &values, &mut waves, (see, observer)));
            curves.collect()
        })?;
        let units = chains.last().map(|(_, setup, _)| setup.units);
        Ok(Transmission {
            key: over.key,
            units: units.unwrap_or(Units::None),
            curves,
            failed,
            computed,
        })
    }

    /// The abscissa values, in ascending order.
    fn values(&self, over: &SweptKey) -> Result<Vec<f64>> {
        let finite = |text: &String| text.parse().ok().filter(|v: &f64| v.is_finite());
        let numbers: Option<Vec<f64>> = over.values.iter().map(finite).collect();
        let Some(mut values) = numbers else {
            let expected = "numbers, without units, for the abscissa";
            return Err(Error::request("against", expected, over.values.join(", ")));
        };
        values.extend(self.also.iter().copied().filter(|v| v.is_finite()));
        values.sort_by(f64::total_cmp);
        values.dedup();
        Ok(values)
    }

    fn curve(
        &self,
        family: &ChainSeries,
        values: &[f64],
        waves: &mut Waves,
        (see, observer): (See, &dyn Observer),
    ) -> Result<TransmissionCurve> {
        let point = |value: f64| family.point(value, see);
        let points = values.iter().map(|value| point(*value));
        let points = points.collect::<Result<Vec<Option<TransmissionPoint>>>>()?;
        let place = |at: f64, point: Option<TransmissionPoint>| CurvePoint {
            at,
            value: point.map(|p| p.relative_force),
            error: point.map_or(0.0, |p| p.relative_force_error),
        };
        let places = values.iter().zip(&points);
        let mut places: Vec<CurvePoint> = places.map(|(at, point)| place(*at, *point)).collect();
        let nothing = places.iter().filter(|place| place.value.is_none());
        let nothing_at = nothing.map(|place| place.at).collect();
        let (mut turns, mut hidden) = (Vec::new(), Vec::new());
        if self.locate {
            (places, hidden) = resolved(places, &|values| {
                let places = values.par_iter().map(|at| Ok(place(*at, point(*at)?)));
                places.collect()
            })?;
            turns = extrema(&places);
        }
        observer.stage("extremes", turns.len() as u64);
        let extremes = turns.par_iter().map(|turn| {
            let extreme = located(turn, &point);
            observer.advance(1);
            extreme
        });
        let extremes = extremes.collect::<Result<Vec<Option<TransmissionExtremum>>>>()?;
        let (localized, unresolved_orders) = localized_marks(values, waves, |value| {
            let (_, setup, pattern) = family.chain(value)?;
            Ok((setup.simulation.chain, pattern))
        })?;
        Ok(TransmissionCurve {
            settings: family.settings.clone(),
            nothing_at,
            points: points.into_iter().flatten().collect(),
            extremes: extremes.into_iter().flatten().collect(),
            unresolved: hidden,
            localized,
            unresolved_orders,
        })
    }
}

fn located(
    turn: &Extremum,
    point: &dyn Fn(f64) -> Result<Option<TransmissionPoint>>,
) -> Result<Option<TransmissionExtremum>> {
    let force = |value: f64| Ok(point(value)?.map(|p| p.relative_force));
    let Some((value, value_error)) = turn.locate(&force)? else {
        return Ok(None);
    };
    Ok(point(value)?.map(|point| TransmissionExtremum {
        is_maximum: turn.is_maximum,
        value_error,
        point,
    }))
}

/// The chains of one combination of the other keys.
struct ChainSeries<'a> {
    make: SceneTemplate,
    key: &'a str,
    settings: Vec<(String, String)>,
}

/// One of them with its reference, its scene and its pattern.
type SeriesChain = (Pair, Setup, Pattern);

impl<'a> ChainSeries<'a> {
    fn new(make: &SceneTemplate, key: &'a str, settings: Vec<(String, String)>) -> ChainSeries<'a> {
        let with =
            |make: SceneTemplate, (key, text): &(String, String)| make.with(key, text, "vary");
        ChainSeries {
            make: settings.iter().fold(make.clone(), with),
            key,
            settings,
        }
    }

    fn chain(&self, value: f64) -> Result<SeriesChain> {
        let make = self.make.with(self.key, &format!("{value:?}"), "against");
        let (setup, pattern) = (make.setup()?, make.pattern()?);
        let others = self.settings.iter();
        let others = others.map(|(key, text)| format!("{key}={text}"));
        let all = others.chain([format!("{}={value:?}", self.key)]);
        let name = all.collect::<Vec<_>>().join(", ");
        let simulation = setup.simulation.clone();
        let place = (Sense::Wall, simulation.chain.n_contacts().saturating_sub(1));
        let pair = Pair::new(&name, vec![simulation], &pattern, place, None)?;
        Ok((pair, setup, pattern))
    }

    /// The pulse at the wall; `None` if nothing arrives or a run failed.
    fn point(&self, value: f64, see: See) -> Result<Option<TransmissionPoint>> {
        let (pair, setup, pattern) = self.chain(value)?;
        let outcomes = see(&pair)?;
        let outcomes = outcomes.each_ref();
        let pulses = outcomes.map(|outcome| outcome.done()?.pulses.pulses.first());
        let [Some(&pulse), Some(reference)] = pulses else {
            return Ok(None);
        };
        let relative_force = pulse.peak_force.value / reference.peak_force.value;
        let error = |pulse: &Pulse| pulse.peak_force.error / pulse.peak_force.value;
        let bodies = setup.simulation.chain.n_sites() - 1;
        let distance = bodies as f64 * setup.pitch.unwrap_or(1.0);
        Ok(Some(TransmissionPoint {
            value,
            stiffness_ratio: pattern.stiffness_ratio(),
            peak_force: pulse.peak_force,
            relative_force,
            relative_force_error: relative_force * (error(&pulse) + error(reference)),
            time_of_flight: pulse.arrival_time,
            mean_speed: distance / pulse.arrival_time.value,
            pulse,
        }))
    }
}
