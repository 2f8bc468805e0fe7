//! What is stated about an axis, and the axis that it makes of the coordinates.

use super::Note;
use super::coordinates::{Coordinates, Evenness, Listed};
use super::note::spaced;
use super::statements::{Statement, contradiction, unused};
use crate::error::InputFault;
use crate::measure::{Dimension, Measure, Time, digits, symbol};

/// A step that is stated, and as what.
#[derive(Debug, Clone)]
pub(super) struct Known<D: Dimension> {
    pub(super) measure: Measure<D>,
    /// The unit that stands beside the number.
    pub(super) unit: Option<&'static str>,
    pub(super) statement: Statement,
    pub(super) what: &'static str,
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
    fn agrees(&self, other: &Listing) -> bool {
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

    /// Of several that agree the one that says more: a date alone agrees with every time of its day.
    ///
    /// # Errors
    /// Two that differ.
    pub(super) fn best(all: Vec<Listing>) -> Result<Option<Listing>, InputFault> {
        let Some(mut best) = all.first().cloned() else {
            return Ok(None);
        };
        for other in &all[1..] {
            if !all[0].agrees(other) {
                let [first, other] = [&all[0], other].map(|of| {
                    let end = |end: Option<&f64>| digits(end.copied().unwrap_or(f64::NAN));
                    let (first, last) = (end(of.values.first()), end(of.values.last()));
                    format!("`{}` from {first} to {last}{}", of.place, spaced(&of.unit))
                });
                return Err(contradiction("clock", first, other));
            }
            let is_finer = best.unit == other.unit && other.rounding < best.rounding;
            if best.unit.is_none() && other.unit.is_some() || is_finer {
                best = other.clone();
            }
        }
        Ok(Some(best))
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
    /// Of steps, origins and units that a file states; a step and a unit of the options or the sidecar go before.
    pub(super) fn of(
        [name, what]: [&'static str; 2],
        (mut steps, stated): (Vec<Known<D>>, Option<Measure<D>>),
        origins: Vec<Known<D>>,
        (units, is_unit_stated): (Vec<(&Statement, &str)>, bool),
        rules: Evenness,
    ) -> Result<Self, InputFault> {
        steps.retain(|known| known.measure.value > 0.0);
        let stated = stated.map(|step| (step, std::mem::take(&mut steps)));
        Ok(AxisBeside {
            name,
            what,
            step: agreed(what, steps)?,
            origin: agreed("first coordinate", origins)?,
            unit: units.first().map(|(_, unit)| (*unit).to_owned()),
            rules: stated.is_none().then_some(rules),
            stated,
            is_unit_stated,
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
        let own = even.step.filter(is_other);
        let own = own.map(|found| digits(found) + &spaced(&even.unit));
        let own = own.map(|found| format!("that of the coordinates, {found}"));
        let others = others.iter().filter(|known| !known.agrees(stated));
        let others = others.map(|known| known.statement.shown());
        let all: Vec<String> = own.into_iter().chain(others).collect();
        let (step, what, others) = (digits(step), self.what, all.join(" and "));
        let step = step + &spaced(&unit);
        let text = format!("the stated {what}, {step}, takes the place of {others}");
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
                notes.extend(listing.start.map(|time| Note::start(&time)));
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
                    let step = digits(step) + &spaced(&even.unit);
                    let own = format!("steps of {step} in `{place}`");
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
                let size = if is_count { step } else { 1.0 };
                let origin = even.origin.filter(|first| *first != 0.0);
                even.origin = origin.map(|first| first * size);
                even.step = Some(step);
                notes.push(known.statement.note(known.what));
            }
            (None, _) => {}
        }
        notes.extend(self.replaced(even));
        if *even == Coordinates::default() {
            return Ok(listed);
        }
        if let Some(known) = &self.origin {
            let stated = known.in_unit(even.unit.as_deref());
            if *even.origin.get_or_insert(stated) != stated {
                notes.push(unused(&known.statement.shown()));
            }
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
        let [first, other] = [first, other].map(|known| known.statement.shown());
        return Err(contradiction(what, first, other));
    }
    let best = all.iter().position(|known| known.measure.has_unit);
    Ok(Some(all.swap_remove(best.unwrap_or(0))))
}
