//! Which variable of a file is the field, and which of its dimensions are times and sites.

use std::collections::HashSet;

use wavecascade_formats::{Container, Coordinate, Dimension, Format, Variable};

use super::super::meaning::{Meaning, known_as};
use super::super::note::spaced;
use super::super::options::Label;
use super::super::storage::by_rows;
use super::super::{Layout, Note};
use super::Arrays;
use crate::error::{
    Error, Fault, InputFault, OTHER_VARIABLE, Result, UNFINISHED, shape_of, some_of,
};
use crate::measure::{self, Length, Time, symbol};

/// A dimension of the field.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Place {
    /// Its place among the dimensions of the variable.
    pub dimension: usize,
    pub is_time: bool,
    /// Its name, or that of the variable that holds its coordinates.
    pub name: Option<String>,
    pub coordinate: Option<Coordinate>,
    /// Further variables that hold its coordinates.
    pub others: Vec<usize>,
}

/// A variable and the roles of its dimensions.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Choice {
    pub variable: usize,
    pub times: Place,
    /// `None` for the record of one site.
    pub sites: Option<Place>,
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
    /// What the options state, else what names, units and coordinates say.
    pub fn of(arrays: &Arrays) -> Result<Choice> {
        let options = arrays.source.options;
        let variable = variable(&arrays.container, options.variable.as_deref())?;
        let found = arrays.variable(variable);
        let of_name = |name: &String| dimension(found, name);
        let named = |name: &Option<String>| name.as_ref().map(of_name).transpose();
        let stated = [named(&options.time_dim)?, named(&options.space_dim)?];
        let (mut fixed, mut notes) = (Vec::new(), Vec::new());
        for at in &options.at {
            let place = dimension(found, &at.dimension)?;
            let (index, note) = index_at(arrays, found, place, &at.label)?;
            fixed.push((place, index));
            notes.extend(note);
        }
        let is_free = |d: &usize| fixed.iter().all(|(place, _)| place != d);
        let free: Vec<usize> = (0..found.dimensions.len()).filter(is_free).collect();
        // A dimension of one index is no axis, unless it is stated to be one or the field has no other.
        let is_long = |d: &&usize| found.dimensions[**d].len > 1 || stated.contains(&Some(**d));
        let mut long: Vec<usize> = free.iter().filter(is_long).copied().collect();
        for &d in &free {
            if long.len() < 2 && !long.contains(&d) {
                long.push(d);
            }
        }
        long.sort_unstable();
        fixed.extend(free.iter().filter(|d| !long.contains(d)).map(|&d| (d, 0)));
        let (time, space, is_layout_known) = roles(arrays, variable, &long, stated)?;
        let beside = Beside::of(arrays, variable);
        let sites = space.map(|d| beside.place(d, Role::Space));
        Ok(Choice {
            variable,
            times: beside.place(time, Role::Time)?,
            sites: sites.transpose()?,
            fixed,
            is_layout_known,
            notes,
        })
    }

    /// Times and sites, of which there is one where no dimension counts them.
    pub fn shape(&self, arrays: &Arrays) -> [usize; 2] {
        let dimensions = &arrays.variable(self.variable).dimensions;
        let length = |at: &Place| {
            dimensions[at.dimension]
                .len
                .try_into()
                .unwrap_or(usize::MAX)
        };
        [length(&self.times), self.sites.as_ref().map_or(1, length)]
    }

    /// What was taken for the field and its axes.
    pub fn note(&self, arrays: &Arrays) -> Note {
        let of = |place: Option<&Place>, what| {
            let name = place.and_then(|place| place.name.as_deref());
            let bare = name.map(|name| name.trim_start_matches('/'));
            bare.map_or(String::new(), |name| format!(", `{name}` its {what}"))
        };
        let axes = of(Some(&self.times), "times") + &of(self.sites.as_ref(), "sites");
        let path = &arrays.variable(self.variable).path;
        Note::told("variable", format!("variable `{path}` is the field{axes}"))
    }
}

