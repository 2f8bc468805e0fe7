//! What a file states beside its samples, gathered by meaning: several that agree are one, several that differ are an
//! error, and what looks like one but is none is said.

use super::Note;
use super::coordinates::{Coordinates, Evenness, Listed};
use super::meaning::Meaning::{self, *};
use super::meaning::{LIKE, TABLE, hertz, key, means, with_unit};
use super::note::spaced;
use super::options::{Label, OpenOptions};
use super::scan::NamedNumber;
use super::sidecar::Sidecar;
use super::storage::Factor;
use crate::error::InputFault;
use crate::measure::{Dimension, Length, Measure, Time, digits, quotient, symbol};

/// A statement beside samples.
#[derive(Debug, Clone)]
pub(super) struct Statement {
    pub(super) name: String,
    /// The name with what holds it.
    pub(super) place: String,
    pub(super) value: Said,
    /// A unit that stands beside the value.
    pub(super) unit: Option<String>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Said {
    Numbers(Vec<f64>),
    Text(String),
}

impl Statement {
    fn text(&self) -> String {
        match &self.value {
            Said::Text(text) => format!("{text:?}"),
            Said::Numbers(numbers) => match numbers[..] {
                [number] => digits(number),
                _ => format!("{} numbers", numbers.len()),
            },
        }
    }

    fn shown(&self) -> String {
        let unit = self.unit.as_deref().unwrap_or_default();
        format!("`{}` = {} {unit}", self.place, self.text())
            .trim_end()
            .to_owned()
    }

    fn note(&self, what: &'static str) -> Note {
        let text = format!("`{}` = {} is the {what}", self.place, self.text());
        Note::told("stated", text)
    }

    /// Its only number, as text, and the unit in a text.
    fn number(&self) -> Option<(String, Option<String>)> {
        match &self.value {
            Said::Numbers(numbers) => match numbers[..] {
                [number] => Some((format!("{number:e}"), None)),
                _ => None,
            },
            Said::Text(text) => match Label::parse(text)? {
                // Dates and times of day begin with a number, too.
                Label::Value { unit, .. }
                    if unit
                        .as_deref()
                        .is_some_and(|unit| unit.starts_with([':', '-', '/'])) =>
                {
                    None
                }
                Label::Value { value, unit } => Some((format!("{value:e}"), unit)),
                Label::Index(_) => None,
            },
        }
    }

