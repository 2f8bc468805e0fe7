//! What the page's script draws: maps (here) and curves, as JSON with base64 arrays.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use ndarray::ArrayView2;
use serde::Serialize;

use super::curves::{self, CurveGroup};
use super::words;
use crate::analyze::{Analysis, BandEdge, Map, ShortTimeSpectra};
use crate::plot::labels;
use crate::plot::{self, ColorScale};

/// Largest embedded short-time map, bins by frames.
const SHORT_LIMIT: (usize, usize) = (256, 400);

#[derive(Debug, Serialize)]
pub(super) struct Payload {
    /// 256 colours, the last for cells without a value.
    sequential: String,
    diverging: String,
    decades: f64,
    pub maps: Vec<MapData>,
    pub curves: Vec<CurveGroup>,
}

/// What an axis counts; picks are shared between axes that count the same.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Role {
    Time,
    Position,
    Frequency,
    Wavenumber,
}

#[derive(Debug, Serialize)]
pub(super) struct AxisData {
    pub label: String,
    low: f64,
    high: f64,
    role: Role,
    /// A second reading: its label, and what values are multiplied by.
    second: Option<(String, f64)>,
    /// A value marked across the picture.
    mark: Option<f64>,
}

#[derive(Debug, Serialize)]
pub(super) struct MapData {
    pub id: String,
    pub title: String,
    #[serde(skip)]
    pub caption: String,
    pub x: AxisData,
    pub y: AxisData,
    label: String,
    signed: bool,
    /// Axis that the curve beside the map runs along at first.
    along: &'static str,
    rows: usize,
    columns: usize,
    /// Row by row from the lowest y, little-endian f32.
    values: String,
    /// Least and largest value of each cell, if a cell is of more than one signed sample.
    least: Option<String>,
    largest: Option<String>,
    /// What a point of the curve beside the map is, where that is not one sample.
    block: Option<String>,
}

impl Payload {
    pub fn of(analysis: &Analysis) -> Self {
        Payload {
            sequential: palette(ColorScale::log(std::iter::empty())),
            diverging: palette(ColorScale::diverging(std::iter::empty())),
            decades: plot::DECADES,
            maps: maps(analysis),
            curves: curves::of(analysis),
        }
    }

    /// JSON that cannot end the script element around it.
    pub fn json(&self) -> String {
        serde_json::to_string(self)
            .unwrap_or_else(|_| "null".into())
            .replace('<', "\\u003c")
    }
}

fn palette(scale: ColorScale) -> String {
    BASE64_STANDARD.encode(scale.palette().concat())
}

pub(super) fn double(values: impl IntoIterator<Item = f64>) -> String {
    let bytes: Vec<u8> = values.into_iter().flat_map(f64::to_le_bytes).collect();
    BASE64_STANDARD.encode(bytes)
}

