//! SEG-Y and Seismic Unix: traces behind headers of fixed length.

mod geometry;
mod layout;
mod text;

use crate::{
    Bytes, Container, Coordinate, Dimension, Format, Options, Place, Remark, Result, Value,
    Variable,
};
use geometry::{Field, Headers};
use layout::{FILE_HEADER, HEADER, Layout, format_code, u16_at};

/// The format of these bytes, if it may be one of this module.
pub(crate) fn detect(bytes: &[u8]) -> Option<Format> {
    is_plausible(bytes).then_some(Format::SegY)
}

/// Whether a text that begins with `C` in ASCII or EBCDIC and a binary header come first.
fn is_plausible(bytes: &[u8]) -> bool {
    let is_set = |order, at| u16_at(order, bytes, at) > 0;
    bytes.len() >= FILE_HEADER + HEADER
        && matches!(bytes[0], b'C' | 0xc3)
        && format_code(bytes).is_some_and(|(order, _)| is_set(order, 3216) && is_set(order, 3220))
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, _options: &Options) -> Result<Container> {
    let mut container = Container::new(format, &bytes);
    let bytes = (*bytes).as_ref();
    let layout = match format {
        Format::SeismicUnix => Layout::seismic_unix(bytes)?,
        _ => Layout::segy(bytes)?,
    };
    let headers = Headers {
        layout: &layout,
        bytes,
    };
    let length_unit = if layout.is_feet { "ft" } else { "m" };
    let position_unit = match headers.coordinate_units() {
        Some(2) => "arcsec",
        Some(3) => "degree",
        Some(4) => "DDDMMSS.ss",
        Some(_) => length_unit,
        None => "",
    };
    let coordinate = headers.coordinate(position_unit == length_unit);
    let is_set = |field: &Field| headers.values(*field).any(|value| value != 0.0);
    let mut fields: Vec<Field> = Field::OF_HEADERS.into_iter().filter(is_set).collect();
    fields.extend(coordinate.filter(|field| !fields.contains(field)));

    let (dead, codes) = (
        "traces that hold no record of a sensor:",
        headers.no_records(),
    );
    container.remark_on_next(Remark::listing(dead, codes));
    let of_trace = Dimension::new(layout.traces as u64).named("trace");
    let listed = coordinate.and_then(|field| fields.iter().position(|&found| found == field));
    let mut trace = of_trace.clone();
    trace.coordinate = listed.map(|field| Coordinate::Listed(1 + field));
    let same_delay = headers.is_constant(Field::Delay);
    let origin = match same_delay {
        true => Field::Delay.value(&layout, layout.header(bytes, 0)) / 1e3,
        false => 0.0,
    };
    let is_one = layout.intervals.len() == 1;
    let mut time = Dimension::new(layout.samples as u64).named("time");
    let interval = layout.intervals.first();
    time.coordinate = interval.map(|(_, interval)| {
        let step = if is_one { interval / 1e6 } else { f64::NAN };
        Coordinate::even(origin, step, "s")
    });
    let mut traces = Variable::new("/traces", vec![trace, time], layout.sample);
    for (place, interval) in layout.intervals.iter().filter(|_| !is_one) {
        let name = format!("sample_interval ({place})");
        let attributes = &mut traces.attributes;
        attributes.insert_text(name, format!("{interval} us"));
    }
    let strides = vec![layout.stride() as u64, layout.sample.bytes() as u64];
    traces.place = Place::in_file((layout.start + HEADER) as u64, strides, layout.order);
    if !same_delay {
        let text = "the delay recording times of the traces differ; see /delay";
        traces.attributes.insert_text("delays", text);
    }
    container.push(traces);
    for field in &fields {
        let unit = match field {
            Field::Delay => "ms",
            field if field.is_position() => position_unit,
            _ => length_unit,
        };
        container.push_floats(field.path(), &of_trace, unit, headers.values(*field));
    }

    if let Some(revision) = layout.revision {
        let text = text::decode(&bytes[..3200]);
        container.attributes.insert_text("text", text);
        let revision = Value::Integers(vec![revision.into()]);
        container.attributes.insert("revision", revision);
    }
    Ok(container)
}
