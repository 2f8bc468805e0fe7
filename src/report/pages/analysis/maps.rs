//! Maps of an analysis.

use ndarray::{ArrayView2, s};

use super::words;
use crate::analyze::{Analysis, DispersionCurve, ShortTimeSpectrum};
use crate::moved::{Answer, Movement};
use crate::plot::labels::{self, Side};
use crate::plot::{self, Short};
use crate::report::page::{AxisData, MapData, number};
use crate::sheet::edges;

/// Largest embedded short-time map, bins by frames.
const SHORT_LIMIT: (usize, usize) = (256, 400);

/// The maps whose results are present.
pub(super) fn of(analysis: &Analysis) -> Vec<MapData> {
    let second = labels::wavenumber_reading(&analysis.axes);
    let mut maps = Vec::new();
    for kind in &plot::MAPS {
        if let Some(map) = (kind.map)(analysis) {
            let [x, y] = kind.sides.map(Side::role);
            let data = MapData::of(map, kind.id, kind.title, kind.shows, (x, y));
            maps.push(data.limited(labels::not_shown(analysis, &kind.sides, true)));
        }
    }
    for short in [Short::in_time(analysis), Short::in_space(analysis)]
        .into_iter()
        .flatten()
    {
        let spectra = short.spectra.spectra.iter().enumerate();
        maps.extend(spectra.map(|(index, one)| short_map(analysis, &short, index, one)));
    }
    // The line of a map is that of the verdict.
    let past = |of: fn(&Answer) -> &Movement| analysis.answer.as_ref().and_then(|a| of(a).past());
    let [frequency, wavenumber] = [past(|a| &a.frequency), past(|a| &a.wavenumber)];
    let annotated = maps.into_iter().map(|mut map| {
        match &map.id[..] {
            "temporal" => map.interval = analysis.interval.and_then(|it| it.factors),
            "spatial" | "flux" => map.along = "x",
            "spacetime" => map.draw_over(&DispersionCurve::curves(&analysis.dispersion)),
            _ => {}
        }
        map.annotated(frequency, wavenumber, &second)
    });
    annotated.collect()
}

fn short_map(
    analysis: &Analysis,
    short: &Short,
    index: usize,
    spectrum: &ShortTimeSpectrum,
) -> MapData {
    let spectra = short.spectra;
    // Each map has a scale of its own, which would show the errors of a site that is not reached.
    let error = analysis.sample_error.unwrap_or(0.0);
    let least = error * error * spectra.largest();
    let known = |value: f64| if value >= least { value } else { f64::NAN };
    let blocks = |values: ArrayView2<f64>| {
        plot::block_extremes(values, SHORT_LIMIT.0, SHORT_LIMIT.1).mapv(known)
    };
    let (name, at) = (words::title(short.id), short.at.label(&analysis.axes));
    let title = format!("{name} at {at} = {}", number(spectrum.at));
    let axis = |side: Side, centres: &[f64]| {
        AxisData::new(&side.label(&analysis.axes), edges(centres), side.role())
    };
    let [content, along] = short.sides;
    let map = MapData::spectrum(
        (format!("{}-{index}", short.id), title),
        words::short_caption(short.id, spectra),
        [axis(along, &spectra.frames), axis(content, &spectra.bins)],
        &short.quantity,
        blocks(spectrum.values.view()).view(),
    );
    let Some(not_shown) = labels::not_shown(analysis, &short.sides, false) else {
        return map;
    };
    let within = |side: Side, centres| plot::within(centres, side.extent(analysis));
    let bins = within(content, &spectra.bins);
    let frames = within(along, &spectra.frames);
    let ends = [
        edges(&spectra.frames[frames.clone()]),
        edges(&spectra.bins[bins.clone()]),
    ];
    let part = blocks(spectrum.values.slice(s![bins, frames]));
    map.with_detail(ends, part.view()).limited(Some(not_shown))
}