fn single(values: impl Iterator<Item = f32>) -> String {
    BASE64_STANDARD.encode(values.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
}

fn maps(analysis: &Analysis) -> Vec<MapData> {
    let frequency_edge = mark(analysis.frequency_edge);
    let wavenumber_edge = mark(analysis.wavenumber_edge);
    let second = labels::wavenumber_reading(&analysis.axes);
    let mut maps = Vec::new();
    let mut add = |id, along, signed, map: &Option<Map>, roles| {
        if let Some(map) = map {
            maps.push(map_data(id, along, signed, map, roles));
        }
    };
    let roles = (Role::Position, Role::Time);
    add("field", "y", true, &analysis.field_map, roles);
    let roles = (Role::Position, Role::Frequency);
    add("temporal", "y", false, &analysis.temporal_map, roles);
    let roles = (Role::Wavenumber, Role::Time);
    add("spatial", "x", false, &analysis.spatial_map, roles);
    let roles = (Role::Wavenumber, Role::Frequency);
    add("spacetime", "y", false, &analysis.spacetime_map, roles);
    let roles = (Role::Wavenumber, Role::Time);
    add("flux", "x", true, &analysis.flux_map, roles);
    maps.extend(short_time(analysis));
    maps.extend(short_space(analysis));
    for map in &mut maps {
        for axis in [&mut map.x, &mut map.y] {
            match axis.role {
                Role::Frequency => axis.mark = frequency_edge,
                Role::Wavenumber => {
                    axis.second = second.clone();
                    axis.mark = wavenumber_edge;
                }
                Role::Time | Role::Position => {}
            }
        }
    }
    maps
}

pub(super) fn mark(edge: Option<BandEdge>) -> Option<f64> {
    edge.map(|edge| edge.value())
        .filter(|value| value.is_finite())
}

fn axis(label: &str, (low, high): (f64, f64), role: Role) -> AxisData {
    AxisData {
        label: label.into(),
        low,
        high,
        role,
        second: None,
        mark: None,
    }
}

fn map_data(
    id: &'static str,
    along: &'static str,
    signed: bool,
    map: &Map,
    (x, y): (Role, Role),
) -> MapData {
    let (rows, columns) = map.values.dim();
    MapData {
        id: id.into(),
        title: words::title(id).into(),
        caption: words::caption(id, map.reduction),
        x: axis(&map.x.label, (map.x.low, map.x.high), x),
        y: axis(&map.y.label, (map.y.low, map.y.high), y),
        label: map.label.clone(),
        signed,
        along,
        rows,
        columns,
        values: single(map.values.iter().copied()),
        least: map
            .range
            .as_ref()
            .map(|range| single(range[0].iter().copied())),
        largest: map
            .range
            .as_ref()
            .map(|range| single(range[1].iter().copied())),
        block: words::block(map.reduction),
    }
}

fn short_time(analysis: &Analysis) -> Vec<MapData> {
    let axes = &analysis.axes;
    let quantity = labels::short_time_density(analysis);
    let along = (labels::time(axes), Role::Time);
    let content = (labels::frequency(axes), Role::Frequency);
    let at = labels::position(axes);
    match &analysis.short_time {
        Some(spectra) => short_maps("short-time", spectra, &quantity, along, content, &at),
        None => Vec::new(),
    }
}

fn short_space(analysis: &Analysis) -> Vec<MapData> {
    let axes = &analysis.axes;
    let quantity = labels::short_space_density(analysis);
    let along = (labels::position(axes), Role::Position);
    let content = (labels::wavenumber(axes), Role::Wavenumber);
    let at = labels::time(axes);
    match &analysis.short_space {
        Some(spectra) => short_maps("short-space", spectra, &quantity, along, content, &at),
        None => Vec::new(),
    }
}

fn short_maps(
    id: &str,
    spectra: &ShortTimeSpectra,
    quantity: &str,
    along: (String, Role),
    content: (String, Role),
    at: &str,
) -> Vec<MapData> {
    let one = |(index, spectrum): (usize, &crate::analyze::ShortTimeSpectrum)| {
        let values: ArrayView2<f64> = spectrum.values.view();
        let blocks = plot::block_extremes(values, SHORT_LIMIT.0, SHORT_LIMIT.1);
        let (rows, columns) = blocks.dim();
        MapData {
            id: format!("{id}-{index}"),
            title: format!(
                "{} at {at} = {}",
                words::title(id),
                words::number(spectrum.at)
            ),
            caption: words::short_caption(id, spectra),
            x: axis(&along.0, plot::edges(&spectra.frames), along.1),
            y: axis(&content.0, plot::edges(&spectra.bins), content.1),
            label: quantity.into(),
            signed: false,
            along: "y",
            rows,
            columns,
            values: single(blocks.iter().map(|&value| value as f32)),
            least: None,
            largest: None,
            block: None,
        }
    };
    spectra.spectra.iter().enumerate().map(one).collect()
}
