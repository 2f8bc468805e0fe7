//! Attributes of groups and data sets.

use hdf5_reader::{Attribute, ByteOrder as StoredOrder, Datatype, StringSize};

use crate::{Attributes, ByteOrder, Sample, Value};

/// Those that are texts or numbers. References, and bytes that are no text, are left out.
pub(super) fn read(found: &[Attribute]) -> Attributes {
    let named = found.iter();
    let named = named.filter_map(|one| Some((one.name.clone(), value(one)?)));
    Attributes(named.collect())
}

fn value(attribute: &Attribute) -> Option<Value> {
    match &attribute.datatype {
        Datatype::String { .. } | Datatype::VarLen { .. } => {
            let mut texts = texts(attribute)?;
            match texts.len() {
                0 => None,
                1 => Some(Value::Text(texts.remove(0))),
                _ => Some(Value::Texts(texts)),
            }
        }
        datatype => numbers(attribute, datatype),
    }
}

fn texts(attribute: &Attribute) -> Option<Vec<String>> {
    if let Ok(texts) = attribute.read_strings() {
        return Some(texts);
    }
    if let Ok(text) = attribute.read_string() {
        return Some(vec![text]);
    }
    let Datatype::String {
        size: StringSize::Fixed(size),
        ..
    } = attribute.datatype
    else {
        return None;
    };
    // Old instruments write units in Latin-1. Control characters show bytes that are no text.
    let text = |bytes: &[u8]| -> String { bytes.iter().map(|&byte| char::from(byte)).collect() };
    let size = usize::try_from(size).ok().filter(|&size| size > 0)?;
    let texts = attribute.raw_data.chunks_exact(size).map(text);
    let texts = texts.map(|text| text.trim_end_matches(['\0', ' ']).to_owned());
    let texts: Vec<String> = texts.collect();
    let is_text = |text: &String| !text.contains(|c: char| c.is_control() && !c.is_whitespace());
    texts.iter().all(is_text).then_some(texts)
}

fn numbers(attribute: &Attribute, datatype: &Datatype) -> Option<Value> {
    let (kind, size, order) = match datatype {
        Datatype::Enum { base, .. } => return numbers(attribute, base),
        Datatype::FixedPoint {
            size,
            signed,
            byte_order,
        } => (if *signed { 'i' } else { 'u' }, *size, byte_order),
        // PyTables stores booleans as bits.
        Datatype::Bitfield {
            size: 1,
            byte_order,
        } => ('u', 1, byte_order),
        Datatype::FloatingPoint { size, byte_order } => ('f', *size, byte_order),
        _ => return None,
    };
    let sample = Sample::of_kind(kind, size.into())?;
    let is_big = *order == StoredOrder::BigEndian;
    let order = if is_big {
        ByteOrder::Big
    } else {
        ByteOrder::Little
    };
    let count = usize::try_from(attribute.num_elements().ok()?).ok()?;
    let len = count.checked_mul(sample.bytes())?;
    let bytes = attribute.raw_data.get(..len)?;
    (!bytes.is_empty()).then(|| Value::of_samples(sample, order, bytes))
}