    /// Numbers of a list, or the one.
    fn numbers(&self) -> Option<Vec<f64>> {
        match &self.value {
            Said::Numbers(numbers) => Some(numbers.clone()),
            Said::Text(text) => {
                let words = text.split(|c: char| c == ',' || c.is_whitespace());
                let words = words.filter(|word| !word.is_empty());
                let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
                numbers.filter(|numbers| !numbers.is_empty())
            }
        }
    }
}

/// All that stands beside the samples.
#[derive(Debug, Clone, Default)]
pub(super) struct Statements {
    pub(super) all: Vec<Statement>,
    /// Whether they are settings of an instrument before a table.
    pub(super) are_settings: bool,
    /// Those of outer groups that others of their name, nearer to the samples, take the place of.
    overruled: Vec<Statement>,
}

/// A step that is stated, and as what.
#[derive(Debug, Clone)]
struct Known<D: Dimension> {
    measure: Measure<D>,
    /// The unit that stands beside the number.
    unit: Option<&'static str>,
    statement: Statement,
    what: &'static str,
}

/// What is stated about an axis beside its coordinates.
#[derive(Debug)]
pub(super) struct AxisBeside<D: Dimension> {
    name: &'static str,
    what: &'static str,
    step: Option<Known<D>>,
    origin: Option<Known<D>>,
    unit: Option<String>,
    rules: Option<Evenness>,
    /// The step of the options or the sidecar, and the statements that it takes the place of.
    stated: Option<(Measure<D>, Vec<Known<D>>)>,
    /// Whether the unit is stated so, too: what the file calls a unit is none then.
    is_unit_stated: bool,
}

/// Coordinates of an axis, as a file has them.
#[derive(Debug)]
pub(super) enum Given {
    Even(Coordinates),
    Listed(Listing),
}

/// Coordinates that a file lists.
#[derive(Debug, Clone, Default)]
pub(super) struct Listing {
    pub(super) place: String,
    pub(super) values: Vec<f64>,
    /// Absolute rounding error of the values.
    pub(super) rounding: f64,
    pub(super) unit: Option<String>,
    /// The step that is stated with them.
    pub(super) step: Option<f64>,
    /// The time of the first, from which the others count.
    pub(super) start: Option<String>,
}

impl Listing {
    /// Whether another clock shows the same times: in any unit where one states none, and apart from what they count from
    /// where that is a date.
    pub(super) fn agrees(&self, other: &Listing) -> bool {
        let size = |of: &Listing| of.unit.as_deref().and_then(crate::measure::size::<Time>);
        let sizes = || Time::UNITS.iter().map(|(_, size)| *size);
        let ratios: Vec<f64> = match (size(self), size(other)) {
            (Some(own), Some(others)) => vec![others / own],
            _ => sizes().flat_map(|size| [size, 1.0 / size]).collect(),
        };
        let is_dated = self.start.is_some() || other.start.is_some();
        let [own, others] = [self, other].map(|of| match (is_dated, of.values.first()) {
            (true, Some(first)) => *first,
            _ => 0.0,
        });
        let last = self.values.last().copied().unwrap_or(0.0);
        let span = (last - self.values.first().copied().unwrap_or(0.0)).abs();
        let shows_same = |ratio: f64| {
            let tolerance = self.rounding + other.rounding * ratio + 1e-9 * span;
            let mut pairs = self.values.iter().zip(&other.values);
            pairs.all(|(a, b)| ((a - own) - (b - others) * ratio).abs() <= tolerance)
        };
        self.values.len() == other.values.len() && ratios.into_iter().any(shows_same)
    }
}

impl Statements {
    /// Whether a name is one of any statement.
    pub(super) fn is_one(&self, name: &str) -> bool {
        let of_samples = TABLE.iter().filter(|(is, ..)| *is >= Step && *is <= Offset);
        of_samples.into_iter().any(|(is, ..)| self.has(name, *is))
    }

    pub(super) fn of_all(all: Vec<Statement>) -> Statements {
        Statements {
            all,
            ..Statements::default()
        }
    }

    /// Numbers under names that `is_it` takes, with their units of length.
    pub(super) fn numbers(&self, is_it: impl Fn(&str) -> bool) -> Vec<NamedNumber> {
        let named = self.all.iter().filter(|one| is_it(&one.name));
        let found = named.filter_map(|one| {
            let (number, own) = one.number()?;
            let value: f64 = number.parse().ok()?;
            let unit = own.or_else(|| self.unit_of(&one.name));
            Some(NamedNumber {
                name: one.name.clone(),
                value,
                unit: unit.map(|unit| symbol::<Length>(&unit).map_or(unit.clone(), str::to_owned)),
                rounding: f64::EPSILON * value.abs(),
            })
        });
        found.collect()
    }

    /// Whether a name has a meaning here.
    pub(super) fn has(&self, name: &str, meaning: Meaning) -> bool {
        means(name, meaning, self.are_settings).is_some()
    }

    /// Takes a statement whose value is of its kind; whether it is one.
    pub(super) fn take(&mut self, one: Statement) -> bool {
        let is_unit = self.has(&one.name, TimeUnit) || self.has(&one.name, SpaceUnit);
        let is_number = self.is_one(&one.name) && one.number().is_some();
        let is_taken = is_unit || is_number || key(&one.name).ends_with("unit");
        if is_taken {
            self.all.push(one);
        }
        is_taken
    }

