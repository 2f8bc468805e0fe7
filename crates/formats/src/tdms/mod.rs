//! TDMS of National Instruments: groups of channels, written segment by segment.

mod channel;
mod description;
mod group;
mod property;
mod samples;
mod scale;
mod segments;

use std::collections::HashSet;

use indexmap::IndexMap;

use crate::{Attributes, Bytes, Container, Error, Format, Options, Result};
use channel::Channel;
use group::Listing;
use segments::{Object, Segments};

/// The format of these bytes, if it is one of this module.
pub(crate) fn detect(bytes: &[u8]) -> Option<Format> {
    let is_signed = bytes.starts_with(b"TDSm") || bytes.starts_with(b"TDSh");
    is_signed.then_some(Format::Tdms)
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let segments = Segments::read((*bytes).as_ref(), options)?;
    let mut of_file = Attributes::default();
    let mut of_groups: IndexMap<String, Attributes> = IndexMap::new();
    // In the order of their first channel.
    let mut groups: IndexMap<String, Vec<(String, Object)>> = IndexMap::new();
    let mut container = Container::new(format, &bytes);
    for (path, object) in segments.objects {
        let mut names = names(&path)?.into_iter();
        let (group, channel) = (names.next(), names.next());
        let prefix = group
            .as_ref()
            .map_or(String::new(), |group| format!("/{group}/"));
        if channel.is_none() {
            let of_it = object.properties.0.iter();
            let of_it = of_it.map(|(name, value)| (format!("{prefix}{name}"), value.clone()));
            container.attributes.0.extend(of_it);
        }
        match (group, channel) {
            (None, _) => of_file = object.properties,
            (Some(group), None) => {
                of_groups.insert(group, object.properties);
            }
            (Some(group), Some(channel)) => {
                groups.entry(group).or_default().push((channel, object))
            }
        }
    }

    let mut listing = Listing {
        file: &bytes,
        container: &mut container,
        paths: HashSet::new(),
    };
    let none = Attributes::default();
    for (group, channels) in groups {
        let above = [of_groups.get(&group).unwrap_or(&none), &of_file];
        let channels = channels.into_iter();
        let channels = channels.map(|(name, object)| Channel::new(name, object, above));
        listing.add(&group, channels.collect())?;
    }
    let incomplete = segments.incomplete.unwrap_or_default();
    container.attributes.insert_text("incomplete", incomplete);
    Ok(container)
}

/// Group and channel of a path: `/'group'/'channel'`, quotes in names doubled.
fn names(path: &str) -> Result<Vec<String>> {
    let wrong = || {
        let expected = "/, /'group' or /'group'/'channel'";
        Error::damaged("the path of an object", expected, path)
    };
    let mut names = Vec::new();
    let mut rest = path;
    while !matches!(rest, "" | "/") {
        let mut characters = rest.strip_prefix("/'").ok_or_else(wrong)?.chars();
        let mut name = String::new();
        loop {
            match characters.next().ok_or_else(wrong)? {
                '\'' if characters.as_str().starts_with('\'') => {
                    characters.next();
                    name.push('\'');
                }
                '\'' => break,
                other => name.push(other),
            }
        }
        names.push(name);
        rest = characters.as_str();
    }
    if names.len() > 2 {
        return Err(wrong());
    }
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_of_objects() {
        assert_eq!(names("/").unwrap(), [""; 0]);
        assert_eq!(names("/'a/b'").unwrap(), ["a/b"]);
        assert_eq!(names("/'it''s'/'c'").unwrap(), ["it's", "c"]);
        for wrong in ["/a", "/'a", "/'a'/'b'/'c'", "/'a'b"] {
            assert!(names(wrong).is_err(), "{wrong}");
        }
    }
}
