//! Parts of a field, by the coordinates of their ends.

use std::ops::Range;

use super::options::{Label, Selection};
use super::{Axis, Field};
use crate::error::{Error, Result};

/// Share of a step by which an end may miss a sample.
const SLACK: f64 = 1e-6;

impl Field {
    /// The part of a field between the ends of every selection.
    pub(super) fn selected(mut self, selections: &[Selection]) -> Result<Field> {
        for selection in selections {
            let is_in = |names: &[&str]| names.contains(&selection.dimension.as_str());
            let named = |name: &Option<String>| name.as_deref() == Some(&selection.dimension);
            let [time_name, space_name] = &self.axis_names;
            if is_in(&["time", "t"]) || named(time_name) {
                let range = range("time", &self.time, self.n_times, selection)?;
                self.time.origin = self.time.at(range.start);
                self.n_times = range.len();
                self.storage = self.storage.from(range.start, 0);
            } else if is_in(&["space", "position", "site", "x"]) || named(space_name) {
                let range = range("space", &self.space, self.n_sites, selection)?;
                self.space.origin = self.space.at(range.start);
                self.n_sites = range.len();
                self.storage = self.storage.from(0, range.start);
                if !self.channels.is_empty() {
                    self.channels = self.channels[range.clone()].to_vec();
                }
                self.struck = self.struck.and_then(|site| site.checked_sub(range.start));
                self.masses = self.masses.take().map(|all| all[range.clone()].to_vec());
            } else {
                let names = [time_name, space_name].into_iter().flatten();
                let names: Vec<&str> = names.map(String::as_str).collect();
                let own = if names.is_empty() { "" } else { ", here also " };
                let expected = format!("time or space{own}{}", names.join(", "));
                return Err(Error::request("select", expected, &selection.dimension));
            }
        }
        Ok(self)
    }
}

/// The indices between both ends of `selection`, both included.
fn range(
    name: &'static str,
    axis: &Axis,
    count: usize,
    selection: &Selection,
) -> Result<Range<usize>> {
    let refuse = |expected: String, found: String| Error::request("select", expected, found);
    let place = |label: &Label| match label {
        Label::Index(index) => Ok(*index as f64),
        Label::Value { value, .. } => {
            let unit = axis.unit.as_deref();
            let place = |factor| (value * factor - axis.origin) / axis.step;
            let unit_of = unit.unwrap_or("its unit, which is not stated");
            let unfit = || refuse(format!("{name} in {unit_of}"), label.to_string());
            label.factor(unit).map(place).ok_or_else(unfit)
        }
    };
    let from = selection.from.as_ref().map_or(Ok(0.0), place)?;
    let to = selection.to.as_ref();
    let to = to.map_or(Ok(count as f64 - 1.0), place)?;
    let first = (from - SLACK).ceil().max(0.0);
    let last = (to + SLACK).floor().min(count as f64 - 1.0);
    // Ends that are not numbers compare as false.
    if first <= last {
        return Ok(first as usize..last as usize + 1);
    }
    let unit = axis.unit.as_deref().unwrap_or_default();
    let end = |label: &Option<Label>| label.as_ref().map(Label::to_string).unwrap_or_default();
    let (first, last) = (axis.origin, axis.at(count - 1));
    let expected = format!("samples between both ends, of the {name} {first} to {last} {unit}");
    let (from, to) = (end(&selection.from), end(&selection.to));
    let found = format!("none from {from} to {to}");
    Err(refuse(expected.trim_end().to_owned(), found))
}
