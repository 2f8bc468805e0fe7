//! Which variable of a file is the field, and which of its dimensions are times and sites.

use std::collections::HashSet;

use wavecascade_formats::{Container, Coordinate, Dimension, Variable};

use super::super::options::{At, Label, OpenOptions};
use super::super::{Layout, Note, names};
use super::unpacked;
use crate::error::{DimensionName, Error, InputFault, Result};
use crate::measure::{self, Length, Time, symbol};

/// Names of dimensions of sites, besides those of positions.
const SITES: [&str; 24] = [
    "x", "y", "z", "r", "position", "distance", "offset", "depth", "site", "sites", "space",
    "channel", "channels", "trace", "traces", "station", "stations", "receiver", "location",
    "atom", "node", "point", "record", "records",
];

/// Names of dimensions of times, besides [`names::TIME`].
const TIMES: [&str; 5] = ["times", "sample", "samples", "frame", "step"];

/// A dimension of the field.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Place {
    /// Its place among the dimensions of the variable.
    pub dimension: usize,
    /// Its name, or that of the variable that holds its coordinates.
    pub name: Option<String>,
    pub coordinate: Option<Coordinate>,
}

/// A variable and the roles of its dimensions.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Choice {
    pub variable: usize,
    times: Place,
    /// `None` for the record of one site.
    sites: Option<Place>,
    /// The other dimensions, and the index that is taken of each.
    pub fixed: Vec<(usize, u64)>,
    /// Whether names, units or lengths say which dimension is time.
    pub is_layout_known: bool,
    /// What is taken of the other dimensions, where that is not what was stated.
    pub notes: Vec<Note>,
}

/// What a dimension stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Time,
    Space,
}

impl Choice {
    /// What `options` state, else what names, units and coordinates say.
    pub fn of(
        container: &Container,
        options: &OpenOptions,
        layout: Option<Layout>,
    ) -> Result<Choice, InputFault> {
        let variable = variable(container, options.variable.as_deref())?;
        let found = &container.variables[variable];
        let named = |name: &Option<String>| match name {
            Some(name) => dimension(found, name).map(Some),
            None => Ok(None),
        };
        let (time, space) = (named(&options.time_dim)?, named(&options.space_dim)?);
        let (mut fixed, mut notes) = (Vec::new(), Vec::new());
        for At {
            dimension: name,
            label,
        } in &options.at
        {
            let place = dimension(found, name)?;
            let (index, note) = index_at(container, found, place, label)?;
            fixed.push((place, index));
            notes.extend(note);
        }
        let is_fixed = |d: &usize| fixed.iter().any(|(place, _)| place == d);
        let free: Vec<usize> = (0..found.dimensions.len())
            .filter(|d| !is_fixed(d))
            .collect();
        // A dimension of one index is no axis, unless it is stated to be one or the field has no other.
        let is_long =
            |d: &&usize| found.dimensions[**d].len > 1 || time == Some(**d) || space == Some(**d);
        let mut long: Vec<usize> = free.iter().filter(is_long).copied().collect();
        for &d in free.iter() {
            if long.len() < 2 && !long.contains(&d) {
                long.push(d);
            }
        }
        long.sort_unstable();
        fixed.extend(free.iter().filter(|d| !long.contains(d)).map(|&d| (d, 0)));
        let roles = Roles::of(container, variable, &long, [time, space], layout)?;
        let place = |d: usize, sibling: Option<usize>| {
            let dimension = &found.dimensions[d];
            let coordinate = dimension.coordinate.clone();
            let coordinate = coordinate.or(sibling.map(Coordinate::Listed));
            let listed = match coordinate {
                Some(Coordinate::Listed(i)) => Some(container.variables[i].path.clone()),
                _ => None,
            };
            Place {
                dimension: d,
                name: listed.or(dimension.name.clone()),
                coordinate,
            }
        };
        Ok(Choice {
            variable,
            times: place(roles.time, roles.siblings[0]),
            sites: roles.space.map(|d| place(d, roles.siblings[1])),
            fixed,
            is_layout_known: roles.is_known,
            notes,
        })
    }

    pub fn times(&self) -> Option<&Place> {
        Some(&self.times)
    }

    pub fn sites(&self) -> Option<&Place> {
        self.sites.as_ref()
    }

    pub fn n_times(&self, container: &Container) -> Result<usize> {
        length(&container.variables[self.variable], self.times.dimension)
    }

