//! The segments of a file and the objects that they describe.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::description::{Index, Kind, Reader};
use super::pieces::Pieces;
use super::property::Properties;
use super::samples::{Data, Texts};
use crate::{ByteOrder, Error, Options, Result};

/// Bytes before the description of a segment.
const LEAD: u64 = 28;
const HAS_DESCRIPTION: u32 = 1 << 1;
const IS_NEW_LIST: u32 = 1 << 2;
const IS_INTERLEAVED: u32 = 1 << 5;
const IS_BIG_ENDIAN: u32 = 1 << 6;
const AS_BEFORE: u32 = 0;
const NO_SAMPLES: u32 = u32::MAX;
/// The file, a group or a channel.
#[derive(Debug, Default)]
pub(super) struct Object {
    pub path: String,
    pub properties: Properties,
    /// None before the first samples.
    pub kind: Option<Kind>,
    pub pieces: Pieces,
    pub texts: Vec<Texts>,
    /// What the last segment said of its samples.
    pub(super) index: Option<Arc<Index>>,
    /// Its place in the list of objects, and the number of that list.
    place: Option<(u64, u64)>,
}

/// All that the segments of a file say.
#[derive(Debug, Default)]
pub(super) struct Segments {
    pub objects: Vec<Object>,
    /// What is not read of a file that was not written to its end.
    pub incomplete: Option<String>,
    places: HashMap<String, usize>,
    /// Objects of the current list that have samples, by their place in it.
    pub(super) active: BTreeMap<u64, usize>,
    /// Number of the current list, and of its next place.
    list: (u64, u64),
    /// Channels of all segments together.
    pub(super) work: u64,
    used: u64,
    memory: Option<u64>,
}

impl Segments {
    pub(super) fn read(bytes: &[u8], options: &Options) -> Result<Segments> {
        let mut segments = Segments {
            memory: options.memory,
            ..Segments::default()
        };
        let length = bytes.len() as u64;
        let mut at = 0;
        while length - at >= LEAD || at == 0 {
            match segments.segment(bytes, at)? {
                Some(next) => at = next,
                None => break,
            }
        }
        if at < length && segments.incomplete.is_none() {
            segments.incomplete = Some(format!("{} bytes behind the last segment", length - at));
        }
        Ok(segments)
    }

    /// Reads the segment at byte `at`; the byte behind it.
    fn segment(&mut self, bytes: &[u8], at: u64) -> Result<Option<u64>> {
        let length = bytes.len() as u64;
        let mut lead = Reader {
            bytes,
            at: at as usize,
            order: ByteOrder::Little,
        };
        let tag = lead.take(4, "TDSm")?;
        if tag == b"TDSh" {
            let what = "an index of a TDMS file, which holds no samples";
            return Err(Error::unsupported(what, "open the .tdms file beside it"));
        }
        if tag != b"TDSm" {
            let found = String::from_utf8_lossy(tag).escape_debug().to_string();
            return Err(Error::damaged(format!("byte {at}"), "TDSm", found));
        }
        let contents = lead.u32("the contents of a segment")?;
        if contents & IS_BIG_ENDIAN != 0 {
            lead.order = ByteOrder::Big;
        }
        let _version = lead.u32("a version")?;
        let next = lead.u64("the length of a segment")?;
        let samples = lead.u64("the length of a description")?;
        let first = at + LEAD;
        let place = |offset: u64| first.checked_add(offset);
        // A writer that was stopped leaves the length open.
        let end = Some(next).filter(|next| *next != u64::MAX).and_then(place);
        let is_cut = end.is_none_or(|end| end > length);
        let end = end.map_or(length, |end| end.min(length));
        let Some(start) = place(samples).filter(|start| *start <= end) else {
            if is_cut {
                let from = format!("the segment at byte {at}, whose description is cut");
                self.incomplete = Some(from);
                return Ok(None);
            }
            let expected = format!("a description of at most {next} bytes");
            return Err(Error::damaged(
                format!("the segment at byte {at}"),
                expected,
                samples.to_string(),
            ));
        };
        if contents & HAS_DESCRIPTION != 0 {
            let mut description = Reader {
                bytes: &bytes[..start as usize],
                ..lead
            };
            self.description(&mut description, contents & IS_NEW_LIST != 0)?;
        } else if at == 0 {
            let found = "none in the first segment";
            return Err(Error::damaged("byte 4", "a description", found));
        }
        let data = Data {
            start,
            bytes: end - start,
            order: lead.order,
            is_interleaved: contents & IS_INTERLEAVED != 0,
            is_cut,
        };
        if is_cut {
            let text = format!("the segment at byte {at}, read as far as it reaches");
            self.incomplete = Some(text);
        }
        self.data(data, length)?;
        Ok(Some(end))
    }