/// The dimensions of times and sites of the dimensions `long`, and whether anything says so: those stated, else by names
/// and units, else by the lengths of variables that hold times and positions, else by the layout.
fn roles(
    arrays: &Arrays,
    variable: usize,
    long: &[usize],
    [time, space]: [Option<usize>; 2],
) -> Result<(usize, Option<usize>, bool)> {
    let found = arrays.variable(variable);
    let no_times = |d: usize| {
        let name = found.dimensions[d].name.as_deref().unwrap_or_default();
        let (times, only) = (&found.path, format!("only the sites {name:?} of one time"));
        let advice = "name an array with times and sites with `--variable`";
        Fault::expected(format!("times in {times}"), only, advice)
    };
    let role = |d: &usize| role(arrays, &found.dimensions[*d]);
    let those = |is_it: &dyn Fn(&usize) -> bool| -> Vec<usize> {
        long.iter().copied().filter(is_it).collect()
    };
    let of_role = |wanted: Role| those(&|d| role(d) == Some(wanted));
    let only = |places: Vec<usize>| (places.len() == 1).then(|| places[0]);
    let other = |one: usize| only(those(&|d| *d != one));
    let time = time.or_else(|| only(of_role(Role::Time)).filter(|&d| space != Some(d)));
    let space = space.or_else(|| match time {
        Some(time) => other(time),
        None => only(of_role(Role::Space)),
    });
    let time = time.or_else(|| space.and_then(other));
    match (time, space, long) {
        (None, Some(_), &[only]) => Err(no_times(only).into()),
        (Some(time), space, _) if long.len() <= 1 || space.is_some() => {
            match long.iter().find(|&&d| d != time && Some(d) != space) {
                Some(&extra) => Err(further(arrays, found, extra)),
                None => Ok((time, space, true)),
            }
        }
        (None, None, &[first, _]) if of_role(Role::Space) == long => Err(no_times(first).into()),
        (None, None, &[only]) => Ok((only, None, true)),
        (None, None, &[first, second]) => {
            let beside = Beside::of(arrays, variable);
            let len = |d: usize| found.dimensions[d].len;
            let fits = |time: usize, space: usize| {
                let has = |role, d| u8::from(!beside.of_length(role, len(d)).is_empty());
                has(Role::Time, time) + has(Role::Space, space)
            };
            let (straight, crossed) = (fits(first, second), fits(second, first));
            // MATLAB writes the columns of an array first.
            let is_reversed = found.attributes.get("MATLAB_class").is_some();
            let is_stated = arrays.source.stated.layout.is_some();
            let by_layout = (arrays.source.layout() == Layout::TimeSite) != is_reversed;
            let is_straight = match is_stated || straight == crossed {
                true => by_layout,
                false => straight > crossed,
            };
            let (time, space) = by_rows(is_straight, first, second);
            Ok((time, Some(space), straight != crossed))
        }
        (_, _, &[]) => Err(no_samples(found).into()),
        _ => {
            // What has the name of positions is the last to be left over.
            let is_position = |d: usize| {
                let name = found.dimensions[d].name.as_deref().unwrap_or_default();
                known_as(last_name(name), Meaning::Position).is_some()
            };
            let rank = |d: &usize| (role(d) == Some(Role::Space), is_position(*d));
            let others = those(&|d| Some(*d) != time).into_iter();
            let left = others.min_by_key(rank).unwrap_or(long[0]);
            Err(further(arrays, found, left))
        }
    }
}

/// Lists of numbers in the group of a variable that hold times or positions, by their names and units.
struct Beside<'a> {
    arrays: &'a Arrays<'a>,
    variable: &'a Variable,
    /// With the role, the place and the length of each.
    lists: Vec<(Role, usize, u64)>,
}