    pub fn n_sites(&self, container: &Container) -> Result<usize> {
        let variable = &container.variables[self.variable];
        self.sites
            .as_ref()
            .map_or(Ok(1), |sites| length(variable, sites.dimension))
    }

    /// What was taken for the field and its axes.
    pub fn note(&self, container: &Container) -> Note {
        let variable = &container.variables[self.variable];
        let name = |place: &Place| {
            let of = |name: &String| name.trim_start_matches('/').to_owned();
            place.name.as_ref().map(of)
        };
        Note::Variable {
            path: variable.path.clone(),
            time: name(&self.times),
            space: self.sites.as_ref().and_then(name),
        }
    }
}

/// The dimensions of times and sites.
struct Roles {
    time: usize,
    space: Option<usize>,
    /// Variables that hold times and positions, found by their name and length.
    siblings: [Option<usize>; 2],
    is_known: bool,
}

impl Roles {
    /// Of the dimensions `long`, those stated, else by names and units, else by the lengths of variables
    /// that hold times and positions, else by the layout.
    fn of(
        container: &Container,
        variable: usize,
        long: &[usize],
        stated: [Option<usize>; 2],
        layout: Option<Layout>,
    ) -> Result<Roles, InputFault> {
        let found = &container.variables[variable];
        let role = |d: &usize| role(container, &found.dimensions[*d]);
        let of_role = |wanted: Role| -> Vec<usize> {
            let is_it = |d: &&usize| role(d) == Some(wanted);
            long.iter().filter(is_it).copied().collect()
        };
        let only = |places: Vec<usize>| match places[..] {
            [place] => Some(place),
            _ => None,
        };
        let other = |one: usize| only(long.iter().copied().filter(|&d| d != one).collect());
        let [time, space] = stated;
        let time = time.or_else(|| only(of_role(Role::Time)).filter(|&d| space != Some(d)));
        let space = space.or_else(|| match time {
            Some(time) => other(time),
            None => only(of_role(Role::Space)),
        });
        let time = time.or_else(|| space.and_then(other));
        let siblings = |time: usize, space: Option<usize>| {
            let of = |names: &[&str], d: usize| {
                let has_none = found.dimensions[d].coordinate.is_none();
                has_none.then(|| sibling(container, variable, names, found.dimensions[d].len))?
            };
            [
                of(&names::TIME, time),
                space.and_then(|d| of(&POSITIONS, d)),
            ]
        };
        match (time, space, long) {
            (None, Some(_), &[only]) => Err(InputFault::NoTimes {
                variable: found.path.clone(),
                dimension: found.dimensions[only].name.clone().unwrap_or_default(),
            }),
            (Some(time), space, _) if long.len() <= 1 || space.is_some() => {
                let extra = long.iter().find(|&&d| d != time && Some(d) != space);
                if let Some(&extra) = extra {
                    return Err(further(container, found, extra));
                }
                Ok(Roles {
                    time,
                    space,
                    siblings: siblings(time, space),
                    is_known: true,
                })
            }
            (None, None, &[only]) => Ok(Roles {
                time: only,
                space: None,
                siblings: siblings(only, None),
                is_known: true,
            }),
            (None, None, &[first, second]) => {
                let lengths = [first, second].map(|d| found.dimensions[d].len);
                let has = |names: &[&str], len| sibling(container, variable, names, len).is_some();
                let fits = |n_times, n_sites| {
                    [has(&names::TIME, n_times), has(&POSITIONS, n_sites)]
                        .iter()
                        .filter(|f| **f)
                        .count()
                };
                let (straight, crossed) =
                    (fits(lengths[0], lengths[1]), fits(lengths[1], lengths[0]));
                // MATLAB writes the columns of an array first.
                let is_reversed = found.attributes.get("MATLAB_class").is_some();
                let by_layout = match layout.unwrap_or_default() {
                    Layout::TimeSite => !is_reversed,
                    Layout::SiteTime => is_reversed,
                };
                let is_straight = match straight.cmp(&crossed) {
                    _ if layout.is_some() => by_layout,
                    std::cmp::Ordering::Greater => true,
                    std::cmp::Ordering::Less => false,
                    std::cmp::Ordering::Equal => by_layout,
                };
                let (time, space) = if is_straight {
                    (first, second)
                } else {
                    (second, first)
                };
                Ok(Roles {
                    time,
                    space: Some(space),
                    siblings: siblings(time, Some(space)),
                    is_known: straight != crossed,
                })
            }
            (_, _, &[]) => Err(InputFault::NoSamples {
                shape: found.shape(),
            }),
            _ => {
                // What has the name of positions is the last to be left over.
                let name = |d: usize| found.dimensions[d].name.as_deref().map(last_name);
                let is_position = |d: usize| name(d).is_some_and(|name| POSITIONS.contains(&name));
                let rank = |d: &&usize| (role(d) == Some(Role::Space), is_position(**d));
                let others = long.iter().filter(|&&d| Some(d) != time);
                let left = others.min_by_key(rank).copied();
                Err(further(container, found, left.unwrap_or(long[0])))
            }
        }
    }
}