    fn description(&mut self, reader: &mut Reader, is_new: bool) -> Result<()> {
        if is_new {
            self.active.clear();
            self.list = (self.list.0 + 1, 0);
        }
        for _ in 0..reader.u32("the number of objects")? {
            let path = reader.text("the path of an object")?;
            let object = match self.places.get(&path) {
                Some(&object) => object,
                None => {
                    self.count(size_of::<Object>() + 2 * path.len() + 64)?;
                    self.places.insert(path.clone(), self.objects.len());
                    self.objects.push(Object {
                        path,
                        ..Object::default()
                    });
                    self.objects.len() - 1
                }
            };
            self.index(object, reader)?;
            for _ in 0..reader.u32("the number of properties")? {
                let name = reader.text("the name of a property")?;
                let from = reader.at;
                let property = reader.property(&name)?;
                let bytes = 2 * name.len() + 2 * (reader.at - from) + 128;
                if self.objects[object].properties.set(name, property) {
                    self.count(bytes)?;
                }
            }
        }
        Ok(())
    }

    /// Reads what is said about the samples of an object.
    fn index(&mut self, object: usize, reader: &mut Reader) -> Result<()> {
        let at = reader.at;
        let header = reader.u32("the index of an object")?;
        let found = &mut self.objects[object];
        let place = match found.place {
            Some((list, place)) if list == self.list.0 => place,
            _ => {
                found.place = Some(self.list);
                self.list.1 += 1;
                self.list.1 - 1
            }
        };
        match header {
            NO_SAMPLES => {
                self.active.remove(&place);
                return Ok(());
            }
            AS_BEFORE if found.index.is_none() => {
                let expected = "samples in an earlier segment";
                return Err(Error::damaged(format!("byte {at}"), expected, "none"));
            }
            AS_BEFORE => {}
            _ => {
                let index = reader.index(header)?;
                let is_used = found.pieces.len() > 0 || !found.texts.is_empty();
                let earlier = found.kind.filter(|kind| is_used && *kind != index.kind);
                match earlier {
                    Some(earlier) if index.count > 0 => {
                        let place = format!("byte {at}, {}", found.path);
                        let of = |kind| format!("samples of type {kind:?}");
                        return Err(Error::damaged(place, of(earlier), of(index.kind)));
                    }
                    Some(_) => {}
                    None => found.kind = Some(index.kind),
                }
                found.index = Some(Arc::new(index));
            }
        }
        let has_samples = |index: &Arc<Index>| index.count > 0;
        if self.objects[object].index.as_ref().is_some_and(has_samples) {
            self.active.insert(place, object);
        } else {
            self.active.remove(&place);
        }
        Ok(())
    }

    pub(super) fn count(&mut self, bytes: usize) -> Result<()> {
        self.used = self.used.saturating_add(bytes as u64);
        match self.memory {
            Some(allowed) if self.used > allowed => Err(Error::Memory {
                what: "the description of a TDMS file".into(),
                needed: self.used,
                allowed,
            }),
            _ => Ok(()),
        }
    }
}