    /// Adds those of an outer group: of one name, the nearer one counts.
    pub(super) fn add_outer(&mut self, outer: Vec<Statement>) {
        for one in outer {
            let is_nearer = |other: &&Statement| key(&other.name) == key(&one.name);
            match self.all.iter().find(is_nearer) {
                None => self.all.push(one),
                Some(nearer) if nearer.value != one.value && self.is_one(&one.name) => {
                    self.overruled.push(one);
                }
                Some(_) => {}
            }
        }
    }

    fn of(&self, meaning: Meaning) -> impl Iterator<Item = &Statement> {
        self.all
            .iter()
            .filter(move |one| self.has(&one.name, meaning))
    }

    /// The numbers of a meaning.
    pub(super) fn lists(&self, meaning: Meaning) -> impl Iterator<Item = (&Statement, Vec<f64>)> {
        let numbers = |one: &Statement| one.numbers().filter(|numbers| !numbers.is_empty());
        self.of(meaning)
            .filter_map(move |one| Some((one, numbers(one)?)))
    }

    /// The texts of a meaning that are not empty.
    pub(super) fn texts<'a>(&'a self, meaning: Meaning) -> Vec<(&'a Statement, &'a str)> {
        let text = |one: &'a Statement| match &one.value {
            Said::Text(text) => Some(text.trim()).filter(|text| !text.is_empty()),
            Said::Numbers(_) => None,
        };
        self.of(meaning)
            .filter_map(|one| Some((one, text(one)?)))
            .collect()
    }

    /// The unit that is stated as `NAME_unit` of another name.
    pub(super) fn unit_of(&self, name: &str) -> Option<String> {
        let (name, _) = with_unit(name);
        let wanted = ["unit", "units"].map(|ending| format!("{}{ending}", key(name)));
        let found = self.all.iter().find(|one| wanted.contains(&key(&one.name)));
        match &found?.value {
            Said::Text(text) => Some(text.trim().to_owned()).filter(|unit| !unit.is_empty()),
            Said::Numbers(_) => None,
        }
    }

    /// What all statements of `meaning` say, each with the unit of its text, of its name or beside it.
    fn known<D: Dimension>(
        &self,
        meaning: Meaning,
        what: &'static str,
        in_unit: fn(&str, &str) -> Option<Measure<D>>,
    ) -> Vec<Known<D>> {
        let found = self.of(meaning).filter_map(|one| {
            let (number, own) = one.number()?;
            let in_name = means(&one.name, meaning, self.are_settings).flatten();
            let beside = self.unit_of(&one.name);
            let units = [own, one.unit.clone(), in_name, beside.clone()];
            let with_unit = |unit: String| in_unit(&number, &unit);
            let measure = units.into_iter().flatten().find_map(with_unit);
            let measure = measure.or_else(|| number.parse().ok().map(Measure::new))?;
            measure.value.is_finite().then(|| Known {
                measure,
                unit: beside.and_then(|unit| symbol::<D>(&unit)),
                statement: one.clone(),
                what,
            })
        });
        found.collect()
    }

    /// What is stated about times beside their coordinates, but for a step that is `stated`.
    pub(super) fn time(
        &self,
        stated: &Sidecar,
        options: &OpenOptions,
    ) -> Result<AxisBeside<Time>, InputFault> {
        let rate = |number: &str, unit: &str| {
            let rate = number.parse::<f64>().ok()? * hertz(unit)?;
            Measure::parse(&format!("{:e} s", 1.0 / rate))
        };
        let mut steps = self.known::<Time>(Rate, "sampling rate", rate);
        for known in steps.iter_mut().filter(|known| !known.measure.has_unit) {
            // A rate without a unit is one in Hz.
            let in_hertz = rate(&format!("{:e}", known.measure.value), "Hz");
            known.measure = in_hertz.unwrap_or(Measure::new(0.0));
        }
        steps.extend(self.known(Step, "sample interval", typed::<Time>));
        let origins = self.known(TimeOrigin, "time of the first sample", typed::<Time>);
        let unit = self.texts(TimeUnit);
        let beside = AxisBeside::of(["time", "sample interval"], steps, origins, unit, stated.dt)?;
        Ok(AxisBeside {
            rules: stated.dt.is_none().then(|| options.evenness("time")),
            is_unit_stated: stated.time_unit.is_some(),
            ..beside
        })
    }

    /// The same about positions.
    pub(super) fn space(
        &self,
        stated: &Sidecar,
        options: &OpenOptions,
    ) -> Result<AxisBeside<Length>, InputFault> {
        let what = "distance of the sites";
        let steps = self.known(Distance, what, typed::<Length>);
        let origins = self.known(SpaceOrigin, "position of the first site", typed::<Length>);
        let unit = self.texts(SpaceUnit);
        let beside = AxisBeside::of(["space", what], steps, origins, unit, stated.dx)?;
        Ok(AxisBeside {
            rules: stated.dx.is_none().then(|| options.evenness("space")),
            is_unit_stated: stated.space_unit.is_some(),
            ..beside
        })
    }

    /// The unit of the samples, which those beside the `name` of the array go before.
    ///
    /// # Errors
    /// Two that differ.
    pub(super) fn unit(&self, notes: &mut Vec<Note>) -> Result<Option<String>, InputFault> {
        let units = self.texts(Unit);
        let Some((first, unit)) = units.first() else {
            return Ok(None);
        };
        let differs = |(_, other): &&(&Statement, &str)| quotient(other) != quotient(unit);
        if let Some((other, _)) = units.iter().find(differs) {
            return Err(contradiction(
                "unit of the samples",
                first.shown(),
                other.shown(),
            ));
        }
        // `units` is where every reader looks.
        notes.extend((first.name != "units").then(|| first.note("unit")));
        Ok(Some((*unit).to_owned()))
    }

    /// Scale and offset of the samples `(times, sites)`, single or one for each time or site.
    ///
    /// # Errors
    /// Lists of another length, and two that differ.
    pub(super) fn scaling(
        &self,
        [n_times, n_sites]: [usize; 2],
        notes: &mut Vec<Note>,
    ) -> Result<[Factor; 2], InputFault> {
        let has_scale = self.of(Scale).next().is_some();
        let mut factor = |meaning, what, neutral| {
            // What is called an offset alone is a distance.
            let is_one = |one: &Statement| {
                meaning == Scale || has_scale || key(&one.name).starts_with("add")
            };
            let found = self.lists(meaning).filter(|(one, _)| is_one(one));
            let found: Vec<(&Statement, Vec<f64>)> = found.collect();
            let Some((first, numbers)) = found.first() else {
                return Ok(Factor::One(neutral));
            };
            if let Some((other, _)) = found.iter().find(|(_, others)| others != numbers) {
                return Err(contradiction(what, first.shown(), other.shown()));
            }
            if !["scale_factor", "add_offset"].contains(&first.name.as_str()) || numbers.len() > 1 {
                notes.push(first.note(what));
            }
            match numbers.len() {
                1 => Ok(Factor::One(numbers[0])),
                n if n == n_sites && n != n_times => Ok(Factor::Sites(numbers.clone())),
                n if n == n_times && n != n_sites => Ok(Factor::Times(numbers.clone())),
                _ => Err(InputFault::Factors {
                    place: first.place.clone(),
                    what,
                    found: numbers.len(),
                    shape: [n_times, n_sites],
                }),
            }
        };
        Ok([
            factor(Scale, "scale of the samples", 1.0)?,
            factor(Offset, "offset of the samples", 0.0)?,
        ])
    }

    /// Numbers that look like a statement about samples, or about an axis that counts, and that none is made of.
    pub(super) fn unused(&self, counts: [bool; 2]) -> Option<Note> {
        let asked = [true, counts[0], counts[1]];
        let is_like = |one: &&Statement| {
            let key = key(&one.name);
            let like = LIKE.iter().zip(asked).filter(|(_, is_asked)| *is_asked);
            let mut like = like.flat_map(|(names, _)| *names);
            one.numbers().is_some()
                && !self.is_one(&one.name)
                && like.any(|name| key.contains(name))
        };
        let found = self.all.iter().filter(is_like).chain(&self.overruled);
        let found: Vec<String> = found.map(Statement::shown).collect();
        (!found.is_empty()).then(|| unused(&found.join(", ")))
    }
}