/// Names of variables that hold positions.
const POSITIONS: [&str; 3] = ["position", "x", "distance"];

/// A variable beside `variable` of one of these names, that has so many numbers along one dimension.
fn sibling(container: &Container, variable: usize, names: &[&str], len: u64) -> Option<usize> {
    let group = |path: &str| path.len() - last_name(path).len();
    let own = &container.variables[variable].path;
    let place = |name: &&str| {
        container
            .variables
            .iter()
            .enumerate()
            .position(|(i, other)| {
                let is_beside = i != variable
                    && group(&other.path) == group(own)
                    && other.path[..group(own)] == own[..group(own)];
                let is_list = other.dimensions.iter().filter(|d| d.len != 1).count() <= 1
                    && other.count() == Some(len)
                    && other.sample_type.number().is_some();
                is_beside && is_list && last_name(&other.path).eq_ignore_ascii_case(name)
            })
    };
    names.iter().find_map(place)
}

/// The variable of this name, else the one that is a field.
fn variable(container: &Container, wanted: Option<&str>) -> Result<usize, InputFault> {
    let variables = &container.variables;
    if let Some(wanted) = wanted {
        let called: Vec<usize> = (0..variables.len())
            .filter(|&i| last_name(&variables[i].path) == wanted)
            .collect();
        let by_last_name = match called[..] {
            [only] => Some(only),
            _ => None,
        };
        let place = container.find(wanted).or(by_last_name);
        let no_such = || InputFault::NoSuchVariable {
            name: wanted.to_owned(),
            variables: list(container),
        };
        let place = place.ok_or_else(no_such)?;
        return match &variables[place].sample_type.number() {
            Some(_) if variables[place].count() != Some(0) => Ok(place),
            Some(_) => Err(InputFault::NoSamples {
                shape: variables[place].shape(),
            }),
            None => Err(not_numbers(&variables[place])),
        };
    }
    let listed = |d: &Dimension| match d.coordinate {
        Some(Coordinate::Listed(i)) => Some(i),
        _ => None,
    };
    let dimensions = variables.iter().flat_map(|v| &v.dimensions);
    let coordinates: HashSet<usize> = dimensions.filter_map(listed).collect();
    let is_coordinate = |i: usize| {
        let name = last_name(&variables[i].path).to_ascii_lowercase();
        let is_named = names::TIME.contains(&name.as_str()) || POSITIONS.contains(&name.as_str());
        coordinates.contains(&i) || is_named
    };
    let rank = |v: &Variable| v.dimensions.iter().filter(|d| d.len > 1).count();
    let of_rank = |is_it: fn(usize) -> bool| -> Vec<usize> {
        let is_candidate = |&i: &usize| {
            let v = &variables[i];
            v.sample_type.number().is_some()
                && v.count().is_some_and(|count| count > 0)
                && is_it(rank(v))
                && (rank(v) > 1 || !is_coordinate(i))
        };
        (0..variables.len()).filter(is_candidate).collect()
    };
    // A record goes before the single numbers beside it, such as the position of its only site.
    let of_ranks = [of_rank(|rank| rank >= 2), of_rank(|rank| rank == 1)];
    let found = of_ranks.into_iter().find(|found| !found.is_empty());
    let candidates = found.unwrap_or_else(|| of_rank(|rank| rank == 0));
    let preferred = || {
        ["velocity", "v", "vel", "vx"].iter().find_map(|name| {
            let is_it = |i: &&usize| last_name(&variables[**i].path).eq_ignore_ascii_case(name);
            let mut named = candidates.iter().filter(is_it);
            named.next().filter(|_| named.next().is_none()).copied()
        })
    };
    let unread = || {
        let mut unread = variables
            .iter()
            .filter(|v| v.sample_type.way_out().is_some());
        unread.next().map(not_numbers)
    };
    match candidates[..] {
        [only] => Ok(only),
        [] => Err(unread().unwrap_or_else(|| InputFault::WhichVariable {
            variables: list(container),
        })),
        _ => preferred().ok_or_else(|| InputFault::WhichVariable {
            variables: list(container),
        }),
    }
}

