//! SEG-Y and Seismic Unix: traces behind headers of fixed length.

mod geometry;
mod layout;
mod text;

use std::sync::Arc;

use crate::{
    Attributes, Bytes, Container, Coordinate, Dimension, Format, Options, Place, Result, Sample,
    SampleType, Value, Variable,
};
use geometry::{Field, HeaderDecoder, Headers};
use layout::{FILE_HEADER, HEADER, Layout, format_code, u16_at};

/// The format of a file with this extension (lower case) and these bytes, if it is one of this module.
pub(crate) fn detect(extension: &str, bytes: &[u8]) -> Option<Format> {
    match extension {
        "sgy" | "segy" => Some(Format::SegY),
        "su" => Some(Format::SeismicUnix),
        _ => is_plausible(bytes).then_some(Format::SegY),
    }
}

/// Whether a text that begins with `C` in ASCII or EBCDIC and a binary header come first.
fn is_plausible(bytes: &[u8]) -> bool {
    if bytes.len() < FILE_HEADER + HEADER || !matches!(bytes[0], b'C' | 0xc3) {
        return false;
    }
    format_code(bytes)
        .is_some_and(|(order, _)| u16_at(order, bytes, 3216) > 0 && u16_at(order, bytes, 3220) > 0)
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, _options: &Options) -> Result<Container> {
    let held = Arc::clone(&bytes);
    let bytes = (*held).as_ref();
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
        Some(2) => Some("arcsec"),
        Some(3) => Some("degree"),
        Some(4) => Some("DDDMMSS.ss"),
        Some(_) => Some(length_unit),
        None => None,
    };
    let coordinate = headers.coordinate(position_unit == Some(length_unit));
    let is_set = |field: &Field| headers.values(*field).any(|value| value != 0.0);
    let mut fields: Vec<Field> = Field::OF_HEADERS.into_iter().filter(is_set).collect();
    fields.extend(coordinate.filter(|field| !fields.contains(field)));

    let traces = layout.traces as u64;
    let trace = Dimension::new(traces).named("trace");
    let listed = coordinate.and_then(|field| fields.iter().position(|&found| found == field));
    let time = Dimension::new(layout.samples as u64).named("time");
    let same_delay = headers.is_constant(Field::Delay);
    let mut variables = vec![Variable {
        path: "/traces".into(),
        dimensions: vec![
            Dimension {
                coordinate: listed.map(|field| Coordinate::Listed(1 + field)),
                ..trace.clone()
            },
            Dimension {
                coordinate: time_of(&layout, bytes, same_delay),
                ..time
            },
        ],
        sample_type: SampleType::Number(layout.sample),
        attributes: Attributes::default(),
        place: Place::Strided {
            start: (layout.start + HEADER) as u64,
            strides: vec![layout.stride() as u64, layout.sample.bytes() as u64],
            order: layout.order,
        },
    }];
    if !same_delay {
        let text = "the delay recording times of the traces differ; see /delay";
        variables[0].attributes.insert_text("delays", text);
    }
    for field in &fields {
        let unit = match field {
            Field::Delay => Some("ms"),
            field if field.is_position() => position_unit,
            _ => Some(length_unit),
        };
        let mut attributes = Attributes::default();
        attributes.insert_text("units", unit.unwrap_or_default());
        variables.push(Variable {
            path: field.path().into(),
            dimensions: vec![trace.clone()],
            sample_type: SampleType::Number(Sample::F64),
            attributes,
            place: Place::Encoded { rows: traces },
        });
    }

    let decoder = HeaderDecoder {
        layout,
        bytes: Arc::clone(&held),
        fields,
    };
    let mut container = Container::new(format, Arc::clone(&held), Some(Box::new(decoder)));
    container.variables = variables;
    if let Some(revision) = layout.revision {
        container
            .attributes
            .insert_text("text", text::decode(&bytes[..3200]));
        let revision = Value::Integers(vec![revision.into()]);
        container.attributes.insert("revision", revision);
    }
    Ok(container)
}

/// Times of the samples; none without a sample interval, and without one origin.
fn time_of(layout: &Layout, bytes: &[u8], same_delay: bool) -> Option<Coordinate> {
    let header = layout.header(bytes, 0);
    let interval = if layout.interval > 0.0 {
        layout.interval
    } else {
        f64::from(u16_at(layout.order, header, 116))
    };
    let origin = if same_delay {
        Field::Delay.value(layout, header) / 1e3
    } else {
        0.0
    };
    (interval > 0.0).then(|| Coordinate::Even {
        origin,
        step: interval / 1e6,
        unit: Some("s".into()),
    })
}
