//! Maps of an analysis.

use ndarray::{ArrayView2, s};

use super::words;
use crate::analyze::{Analysis, Map, ShortTimeSpectra, ShortTimeSpectrum};
use crate::moved::{Answer, Movement};
use crate::plot;
use crate::plot::labels::{self, Side};
use crate::report::page::{AxisData, MapData, Role, number};
use crate::sheet::edges;

/// Largest embedded short-time map, bins by frames.
const SHORT_LIMIT: (usize, usize) = (256, 400);

/// The maps whose results are present.
pub(super) fn of(analysis: &Analysis) -> Vec<MapData> {
    let second = labels::wavenumber_reading(&analysis.axes);
    let mut maps = Vec::new();
    let mut add = |id, map: &Option<Map>, sides: [Side; 2]| {
        let Some(map) = map else { return };
        let [x, y] = sides.map(role);
        let data = MapData::of(map, id, words::title(id), words::shows(id), (x, y));
        maps.push(data.limited(labels::not_shown(analysis, &sides, true)));
    };
    add("field", &analysis.field_map, [Side::Space, Side::Time]);
    add(
        "spacetime",
        &analysis.spacetime_map,
        [Side::SignedWavenumber, Side::Frequency],
    );
    add(
        "temporal",
        &analysis.temporal_map,
        [Side::Space, Side::Frequency],
    );
    let over_time = [Side::Wavenumber, Side::Time];
    add("spatial", &analysis.spatial_map, over_time);
    add("flux", &analysis.flux_map, over_time);
    maps.extend(short_time(analysis));
    maps.extend(short_space(analysis));
    // The line of a map is that of the verdict.
    let past = |of: fn(&Answer) -> &Movement| analysis.answer.as_ref().and_then(|a| of(a).past());
    let [frequency, wavenumber] = [past(|a| &a.frequency), past(|a| &a.wavenumber)];
    let interval = analysis.interval.and_then(|interval| interval.factors);
    let annotated = maps.into_iter().map(|map| match &map.id[..] {
        "temporal" => map.with_interval(interval),
        "spatial" | "flux" => map.along_x(),
        "spacetime" => map.with_dispersion(&analysis.dispersion),
        _ => map,
    });
    annotated
        .map(|map| map.annotated(frequency, wavenumber, &second))
        .collect()
}

fn role(side: Side) -> Role {
    match side {
        Side::Time => Role::Time,
        Side::Space => Role::Position,
        Side::Frequency => Role::Frequency,
        Side::Wavenumber | Side::SignedWavenumber => Role::Wavenumber,
    }
}

fn short_time(analysis: &Analysis) -> Vec<MapData> {
    let axes = &analysis.axes;
    let quantity = labels::short_time_density(analysis);
    let along = (labels::time(axes), Side::Time);
    let content = (labels::frequency(axes), Side::Frequency);
    let at = labels::position(axes);
    match &analysis.short_time {
        Some(spectra) => ShortMaps {
            analysis,
            id: "short-time",
            spectra,
            quantity,
            along,
            content,
            at,
        }
        .all(),
        None => Vec::new(),
    }
}

fn short_space(analysis: &Analysis) -> Vec<MapData> {
    let axes = &analysis.axes;
    let quantity = labels::short_space_density(analysis);
    let along = (labels::position(axes), Side::Space);
    let content = (labels::wavenumber(axes), Side::Wavenumber);
    let at = labels::time(axes);
    match &analysis.short_space {
        Some(spectra) => ShortMaps {
            analysis,
            id: "short-space",
            spectra,
            quantity,
            along,
            content,
            at,
        }
        .all(),
        None => Vec::new(),
    }
}

/// Short-time spectra, and what their maps are called.
struct ShortMaps<'a> {
    analysis: &'a Analysis,
    id: &'a str,
    spectra: &'a ShortTimeSpectra,
    quantity: String,
    /// Labels of the axes of frames and of bins.
    along: (String, Side),
    content: (String, Side),
    /// What the spectra are at.
    at: String,
}

impl ShortMaps<'_> {
    fn all(&self) -> Vec<MapData> {
        let spectra = self.spectra.spectra.iter().enumerate();
        spectra.map(|(index, one)| self.map(index, one)).collect()
    }

    fn map(&self, index: usize, spectrum: &ShortTimeSpectrum) -> MapData {
        let (analysis, spectra) = (self.analysis, self.spectra);
        let [along, content] = [&self.along, &self.content];
        // Each map has a scale of its own, which would show the errors of a site that is not reached.
        let error = analysis.sample_error.unwrap_or(0.0);
        let least = error * error * spectra.largest();
        let known = |value: f64| if value >= least { value } else { f64::NAN };
        let blocks = |values: ArrayView2<f64>| {
            plot::block_extremes(values, SHORT_LIMIT.0, SHORT_LIMIT.1).mapv(known)
        };
        let name = words::title(self.id);
        let title = format!("{name} at {} = {}", self.at, number(spectrum.at));
        let axis = |(label, side): &(String, Side), centres: &[f64]| {
            AxisData::new(label, edges(centres), role(*side))
        };
        let map = MapData::spectrum(
            (format!("{}-{index}", self.id), title),
            words::short_caption(self.id, spectra),
            [axis(along, &spectra.frames), axis(content, &spectra.bins)],
            &self.quantity,
            blocks(spectrum.values.view()).view(),
        );
        let sides = [content.1, along.1];
        let Some(not_shown) = labels::not_shown(analysis, &sides, false) else {
            return map;
        };
        let within = |side: Side, centres| plot::within(centres, side.extent(analysis));
        let bins = within(content.1, &spectra.bins);
        let frames = within(along.1, &spectra.frames);
        let ends = [
            edges(&spectra.frames[frames.clone()]),
            edges(&spectra.bins[bins.clone()]),
        ];
        let part = blocks(spectrum.values.slice(s![bins, frames]));
        map.with_detail(ends, part.view()).limited(Some(not_shown))
    }
}