/// The fault of a variable that holds something else.
fn not_numbers(variable: &Variable) -> InputFault {
    InputFault::NotNumbers {
        variable: variable.path.clone(),
        found: other_type(variable),
        way_out: variable.sample_type.way_out(),
    }
}

/// The variables with their dimensions, for messages.
fn list(container: &Container) -> Vec<String> {
    let one = |v: &Variable| match v.sample_type.number() {
        Some(_) => format!("{} ({})", v.path, dimensions(v)),
        None => format!("{} ({})", v.path, other_type(v)),
    };
    container.variables.iter().map(one).collect()
}

/// The dimensions of a variable: `time: 2000, x: 64`.
pub(in super::super) fn dimensions(variable: &Variable) -> String {
    let one = |d: &Dimension| match &d.name {
        Some(name) => format!("{}: {}", last_name(name), d.len),
        None => d.len.to_string(),
    };
    let all: Vec<String> = variable.dimensions.iter().map(one).collect();
    all.join(", ")
}

fn other_type(variable: &Variable) -> String {
    match &variable.sample_type {
        wavecascade_formats::SampleType::Other(other) => other.clone(),
        wavecascade_formats::SampleType::Number(sample) => sample.name().to_owned(),
    }
}

/// The dimension of this name, or of this number from 0.
fn dimension(variable: &Variable, name: &str) -> Result<usize, InputFault> {
    let is_it = |d: &Dimension| {
        let own = d.name.as_deref().unwrap_or_default();
        own == name || last_name(own) == name
    };
    let by_name = variable.dimensions.iter().position(is_it);
    let by_number = || name.parse().ok().filter(|&d| d < variable.dimensions.len());
    by_name
        .or_else(by_number)
        .ok_or_else(|| InputFault::NoSuchDimension {
            name: name.to_owned(),
            variable: variable.path.clone(),
            dimensions: dimensions(variable),
        })
}

/// The fault of a dimension that is neither time nor space.
fn further(container: &Container, variable: &Variable, place: usize) -> InputFault {
    let d = &variable.dimensions[place];
    let range = match &d.coordinate {
        Some(Coordinate::Even { origin, step, unit }) => {
            Some((*origin, origin + (d.len - 1) as f64 * step, unit.clone()))
        }
        Some(Coordinate::Listed(i)) => {
            let values = unpacked(container, *i).unwrap_or_default();
            let unit = container.variables[*i].attributes.text("units");
            let unit = unit.map(str::to_owned);
            values
                .first()
                .zip(values.last())
                .map(|(a, b)| (*a, *b, unit))
        }
        None => None,
    };
    InputFault::FurtherDimension {
        variable: variable.path.clone(),
        dimensions: dimensions(variable),
        dimension: Box::new(DimensionName {
            name: d
                .name
                .as_deref()
                .map_or(place.to_string(), |name| last_name(name).to_owned()),
            len: d.len,
            range,
        }),
    }
}

/// The index of a dimension at `label`, as [`nearest`].
fn index_at(
    container: &Container,
    variable: &Variable,
    place: usize,
    label: &Label,
) -> Result<(u64, Option<Note>), InputFault> {
    let d = &variable.dimensions[place];
    let listed = match &d.coordinate {
        None => None,
        Some(Coordinate::Even { origin, step, unit }) => {
            let at = |i: u64| origin + i as f64 * step;
            Some(((0..d.len).map(at).collect(), unit.clone()))
        }
        Some(Coordinate::Listed(i)) => {
            let damaged = |fault| InputFault::Container {
                fault: Box::new(fault),
            };
            let unit = container.variables[*i].attributes.text("units");
            let values = unpacked(container, *i).map_err(damaged)?;
            Some((values, unit.map(str::to_owned)))
        }
    };
    let name = d.name.clone().unwrap_or_else(|| place.to_string());
    nearest(last_name(&name), d.len, listed, label)
}

/// The coordinates of a dimension and their unit.
pub(in super::super) type Places = (Vec<f64>, Option<String>);

