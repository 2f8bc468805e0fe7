//! What a file states beside its samples, gathered by meaning: several that agree are one, several that differ are an
//! error, and what looks like one but is none is said.

use wavecascade_formats::Value;

use super::Note;
use super::beside::{AxisBeside, Known};
use super::meaning::Meaning::{self, *};
use super::meaning::{LIKE, hertz, is_added, key, means, with_unit};
use super::note::spaced;
use super::options::{Label, OpenOptions};
use super::scan::NamedNumber;
use super::sidecar::Sidecar;
use super::storage::Factor;
use crate::error::{Fault, InputFault};
use crate::measure::{Dimension, Length, Measure, Time, digits, quotient, symbol, symbol_or};

/// A statement beside samples.
#[derive(Debug, Clone)]
pub(super) struct Statement {
    pub(super) name: String,
    /// The name with what holds it.
    pub(super) place: String,
    pub(super) value: Value,
    /// A unit that stands beside the value.
    pub(super) unit: Option<String>,
}

impl Statement {
    pub(super) fn new(name: &str, place: &str, value: Value, unit: Option<String>) -> Statement {
        let [name, place] = [name, place].map(str::to_owned);
        Statement {
            name,
            place,
            value,
            unit,
        }
    }

    fn text(&self) -> String {
        match (self.value.text(), self.numbers().as_deref()) {
            (Some(text), _) => format!("{text:?}"),
            (None, Some([number])) => digits(*number),
            (None, numbers) => format!("{} numbers", numbers.map_or(0, <[f64]>::len)),
        }
    }

    pub(super) fn shown(&self) -> String {
        format!("`{}` = {}{}", self.place, self.text(), spaced(&self.unit))
    }

    pub(super) fn note(&self, what: &'static str) -> Note {
        let text = format!("`{}` = {} is the {what}", self.place, self.text());
        Note::told("stated", text)
    }

    /// Its only number, as text, and the unit in a text.
    fn number(&self) -> Option<(String, Option<String>)> {
        let Some(text) = self.value.text() else {
            return Some((format!("{:e}", self.value.number()?), None));
        };
        let Label::Value { value, unit } = Label::parse(text)? else {
            return None;
        };
        // Dates and times of day begin with a number, too.
        let is_date = |unit: &String| unit.starts_with([':', '-', '/']);
        let is_number = !unit.as_ref().is_some_and(is_date);
        is_number.then(|| (format!("{value:e}"), unit))
    }

    /// Numbers of a list, or the one.
    fn numbers(&self) -> Option<Vec<f64>> {
        let Some(text) = self.value.text() else {
            return self.value.numbers();
        };
        let words = text.split(|c: char| c == ',' || c.is_whitespace());
        let words = words.filter(|word| !word.is_empty());
        words.map(|word| word.parse().ok()).collect()
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

impl Statements {
    /// Whether a name is one of any statement.
    pub(super) fn is_one(&self, name: &str) -> bool {
        let of_axes = [TimeOrigin, SpaceOrigin, TimeUnit, SpaceUnit];
        let mut all = [Step, Rate, Distance, Unit, Scale, Offset]
            .into_iter()
            .chain(of_axes);
        all.any(|meaning| self.has(name, meaning))
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
                unit: unit.map(|unit| symbol_or::<Length>(&unit)),
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
                Some(nearer) if nearer.text() != one.text() && self.is_one(&one.name) => {
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
    pub(super) fn texts(&self, meaning: Meaning) -> Vec<(&Statement, &str)> {
        self.of(meaning)
            .filter_map(|one| Some((one, one.value.text()?)))
            .collect()
    }

    /// The unit that is stated as `NAME_unit` of another name.
    pub(super) fn unit_of(&self, name: &str) -> Option<String> {
        let (name, _) = with_unit(name);
        let wanted = ["unit", "units"].map(|ending| format!("{}{ending}", key(name)));
        let found = self.all.iter().find(|one| wanted.contains(&key(&one.name)));
        Some(found?.value.text()?.to_owned())
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
            let units = [&own, &one.unit, &in_name, &beside];
            let with_unit = |unit: &Option<String>| in_unit(&number, unit.as_ref()?);
            let measure = units.into_iter().find_map(with_unit);
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

    /// What is stated about times beside their coordinates; a step and a unit that are `stated` go before.
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
        let what = "sample interval";
        steps.extend(self.known(Step, what, typed::<Time>));
        AxisBeside::of(
            ["time", what],
            (steps, stated.dt),
            self.known(TimeOrigin, "time of the first sample", typed::<Time>),
            (self.texts(TimeUnit), stated.time_unit.is_some()),
            options.evenness("time"),
        )
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
        let unit = (self.texts(SpaceUnit), stated.space_unit.is_some());
        let rules = options.evenness("space");
        AxisBeside::of(["space", what], (steps, stated.dx), origins, unit, rules)
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
            let what = "unit of the samples";
            return Err(contradiction(what, first.shown(), other.shown()));
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
            let is_one = |one: &Statement| meaning == Scale || has_scale || is_added(&one.name);
            let found = self.lists(meaning).filter(|(one, _)| is_one(one));
            let found: Vec<(&Statement, Vec<f64>)> = found.collect();
            let Some((first, numbers)) = found.first() else {
                return Ok(Factor::one(neutral));
            };
            if let Some((other, _)) = found.iter().find(|(_, others)| others != numbers) {
                return Err(contradiction(what, first.shown(), other.shown()));
            }
            if !["scale_factor", "add_offset"].contains(&first.name.as_str()) || numbers.len() > 1 {
                notes.push(first.note(what));
            }
            match numbers.len() {
                1 => Ok(Factor::one(numbers[0])),
                n if n == n_sites && n != n_times => Ok(Factor::new(numbers.clone(), [0, 1])),
                n if n == n_times && n != n_sites => Ok(Factor::new(numbers.clone(), [1, 0])),
                found => {
                    let each = format!("one for each of {n_times} times or of {n_sites} sites");
                    let found = format!("{found} numbers in `{}`", first.place);
                    let advice = "correct the file, or save the samples apart";
                    Err(Fault::expected(format!("one {what}, or {each}"), found, advice).into())
                }
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

/// Two statements about the samples that differ.
pub(super) fn contradiction(what: &'static str, first: String, second: String) -> InputFault {
    let advice = match what {
        "sample interval" => "state the right one with `--dt` or `--rate`",
        "distance of the sites" => "state the right one with `--dx`",
        "clock" => "keep one of them; of a table, name the column with `--time-column`",
        "unit of the samples" => "state the right one with `--unit`",
        _ => "correct the file, or save the samples apart",
    };
    let found = format!("{first} and {second}");
    Fault::expected(format!("one {what}"), found, advice).into()
}
