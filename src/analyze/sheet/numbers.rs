//! `summary.json` of an analysis.

use serde_json::{Value, json};

use super::super::{Analysis, BandEdge};
use super::answer::Words;
use crate::estimates::NoiseFloor;
use crate::moved::{Evidence, Move, Movement, Place, Reason};

pub(super) fn of(analysis: &Analysis) -> Value {
    let (axes, conventions) = (&analysis.axes, &analysis.conventions);
    let edge = |edge: Option<BandEdge>| {
        edge.map(|how| {
            let mut numbers = json!(how);
            numbers["edge"] = json!(how.value());
            numbers
        })
    };
    let (along_x, along_t) = (&analysis.along_space, &analysis.along_time);
    let along_x = along_x.as_ref().map(|_| analysis.headline_space);
    let along_t = along_t.as_ref().map(|_| analysis.headline_time);
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
        "moved": Words::of(analysis).as_ref().map(moved),
        "noise": analysis.noise.as_ref().map(NoiseFloor::numbers),
        "parseval": analysis.parseval,
        "direction": analysis.direction,
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

/// `moved`. Frequencies and wavenumbers are in the units of the axes, sites count in the file.
fn moved(words: &Words) -> Value {
    let answer = words.answer;
    let site = |place: &Place| json!(place.rows[0]);
    let last_site = |place: &Place| json!(place.rows[1]);
    let time = |place: &Place| json!(place.at);
    let along_x = |of: &Movement| movement(of, &site, &last_site, &|reason| words.why(reason));
    let mut frequency = along_x(&answer.frequency);
    frequency["launch"] = json!(answer.launch.as_ref().map(along_x));
    frequency["profile"] = json!(answer.along_x.as_ref().map(profile));
    let mut wavenumber = movement(&answer.wavenumber, &time, &time, &Reason::parts);
    wavenumber["profile"] = json!(answer.along_t.as_ref().map(profile));
    let reason = words.undirected();
    let told = |share: f64| reason.is_none().then_some(share);
    let direction = words.direction.map(|direction| {
        json!({
            "toward_plus_x": told(direction.toward_plus_x),
            "toward_minus_x": told(direction.toward_minus_x),
            "speed": answer.speed,
            "reason": reason,
        })
    });
    json!({
        "frequency": frequency,
        "wavenumber": wavenumber,
        "front": answer.front,
        "periodic": answer.is_periodic,
        "direction": direction,
    })
}

fn movement<'w>(
    of: &Movement,
    first: &dyn Fn(&Place) -> Value,
    last: &dyn Fn(&Place) -> Value,
    why: &dyn Fn(&Reason) -> (&'w str, String, &'w str),
) -> Value {
    let why = of.reason.as_ref().map(why);
    let reason = why.as_ref().map(|(_, reason, _)| reason);
    let most = of.moves().then(|| {
        let most = of.most();
        json!({
            "share": most.share,
            "error": most.error,
            "at": most.at,
            "rows": of.to.map(|place| place.rows),
            "position": of.to.map(|place| place.at),
        })
    });
    let at_end = of.at_end.map(|[up, down]| {
        json!({
            "up": up.share,
            "up_error": up.error,
            "down": down.share,
            "down_error": down.error,
        })
    });
    json!({
        "verdict": of.verdict,
        "up": of.up.share,
        "up_error": of.up.error,
        "up_at": of.up.at,
        "down": of.down.share,
        "down_error": of.down.error,
        "down_at": of.down.at,
        "most": most,
        "at_end": at_end,
        "fate": of.fate,
        "bound": of.bound,
        "transfer": of.transfer,
        "lags": of.lags,
        "energy_ratio": of.energy_ratio,
        "from": of.from.as_ref().map(first),
        "to": of.to.as_ref().map(last),
        "from_rows": of.from.map(|place| place.rows),
        "to_rows": of.to.map(|place| place.rows),
        "reason": reason,
        "reason_code": why.as_ref().map(|(code, ..)| code),
        "advice": why.as_ref().map(|(.., advice)| advice),
    })
}

/// Up and down from the first group to each; errors are halves of 95 % intervals.
fn profile(evidence: &Evidence) -> Value {
    let moves = |way: usize, of: fn(&Move) -> f64| -> Vec<f64> {
        evidence.moves.iter().map(|both| of(&both[way])).collect()
    };
    let groups = || evidence.groups.iter();
    let rows: Vec<[usize; 2]> = groups().map(|group| group.place.rows).collect();
    json!({
        "position": groups().map(|group| group.place.at).collect::<Vec<_>>(),
        "rows": rows,
        "up": moves(0, |of| of.share),
        "up_error": moves(0, |of| of.error),
        "down": moves(1, |of| of.share),
        "down_error": moves(1, |of| of.error),
        "energy": groups().map(|group| group.energy).collect::<Vec<_>>(),
    })
}