/// The index of a dimension at `label`: that of the nearest coordinate, which is no farther than half a
/// step, or without coordinates the number itself; with a note where the coordinate is another one.
pub(in super::super) fn nearest(
    name: &str,
    len: u64,
    listed: Option<Places>,
    label: &Label,
) -> Result<(u64, Option<Note>), InputFault> {
    let refuse = |expected: String| InputFault::NoSuchLabel {
        dimension: name.to_owned(),
        expected,
        found: label.to_string(),
    };
    let by_number = |value: f64| {
        let is_index = value.fract() == 0.0 && (0.0..len as f64).contains(&value);
        let last = len.saturating_sub(1);
        is_index
            .then_some((value as u64, None))
            .ok_or_else(|| refuse(format!("an index from 0 to {last}")))
    };
    let stated = match label {
        Label::Index(index) => return by_number(*index as f64),
        Label::Value { value, .. } => *value,
    };
    let Some((values, unit)) = listed else {
        return match label {
            Label::Value { unit: Some(_), .. } => {
                Err(refuse("an index, as nothing says where it is".into()))
            }
            _ => by_number(stated),
        };
    };
    let factor = label.factor(unit.as_deref()).ok_or_else(|| {
        refuse(format!(
            "a number in {}",
            unit.as_deref().unwrap_or("its own unit")
        ))
    })?;
    let value = stated * factor;
    let distance = |i: &usize| (values[*i] - value).abs();
    let nearest = (0..values.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let nearest = nearest.ok_or_else(|| refuse("a dimension with values".into()))?;
    let neighbour = if nearest > 0 {
        nearest - 1
    } else {
        nearest + 1
    };
    let step = values
        .get(neighbour)
        .map_or(0.0, |other| (other - values[nearest]).abs());
    let tolerance = (step / 2.0).max(1e-9 * value.abs());
    if distance(&nearest) > tolerance * (1.0 + 1e-9) {
        let (first, last) = (values[0], values[values.len() - 1]);
        let unit = unit.map_or(String::new(), |unit| format!(" {unit}"));
        let range = format!(
            "{} to {}{unit}",
            measure::digits(first),
            measure::digits(last)
        );
        return Err(refuse(range));
    }
    // Beyond what a number in single precision is rounded by.
    let is_other = distance(&nearest) > 1e-3 * step + 1e-6 * value.abs();
    let note = is_other.then(|| Note::Nearest {
        dimension: name.to_owned(),
        index: nearest as u64,
        value: values[nearest],
        unit,
        stated: label.to_string(),
    });
    Ok((nearest as u64, note))
}

/// What a dimension stands for, by its coordinates or its name.
fn role(container: &Container, dimension: &Dimension) -> Option<Role> {
    let of_unit = |unit: &str| match () {
        _ if unit.contains(" since ") => Some(Role::Time),
        _ if symbol::<Time>(unit).is_some() => Some(Role::Time),
        _ if symbol::<Length>(unit).is_some() => Some(Role::Space),
        _ => None,
    };
    let by_coordinate = match &dimension.coordinate {
        Some(Coordinate::Even { unit, .. }) => unit.as_deref().and_then(of_unit),
        Some(Coordinate::Listed(i)) => {
            let variable = &container.variables[*i];
            let attributes = &variable.attributes;
            let axis = match attributes.text("axis") {
                Some("T") => Some(Role::Time),
                Some("X" | "Y" | "Z") => Some(Role::Space),
                _ => None,
            };
            let by_unit = || attributes.text("units").and_then(of_unit);
            axis.or_else(by_unit)
                .or_else(|| of_name(last_name(&variable.path)))
        }
        None => None,
    };
    by_coordinate.or_else(|| of_name(last_name(dimension.name.as_deref()?)))
}

/// What a name stands for.
fn of_name(name: &str) -> Option<Role> {
    let lower = name.to_ascii_lowercase();
    let is_in = |list: &[&str]| list.contains(&lower.as_str());
    let names = |layout| names::row_unit(name, layout).is_some();
    match () {
        _ if is_in(&TIMES) || names(Layout::TimeSite) => Some(Role::Time),
        _ if is_in(&SITES) || names(Layout::SiteTime) => Some(Role::Space),
        _ => None,
    }
}

/// What follows the last `/` or `.` of a path.
pub(in super::super) fn last_name(path: &str) -> &str {
    let after = path.rfind(['/', '.']).map_or(0, |at| at + 1);
    &path[after..]
}

fn length(variable: &Variable, dimension: usize) -> Result<usize> {
    let len = variable.dimensions[dimension].len;
    usize::try_from(len).map_err(|_| Error::Memory {
        what: "the field",
        needed: len,
        allowed: usize::MAX as u64,
    })
}