pub(super) fn unused(statements: &str) -> Note {
    Note::doubt(
        "unused",
        format!("{statements} beside the samples is not used"),
    )
}

/// A number in a unit of `D`.
fn typed<D: Dimension>(number: &str, unit: &str) -> Option<Measure<D>> {
    Measure::parse(&format!("{number} {}", symbol::<D>(unit)?))
}

pub(super) fn contradiction(what: &'static str, first: String, second: String) -> InputFault {
    InputFault::Contradiction {
        what,
        first,
        second,
    }
}

/// Whether two steps are one: of stated ones, the digits may be few.
fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-3 * a.abs().min(b.abs())
}

/// The unit of `D` in which `number` is `known`, in its first unit.
fn unit_between<D: Dimension>(number: f64, known: f64) -> Option<&'static str> {
    let fits = |(_, size): &&(&str, f64)| is_same(number * size, known);
    D::UNITS.iter().find(fits).map(|(unit, _)| *unit)
}

impl<D: Dimension + Copy> Known<D> {
    /// Whether another statement may say the same; without a unit in any unit.
    fn agrees(&self, other: &Measure<D>) -> bool {
        let [a, b] = [&self.measure, other];
        match (a.has_unit, b.has_unit) {
            (true, false) => unit_between::<D>(b.value, a.value).is_some(),
            (false, true) => unit_between::<D>(a.value, b.value).is_some(),
            _ => is_same(a.value, b.value),
        }
    }