impl<'a> Beside<'a> {
    fn of(arrays: &'a Arrays, variable: usize) -> Beside<'a> {
        let container = &arrays.container;
        let group = |path: &'a str| &path[..path.len() - last_name(path).len()];
        let found = arrays.variable(variable);
        // Forces and what passes are between the sites of a run.
        let is_between = matches!(last_name(&found.path), "force" | "energy_passed");
        let of_contacts = container.find("contact_position").filter(|_| is_between);
        let list = |i: usize| {
            let other = &container.variables[i];
            let is_list = other.dimensions.iter().filter(|d| d.len != 1).count() <= 1
                && other.sample_type.number().is_some()
                && group(&other.path) == group(&found.path);
            let len = other.count().filter(|_| is_list && i != variable)?;
            let is = |meaning| known_as(last_name(&other.path), meaning).is_some();
            let role = match () {
                _ if of_contacts == Some(i) => Role::Space,
                _ if is(Meaning::Time) => Role::Time,
                _ if is(Meaning::Position) && of_contacts.is_none() => Role::Space,
                _ if other.attributes.text("units")?.contains(" since ") => Role::Time,
                _ => return None,
            };
            Some((role, i, len))
        };
        let mut lists: Vec<_> = (0..container.variables.len()).filter_map(list).collect();
        // The plain name, such as `time`, goes before the others.
        let is_plain =
            |i: usize| matches!(last_name(&container.variables[i].path), "time" | "position");
        lists.sort_by_key(|(_, i, _)| !is_plain(*i));
        Beside {
            arrays,
            variable: found,
            lists,
        }
    }

    fn of_length(&self, role: Role, len: u64) -> Vec<usize> {
        let is_it = |(of, _, n): &&(Role, usize, u64)| (*of, *n) == (role, len);
        let found = self.lists.iter().filter(is_it);
        found.map(|(_, i, _)| *i).collect()
    }

    /// A dimension with its coordinates.
    ///
    /// # Errors
    /// A list of coordinates that has another length.
    fn place(&self, d: usize, role: Role) -> Result<Place, InputFault> {
        let Dimension {
            name,
            len,
            coordinate,
        } = &self.variable.dimensions[d];
        let path = |i: usize| self.arrays.variable(i).path.clone();
        let (stated, is_time) = (&self.arrays.source.stated, role == Role::Time);
        // An axis that is stated in full needs no coordinates.
        let is_stated = match role {
            Role::Time => stated.t0.is_some() && stated.dt.is_some(),
            Role::Space => stated.x0.is_some() && stated.dx.is_some(),
        };
        let mut others = match coordinate.is_none() && !is_stated {
            true => self.of_length(role, *len),
            false => Vec::new(),
        };
        let is_other = |(of, _, len): &&(Role, usize, u64)| *of == role && *len > 1;
        if coordinate.is_none()
            && !is_stated
            && others.is_empty()
            && let Some(&(_, i, found)) = self.lists.iter().find(is_other)
        {
            let (axis, options) = match is_time {
                true => ("time", "`--t0` and `--dt`"),
                false => ("space", "`--x0` and `--dx`"),
            };
            let advice = format!("check `--layout`, or state {options} in their place");
            let fault = Fault::expected(format!("{len} {axis} coordinates"), found, advice);
            return Err(InputFault::from(fault).within(&path(i)));
        }
        let sibling = (!others.is_empty()).then(|| Coordinate::Listed(others.remove(0)));
        let coordinate = coordinate.clone().or(sibling);
        let listed = match coordinate {
            Some(Coordinate::Listed(i)) => Some(path(i)),
            _ => None,
        };
        Ok(Place {
            dimension: d,
            is_time,
            name: listed.or(name.clone()),
            coordinate,
            others,
        })
    }
}

/// The variable of this name, else the one that is a field.
fn variable(container: &Container, wanted: Option<&str>) -> Result<usize, InputFault> {
    let variables = &container.variables;
    if let Some(wanted) = wanted {
        let wanted = match container.format {
            Format::Npz => wanted.strip_suffix(".npy").unwrap_or(wanted),
            _ => wanted,
        };
        let mut called = (0..variables.len()).filter(|&i| last_name(&variables[i].path) == wanted);
        let by_last_name = called.next().filter(|_| called.next().is_none());
        let place = container.find(wanted).or(by_last_name);
        let place = place.ok_or_else(|| InputFault::NoSuchVariable {
            name: wanted.to_owned(),
            variables: list(container),
        })?;
        let found = &variables[place];
        return match found.sample_type.number() {
            Some(_) if found.count() != Some(0) => Ok(place),
            Some(_) => Err(no_samples(found).into()),
            None => Err(not_numbers(found).into()),
        };
    }
    let listed = |d: &Dimension| match d.coordinate {
        Some(Coordinate::Listed(i)) => Some(i),
        _ => None,
    };
    let dimensions = variables.iter().flat_map(|v| &v.dimensions);
    let coordinates: HashSet<usize> = dimensions.filter_map(listed).collect();
    let is_coordinate = |i: usize| {
        use Meaning::{Offset, Position, Scale, Time};
        let is = |meaning| known_as(last_name(&variables[i].path), meaning).is_some();
        coordinates.contains(&i) || [Time, Position, Scale, Offset].into_iter().any(is)
    };
    let rank = |v: &Variable| v.dimensions.iter().filter(|d| d.len > 1).count();
    let is_candidate = |&i: &usize| {
        let v = &variables[i];
        let holds_numbers = v.sample_type.number().is_some() && v.count().is_some_and(|n| n > 0);
        holds_numbers && (rank(v) > 1 || !is_coordinate(i))
    };
    let mut candidates: Vec<usize> = (0..variables.len()).filter(is_candidate).collect();
    // A field goes before a record, and that before the single numbers beside it, such as its position.
    let size = |i: &usize| rank(&variables[*i]).min(2);
    let largest = candidates.iter().map(size).max();
    candidates.retain(|i| Some(size(i)) == largest);
    let preferred = || {
        ["velocity", "v", "vel", "vx"].iter().find_map(|name| {
            let is_it = |i: &&usize| last_name(&variables[**i].path).eq_ignore_ascii_case(name);
            let mut named = candidates.iter().filter(is_it);
            named.next().filter(|_| named.next().is_none()).copied()
        })
    };
    let which = || {
        let found = some_of(&list(container));
        Fault::expected("one array v(t, x)", found, OTHER_VARIABLE)
    };
    let unread = |v: &&Variable| v.sample_type.way_out().is_some();
    let mut unread = variables.iter().filter(unread);
    // What is not read may be the field, beside lists that are none.
    let has_field = candidates.iter().any(|&i| rank(&variables[i]) > 1);
    let hidden = unread.clone().find(|v| !has_field && rank(v) > 1);
    match (&candidates[..], hidden) {
        (_, Some(hidden)) => Err(not_numbers(hidden).into()),
        ([only], None) => Ok(*only),
        ([], None) => {
            let empty = variables.iter().find(|v| v.count() == Some(0));
            let none = || empty.map_or_else(which, no_samples);
            Err(unread.next().map_or_else(none, not_numbers).into())
        }
        _ => Ok(preferred().ok_or_else(which)?),
    }
}

fn no_samples(variable: &Variable) -> Fault {
    let found = format!("an array of shape {}", shape_of(&variable.shape()));
    Fault::expected("samples", found, UNFINISHED)
}

/// The fault of a variable that holds something else.
fn not_numbers(variable: &Variable) -> Fault {
    let held = &variable.sample_type;
    let advice = held.way_out().unwrap_or(OTHER_VARIABLE);
    Fault::expected(format!("numbers in {}", variable.path), held.name(), advice)
}

/// The variables with their dimensions, for messages.
fn list(container: &Container) -> Vec<String> {
    let one = |v: &Variable| match v.sample_type.number() {
        Some(_) => format!("{} ({})", v.path, dimensions(v)),
        None => format!("{} ({})", v.path, v.sample_type.name()),
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

/// The dimension of this name, or of this number from 0.
fn dimension(variable: &Variable, name: &str) -> Result<usize, Fault> {
    let is_it = |d: &Dimension| {
        let own = d.name.as_deref().unwrap_or_default();
        own == name || last_name(own) == name
    };
    let by_name = variable.dimensions.iter().position(is_it);
    let by_number = || name.parse().ok().filter(|&d| d < variable.dimensions.len());
    let no_such = || {
        let expected = format!("the dimension {name:?} of {}", variable.path);
        let advice = "name one of these dimensions, or count them from 0";
        Fault::expected(expected, format!("({})", dimensions(variable)), advice)
    };
    by_name.or_else(by_number).ok_or_else(no_such)
}

/// The values of the coordinates of a dimension, and their unit.
fn places(arrays: &Arrays, d: &Dimension) -> Result<Option<Places>> {
    Ok(match &d.coordinate {
        None => None,
        Some(Coordinate::Even { origin, step, unit }) => {
            let at = |i: u64| origin + i as f64 * step;
            Some(((0..d.len).map(at).collect(), unit.clone()))
        }
        Some(Coordinate::Listed(i)) => Some((arrays.unpacked(*i)?, arrays.unit(*i))),
    })
}

/// The fault of a dimension that is neither time nor space.
fn further(arrays: &Arrays, variable: &Variable, place: usize) -> Error {
    let d = &variable.dimensions[place];
    let name = d.name.as_deref();
    let name = name.map_or(place.to_string(), |name| last_name(name).to_owned());
    let range = places(arrays, d).ok().flatten().and_then(|(values, unit)| {
        let (first, last) = (values.first()?, values.last()?);
        let range = format!(" from {first} to {last} {}", unit.unwrap_or_default());
        Some((range.trim_end().to_owned(), first.to_string()))
    });
    let (range, at) = range.unwrap_or_else(|| (String::new(), "#0".into()));
    let (path, all, len) = (&variable.path, dimensions(variable), d.len);
    let found = format!("{path} ({all}), also along {name} ({len} values{range})");
    let advice = format!(
        "state where it is taken, such as `--at {name}={at}`; `--time-dim` and `--space-dim` name the \
         dimensions of times and sites"
    );
    Fault::expected("times and sites", found, advice).into()
}

/// The index of a dimension at `label`, as [`nearest`]. A dimension without coordinates has those of an array of its name.
fn index_at(
    arrays: &Arrays,
    variable: &Variable,
    place: usize,
    label: &Label,
) -> Result<(u64, Option<Note>)> {
    let d = &variable.dimensions[place];
    let name = d.name.clone().unwrap_or_else(|| place.to_string());
    let is_it = |i: &usize| d.coordinate.is_none() && arrays.variable(*i).shape() == [d.len];
    let beside = arrays.container.find(&name).filter(is_it);
    let beside = beside.map(|i| Dimension::new(d.len).at(Coordinate::Listed(i)));
    let listed = places(arrays, beside.as_ref().unwrap_or(d))?;
    Ok(nearest(last_name(&name), d.len, listed, label)?)
}

/// The coordinates of a dimension and their unit.
type Places = (Vec<f64>, Option<String>);

/// The index of a dimension at `label`: that of the nearest coordinate, which is no farther than half a
/// step, or without coordinates the number itself; with a note where the coordinate is another one.
fn nearest(
    name: &str,
    len: u64,
    listed: Option<Places>,
    label: &Label,
) -> Result<(u64, Option<Note>), Fault> {
    let refuse = |expected: String| {
        let advice = "`cascade inspect FILE` lists the dimensions with their values";
        let said = format!("{name}: expected {expected}, found {label}");
        Fault::new(said, advice)
    };
    let by_number = |value: f64| {
        let is_index = value.fract() == 0.0 && (0.0..len as f64).contains(&value);
        let expected = || format!("an index from 0 to {}", len.saturating_sub(1));
        let index = is_index.then_some((value as u64, None));
        index.ok_or_else(|| refuse(expected()))
    };
    let (stated, has_unit) = match label {
        Label::Index(index) => return by_number(*index as f64),
        Label::Value { value, unit } => (*value, unit.is_some()),
    };
    let Some((values, unit)) = listed else {
        return match has_unit {
            true => Err(refuse(format!("an index, as `{name}` has no coordinates"))),
            false => by_number(stated),
        };
    };
    let factor = label.factor(unit.as_deref()).ok_or_else(|| {
        refuse(match &unit {
            Some(unit) => format!("a number in {unit}"),
            None => format!("a number without a unit, as `{name}` has none"),
        })
    })?;
    let value = stated * factor;
    let distance = |i: &usize| (values[*i] - value).abs();
    let nearest = (0..values.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let nearest = nearest.ok_or_else(|| refuse("a dimension with values".into()))?;
    let neighbour = nearest.checked_sub(1).unwrap_or(nearest + 1);
    let neighbour = values.get(neighbour);
    let step = neighbour.map_or(0.0, |other| (other - values[nearest]).abs());
    let tolerance = (step / 2.0).max(1e-9 * value.abs());
    if distance(&nearest) > tolerance * (1.0 + 1e-9) {
        let [first, last] = [values[0], values[values.len() - 1]].map(measure::digits);
        return Err(refuse(format!("{first} to {last}{}", spaced(&unit))));
    }
    // Beyond what a number in single precision is rounded by.
    let is_other = distance(&nearest) > 1e-3 * step + 1e-6 * value.abs();
    let (value, unit) = (measure::digits(values[nearest]), spaced(&unit));
    let text =
        format!("`{name}` is taken at {value}{unit} (index {nearest}), the nearest to {label}");
    let note = is_other.then(|| Note::told("nearest", text));
    Ok((nearest as u64, note))
}

/// What a dimension stands for, by its coordinates or its name.
fn role(arrays: &Arrays, dimension: &Dimension) -> Option<Role> {
    let of_unit = |unit: &str| match () {
        _ if unit.contains(" since ") => Some(Role::Time),
        _ if symbol::<Time>(unit).is_some() => Some(Role::Time),
        _ if symbol::<Length>(unit).is_some() => Some(Role::Space),
        _ => None,
    };
    let by_coordinate = match &dimension.coordinate {
        Some(Coordinate::Even { unit, .. }) => unit.as_deref().and_then(of_unit),
        Some(Coordinate::Listed(i)) => {
            let variable = arrays.variable(*i);
            let by_unit = || of_unit(&arrays.unit(*i)?);
            match variable.attributes.text("axis") {
                Some("T") => Some(Role::Time),
                Some("X" | "Y" | "Z") => Some(Role::Space),
                _ => by_unit().or_else(|| of_name(last_name(&variable.path))),
            }
        }
        None => None,
    };
    by_coordinate.or_else(|| of_name(last_name(dimension.name.as_deref()?)))
}

/// What a name stands for.
fn of_name(name: &str) -> Option<Role> {
    let is = |meaning| known_as(name, meaning).is_some();
    match () {
        _ if is(Meaning::Time) || is(Meaning::TimeDimension) => Some(Role::Time),
        _ if is(Meaning::Position) || is(Meaning::SiteDimension) => Some(Role::Space),
        _ => None,
    }
}

/// What follows the last `/` or `.` of a path.
pub(in super::super) fn last_name(path: &str) -> &str {
    let after = path.rfind(['/', '.']).map_or(0, |at| at + 1);
    &path[after..]
}
