//! `summary.json` of an analysis.

use serde_json::{Value, json};

use super::super::{Analysis, BandEdge};
use super::answer;
use crate::estimates::NoiseFloor;

pub(super) fn of(analysis: &Analysis) -> Value {
    let (axes, conventions) = (&analysis.axes, &analysis.conventions);
    let edge = |edge: Option<BandEdge>| {
        edge.map(|how| {
            let mut numbers = json!(how);
            numbers["edge"] = json!(how.value());
            numbers
        })
    };
    let along_x = analysis
        .along_space
        .as_ref()
        .map(|_| analysis.headline_space);
    let along_t = analysis.along_time.as_ref().map(|_| analysis.headline_time);
    let front = analysis.front.as_ref().map(|front| {
        let mut numbers = json!(front.headline);
        numbers["length"] = json!(front.length);
        numbers
    });
    json!({
        "field": {
            "name": analysis.name,
            "shape": [axes.n_times, axes.n_sites],
            // Of the file.
            "first": analysis.offset,
            "t0": axes.time.origin,
            "dt": axes.time.step,
            "x0": axes.space.origin,
            "dx": axes.space.step,
            "units": {
                // Null: not known, so the axis counts samples (sites).
                "time": axes.time.unit,
                "space": axes.space.unit,
                "value": analysis.unit,
                "frequency": axes.frequency_unit(),
                "wavenumber": axes.wavenumber_unit(),
            },
            "quantity": analysis.quantity,
        },
        "conventions": {
            "sign": "plane wave exp(i (k x - 2 pi f t)): f > 0, k > 0 travels towards +x",
            "sidedness": "one-sided in f, and in k for the spatial spectrum; bins doubled but for 0 and, at even \
                          lengths, Nyquist",
            "frequency": "cycles per unit of time",
            "wavenumber": "rad per unit of length",
            "scaling": conventions.scaling,
            "window": {
                "time": conventions.window_time,
                "space": conventions.window_space,
            },
            "segment": conventions.segment,
            "overlap": conventions.overlap,
            "segments": conventions.segments,
            "transform_length": {
                "time": conventions.padded_time,
                "space": conventions.padded_space,
            },
        },
        "interval": analysis.interval,
        "moved": answer::numbers(analysis),
        "noise": analysis.noise.as_ref().map(NoiseFloor::numbers),
        "parseval": {
            "time": analysis.parseval.time,
            "space": analysis.parseval.space,
            "spacetime": analysis.parseval.spacetime,
        },
        "direction": analysis.direction.map(|direction| json!({
            "toward_plus_x": direction.toward_plus_x,
            "toward_minus_x": direction.toward_minus_x,
            "undirected": direction.undirected,
            "band": direction.band,
        })),
        "low_high": {
            "frequency": edge(analysis.frequency_edge),
            "wavenumber": edge(analysis.wavenumber_edge),
            "along_x": along_x,
            "along_t": along_t,
            "front_passage": front,
        },
        "accuracy": analysis.accuracy,
        "timings": analysis.timings,
    })
}
