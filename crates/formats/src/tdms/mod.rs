//! TDMS of National Instruments: groups of channels, written segment by segment.

mod channel;
mod decode;
mod description;
mod group;
mod pieces;
mod property;
mod samples;
mod scale;
mod segments;

use std::collections::HashMap;
use std::sync::Arc;

use crate::{Bytes, Container, Error, Format, Options, Result, Value};
use channel::Channel;
use decode::TdmsDecoder;
use group::Listing;
use property::Properties;
use segments::{Object, Segments};

/// The format of a file with this extension (lower case) and these bytes, if it is one of this module.
pub(crate) fn detect(extension: &str, bytes: &[u8]) -> Option<Format> {
    let is_signed = bytes.starts_with(b"TDSm") || bytes.starts_with(b"TDSh");
    (is_signed || extension == "tdms").then_some(Format::Tdms)
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let held = Arc::clone(&bytes);
    let bytes = (*held).as_ref();
    let segments = Segments::read(bytes, options)?;
    let mut of_file = Properties::default();
    let mut of_groups: HashMap<String, Properties> = HashMap::new();
    // In the order of their first channel.
    let mut groups: Vec<(String, Vec<(String, Object)>)> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut properties = Vec::new();
    for object in segments.objects {
        let mut names = names(&object.path)?.into_iter();
        match (names.next(), names.next()) {
            (None, _) => {
                let all = object.properties.list.iter();
                properties.extend(all.map(|(name, value)| (name.clone(), value.value())));
                of_file = object.properties;
            }
            (Some(group), None) => {
                let all = object.properties.list.iter();
                let of_group = |name: &String| format!("/{group}/{name}");
                properties.extend(all.map(|(name, value)| (of_group(name), value.value())));
                of_groups.insert(group, object.properties);
            }
            (Some(group), Some(channel)) => {
                let place = *places.entry(group.clone()).or_insert(groups.len());
                if place == groups.len() {
                    groups.push((group, Vec::new()));
                }
                groups[place].1.push((channel, object));
            }
        }
    }

    let mut listing = Listing::default();
    let none = Properties::default();
    for (group, channels) in groups {
        let above = [of_groups.get(&group).unwrap_or(&none), &of_file];
        let channels = channels.into_iter();
        let channels = channels.map(|(name, object)| Channel::new(name, object, above));
        listing.add(&group, channels.collect());
    }
    for (path, texts) in &listing.texts {
        if let Some(values) = decode::texts(bytes, texts)? {
            properties.push((path.clone(), Value::Texts(values)));
        }
    }
    let decoder = TdmsDecoder {
        bytes: Arc::clone(&held),
        sources: listing.sources,
    };
    let mut container = Container::new(format, Arc::clone(&held), Some(Box::new(decoder)));
    container.variables = listing.variables;
    container.remarks = listing.remarks;
    container.attributes.0 = properties;
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
