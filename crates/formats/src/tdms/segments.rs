//! The segments of a file and the objects that they describe.

use std::collections::BTreeMap;
use std::sync::Arc;

use indexmap::IndexMap;

use super::description::{self, Index, Kind};
use super::samples::{Data, Texts};
use crate::cursor::{Budget, Cursor, beginning};
use crate::rows::Pieces;
use crate::{Attributes, ByteOrder, Error, Options, Result};

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
    pub properties: Attributes,
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
#[derive(Debug)]
pub(super) struct Segments {
    /// By their paths.
    pub objects: IndexMap<String, Object>,
    /// What is not read of a file that was not written to its end.
    pub incomplete: Option<String>,
    /// Objects of the current list that have samples, by their place in it.
    pub(super) active: BTreeMap<u64, usize>,
    /// Number of the current list, and of its next place.
    list: (u64, u64),
    /// Channels of all segments together.
    pub(super) work: u64,
    pub(super) budget: Budget,
}

impl Segments {
    pub(super) fn read(bytes: &[u8], options: &Options) -> Result<Segments> {
        let mut segments = Segments {
            objects: IndexMap::new(),
            incomplete: None,
            active: BTreeMap::new(),
            list: (0, 0),
            work: 0,
            budget: Budget::new("the description of a TDMS file", options),
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
        let mut lead = Cursor {
            bytes,
            at: at as usize,
            order: ByteOrder::Little,
        };
        let begin = lead;
        match lead.take(4, "TDSm")? {
            b"TDSm" => {}
            b"TDSh" => {
                let what = "an index of a TDMS file, which holds no samples";
                return Err(Error::unsupported(what, "open the .tdms file beside it"));
            }
            _ => return Err(begin.damaged("TDSm", beginning(&bytes[at as usize..]))),
        }
        let contents = lead.u32("the contents of a segment")?;
        if contents & IS_BIG_ENDIAN != 0 {
            lead.order = ByteOrder::Big;
        }
        let _version = lead.u32("a version")?;
        let next = lead.number(8, "the length of a segment")?;
        let samples = lead.number(8, "the length of a description")?;
        let first = at + LEAD;
        let place = |offset: u64| first.checked_add(offset);
        // A writer that was stopped leaves the length open.
        let end = Some(next).filter(|next| *next != u64::MAX).and_then(place);
        let is_cut = end.is_none_or(|end| end > length);
        let end = end.map_or(length, |end| end.min(length));
        let start = place(samples).filter(|start| *start <= end);
        if is_cut {
            let how = match start {
                Some(_) => "read as far as it reaches",
                None => "whose description is cut",
            };
            self.incomplete = Some(format!("the segment at byte {at}, {how}"));
        }
        let Some(start) = start else {
            let expected = format!("a description of at most {next} bytes");
            let damaged = || Err(begin.damaged(expected, samples));
            return if is_cut { Ok(None) } else { damaged() };
        };
        if contents & HAS_DESCRIPTION != 0 {
            lead.bytes = &bytes[..start as usize];
            self.description(&mut lead, contents & IS_NEW_LIST != 0)?;
        } else if at == 0 {
            return Err(begin.damaged("a description", "none in the first segment"));
        }
        let data = Data {
            start,
            bytes: end - start,
            order: lead.order,
            is_interleaved: contents & IS_INTERLEAVED != 0,
            is_cut,
        };
        self.data(data, length)?;
        Ok(Some(end))
    }

    fn description(&mut self, cursor: &mut Cursor, is_new: bool) -> Result<()> {
        if is_new {
            self.active.clear();
            self.list = (self.list.0 + 1, 0);
        }
        for _ in 0..cursor.u32("the number of objects")? {
            let path = description::text(cursor, "the path of an object")?;
            let len = path.len();
            let entry = self.objects.entry(path);
            let object = entry.index();
            if matches!(entry, indexmap::map::Entry::Vacant(_)) {
                let bytes = size_of::<Object>() + 2 * len + 64;
                self.budget.take(bytes as u64)?;
            }
            entry.or_default();
            self.index(object, cursor)?;
            for _ in 0..cursor.u32("the number of properties")? {
                let name = description::text(cursor, "the name of a property")?;
                let from = cursor.at;
                let property = description::property(cursor, &name)?;
                let bytes = 2 * name.len() + 2 * (cursor.at - from) + 128;
                // What a later segment says replaces what an earlier one said.
                let properties = &mut self.objects[object].properties.0;
                if properties.insert(name, property).is_none() {
                    self.budget.take(bytes as u64)?;
                }
            }
        }
        Ok(())
    }

    /// Reads what is said about the samples of an object.
    fn index(&mut self, object: usize, cursor: &mut Cursor) -> Result<()> {
        let at = *cursor;
        let header = cursor.u32("the index of an object")?;
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
                return Err(at.damaged("samples in an earlier segment", "none"));
            }
            AS_BEFORE => {}
            _ => {
                let index = description::index(cursor, header)?;
                let is_used = found.pieces.len() > 0 || !found.texts.is_empty();
                let earlier = found.kind.filter(|kind| is_used && *kind != index.kind);
                if let Some(earlier) = earlier.filter(|_| index.count > 0) {
                    let of = |kind| format!("samples of type {kind:?}");
                    return Err(at.damaged(of(earlier), of(index.kind)));
                }
                found.kind = earlier.or(Some(index.kind));
                found.index = Some(Arc::new(index));
            }
        }
        match found.index.as_ref().is_some_and(|index| index.count > 0) {
            true => self.active.insert(place, object),
            false => self.active.remove(&place),
        };
        Ok(())
    }
}