    fn in_unit(&self, unit: Option<&str>) -> f64 {
        let found = unit.and_then(|unit| self.measure.in_unit(unit));
        found.unwrap_or(self.measure.value)
    }
}

impl<D: Dimension + Copy> AxisBeside<D> {
    fn of(
        [name, what]: [&'static str; 2],
        mut steps: Vec<Known<D>>,
        origins: Vec<Known<D>>,
        units: Vec<(&Statement, &str)>,
        stated: Option<Measure<D>>,
    ) -> Result<Self, InputFault> {
        steps.retain(|known| known.measure.value > 0.0);
        let stated = stated.map(|step| (step, std::mem::take(&mut steps)));
        Ok(AxisBeside {
            name,
            what,
            step: agreed(what, steps)?,
            origin: agreed("first coordinate", origins)?,
            unit: units.first().map(|(_, unit)| (*unit).to_owned()),
            rules: None,
            stated,
            is_unit_stated: false,
        })
    }

    /// What the stated step takes the place of, of coordinates with this step and unit and of the statements, where that
    /// is another step.
    fn replaced(&self, even: &Coordinates) -> Option<Note> {
        /// Steps that differ by less are one, rounded.
        const SAME_STEP: f64 = 1e-6;
        let (stated, others) = self.stated.as_ref().filter(|_| !self.is_unit_stated)?;
        let unit = even.unit.clone();
        let unit = unit.or(stated.has_unit.then(|| D::UNITS[0].0.to_owned()));
        let step = stated
            .in_unit(unit.as_deref().unwrap_or_default())
            .unwrap_or(stated.value);
        let is_other = |found: &f64| (found - step).abs() > SAME_STEP * step;
        let own = even.step.filter(is_other).map(|found| {
            format!(
                "that of the coordinates, {}{}",
                digits(found),
                spaced(&even.unit)
            )
        });
        let others = others.iter().filter(|known| !known.agrees(stated));
        let others = others.map(|known| known.statement.shown());
        let all: Vec<String> = own.into_iter().chain(others).collect();
        let (step, what) = (digits(step) + &spaced(&unit), self.what);
        let text = format!(
            "the stated {what}, {step}, takes the place of {}",
            all.join(" and ")
        );
        (!all.is_empty()).then(|| Note::told("replaced", text))
    }

    /// Whether a step is stated.
    pub(super) fn has_step(&self) -> bool {
        self.step.is_some()
    }

    /// The axis with these coordinates.
    ///
    /// # Errors
    /// Coordinates that are not even, or whose step is another than the stated one.
    pub(super) fn axis(
        &self,
        given: Option<Given>,
        notes: &mut Vec<Note>,
    ) -> Result<Listed, InputFault> {
        let mut place = self.name.to_owned();
        let mut listed = match given {
            None => Listed::default(),
            Some(Given::Even(even)) => Listed::of(even),
            Some(Given::Listed(listing)) => {
                notes.extend(listing.start.map(|time| Note::Start { time }));
                place = listing.place;
                let unit = listing.unit.or(self.unit.clone());
                let step = self.step.as_ref();
                let step = step.map(|known| known.in_unit(unit.as_deref()));
                let known = (listing.rounding, listing.step.or(step));
                let listed = Coordinates::listed(self.name, &listing.values, known, self.rules);
                let mut listed = listed.map_err(|uneven| uneven.fault(self.name))?;
                listed.even.unit = unit;
                notes.extend(listed.note.take());
                listed
            }
        };
        let even = &mut listed.even;
        let is_count = even.unit.is_none()
            && even.step == Some(1.0)
            && matches!(even.origin, Some(first) if first == 0.0 || first == 1.0);
        match (&self.step, even.step) {
            (Some(known), Some(step)) if !is_count => {
                let unit = even.unit.as_deref().and_then(symbol::<D>);
                let between = unit_between::<D>(step, known.measure.value);
                let is_it = match (unit, known.measure.has_unit) {
                    (Some(unit), true) => is_same(step, known.in_unit(Some(unit))),
                    (None, true) => between.is_some(),
                    (_, false) => is_same(step, known.measure.value),
                };
                if !is_it {
                    let unit = even.unit.clone().unwrap_or_default();
                    let own = format!("steps of {} {unit}", digits(step));
                    let own = format!("{} in `{place}`", own.trim_end());
                    return Err(contradiction(self.what, own, known.statement.shown()));
                }
                if even.unit.is_none() && known.measure.has_unit {
                    even.unit = between.map(str::to_owned);
                    notes.push(known.statement.note(known.what));
                }
            }
            (Some(known), _) => {
                let unit = known.unit.unwrap_or(D::UNITS[0].0);
                let own = known.measure.has_unit.then(|| unit.to_owned());
                let of_axis = self.unit.clone();
                let of_axis = of_axis.filter(|unit| own.is_none() || symbol::<D>(unit).is_some());
                even.unit = even.unit.take().or(of_axis).or(own);
                let step = known.in_unit(even.unit.as_deref());
                even.origin =
                    even.origin
                        .filter(|first| *first != 0.0)
                        .map(|first| match is_count {
                            true => first * step,
                            false => first,
                        });
                even.step = Some(step);
                notes.push(known.statement.note(known.what));
            }
            (None, _) => {}
        }
        notes.extend(self.replaced(even));
        if *even == Coordinates::default() {
            return Ok(listed);
        }
        match (&self.origin, even.origin) {
            (Some(known), None) => {
                even.origin = Some(known.in_unit(even.unit.as_deref()));
            }
            (Some(known), Some(first)) if known.in_unit(even.unit.as_deref()) != first => {
                notes.push(unused(&known.statement.shown()));
            }
            _ => {}
        }
        Ok(listed)
    }
}

/// One of several that agree, with a unit if one has it.
fn agreed<D: Dimension + Copy>(
    what: &'static str,
    mut all: Vec<Known<D>>,
) -> Result<Option<Known<D>>, InputFault> {
    let Some(first) = all.first() else {
        return Ok(None);
    };
    if let Some(other) = all.iter().find(|other| !first.agrees(&other.measure)) {
        return Err(contradiction(
            what,
            first.statement.shown(),
            other.statement.shown(),
        ));
    }
    let best = all.iter().position(|known| known.measure.has_unit);
    Ok(Some(all.swap_remove(best.unwrap_or(0))))
}
