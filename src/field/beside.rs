//! Steps, origins and units that stand beside the samples: attributes of groups, members of structs and
//! archives.

use super::Note;
use super::coordinates::Coordinates;
use super::labelled::quantity;
use super::open::Contents;
use super::sidecar::Sidecar;
use crate::error::Result;
use crate::measure::{Dimension, Frequency, Length, Measure, Time};

/// Names of the time step, of the sampling rate, of the distance of sites.
const STEP: [&str; 4] = ["dt", "time_step", "sample_interval", "sampling_interval"];
const RATE: [&str; 6] = [
    "fs",
    "rate",
    "sampling_rate",
    "sample_rate",
    "samplerate",
    "sampling_frequency",
];
const DISTANCE: [&str; 3] = ["dx", "spacing", "channel_spacing"];
const UNIT: [&str; 2] = ["unit", "units"];

/// What stands under a name, and where.
pub(super) struct Beside {
    pub(super) place: String,
    pub(super) value: Value,
}

pub(super) enum Value {
    Number(f64),
    Text(String),
}

/// Looks up a name, whose case does not matter, beside the samples.
type Find<'a> = &'a mut dyn FnMut(&str) -> Result<Option<Beside>>;

/// Completes the axes and the unit of `contents` where neither the file's coordinates nor `stated` do.
pub(super) fn complete(contents: &mut Contents, stated: &Sidecar, find: Find) -> Result<()> {
    let counts = |axis: &Coordinates| *axis == Coordinates::default();
    if counts(&contents.time) && stated.dt.is_none() {
        let rate = first(&RATE, find)?;
        let step = match &rate {
            None => first(&STEP, find)?,
            Some(_) => None,
        };
        let period = |(_, beside): &(_, Beside)| {
            let measure = measure::<Frequency>(&beside.value)?;
            Some(measure).filter(|rate| rate.value > 0.0)
        };
        let found = match (rate, step) {
            (Some(rate), _) => match period(&rate) {
                None => None,
                Some(measure) => {
                    let unit = beside_unit(&[rate.0], find)?.unwrap_or_default();
                    let typed = Measure::parse(&format!("{} {unit}", measure.value));
                    // A rate without a unit is one in Hz.
                    let period = typed
                        .filter(|_| !measure.has_unit)
                        .unwrap_or(measure)
                        .period();
                    Some((rate.1, period.value, Some("s".to_owned()), "sampling rate"))
                }
            },
            (None, Some(step)) => axis::<Time>(step, &["time"], "time step", find)?,
            (None, None) => None,
        };
        if let Some((beside, step, unit, what)) = found {
            let origin = origin::<Time>("t0", unit.as_deref(), find)?;
            contents.time = even(origin, step, unit);
            contents.notes.push(beside.note(what));
        }
    }
    if counts(&contents.space) && stated.dx.is_none() {
        let found = match first(&DISTANCE, find)? {
            Some(step) => axis::<Length>(step, &["space"], "distance of the sites", find)?,
            None => None,
        };
        if let Some((beside, step, unit, what)) = found {
            let origin = origin::<Length>("x0", unit.as_deref(), find)?;
            contents.space = even(origin, step, unit);
            contents.notes.push(beside.note(what));
        }
    }
    if contents.unit.is_none()
        && stated.unit.is_none()
        && let Some((_, beside)) = first(&UNIT, find)?
        && let Value::Text(unit) = &beside.value
        && !unit.trim().is_empty()
    {
        let unit = unit.trim().to_owned();
        contents.quantity = contents.quantity.or(quantity("", None, Some(&unit)));
        contents.unit = Some(unit);
        contents.notes.push(beside.note("unit"));
    }
    Ok(())
}

impl Beside {
    fn note(&self, what: &'static str) -> Note {
        Note::Stated {
            place: self.place.clone(),
            text: match &self.value {
                Value::Number(number) => number.to_string(),
                Value::Text(text) => format!("{text:?}"),
            },
            what,
        }
    }
}

fn even(origin: Option<f64>, step: f64, unit: Option<String>) -> Coordinates {
    Coordinates {
        origin,
        step: Some(step),
        unit,
    }
}

/// The first of the names that is there.
fn first<'n>(names: &[&'n str], find: Find) -> Result<Option<(&'n str, Beside)>> {
    for name in names {
        if let Some(found) = find(name)? {
            return Ok(Some((name, found)));
        }
    }
    Ok(None)
}

/// A finite number, or a text that is one, with or without a unit.
fn measure<D: Dimension>(value: &Value) -> Option<Measure<D>> {
    match value {
        Value::Number(number) => Some(Measure::new(*number)),
        Value::Text(text) => Measure::read(text).ok(),
    }
    .filter(|measure: &Measure<D>| measure.value.is_finite())
}

/// The text `NAME_unit` or `NAME_units` of the first of the names.
fn beside_unit(names: &[&str], find: Find) -> Result<Option<String>> {
    for name in names {
        let both = [format!("{name}_unit"), format!("{name}_units")];
        let found = first(&[&both[0], &both[1]], find)?;
        if let Some((
            _,
            Beside {
                value: Value::Text(unit),
                ..
            },
        )) = found
        {
            return Ok(Some(unit.trim().to_owned()).filter(|unit| !unit.is_empty()));
        }
    }
    Ok(None)
}

type Step = (Beside, f64, Option<String>, &'static str);

/// A step with its unit.
fn axis<D: Dimension>(
    (name, beside): (&str, Beside),
    axis: &[&str],
    what: &'static str,
    find: Find,
) -> Result<Option<Step>> {
    let step = measure::<D>(&beside.value).filter(|step| step.value > 0.0);
    let Some(step) = step else { return Ok(None) };
    let unit = match step.has_unit {
        true => Some(D::UNITS[0].0.to_owned()),
        false => beside_unit(&[&[name], axis].concat(), find)?,
    };
    Ok(Some((beside, step.value, unit, what)))
}

/// The first coordinate, by this name, in the unit of the step; in that unit already where it states none.
fn origin<D: Dimension>(name: &str, unit: Option<&str>, find: Find) -> Result<Option<f64>> {
    let Some(beside) = find(name)? else {
        return Ok(None);
    };
    let Some(typed) = measure::<D>(&beside.value).filter(|typed| typed.value.is_finite()) else {
        return Ok(None);
    };
    let own = beside_unit(&[name], find)?.filter(|_| !typed.has_unit);
    let own = own.and_then(|own| Measure::parse(&format!("{} {own}", typed.value)));
    let typed = own.unwrap_or(typed);
    let value = typed.value;
    Ok(unit.and_then(|unit| typed.in_unit(unit)).or(Some(value)))
}
