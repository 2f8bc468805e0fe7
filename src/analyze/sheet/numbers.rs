//! `summary.json` of an analysis.

use serde_json::{Value, json};

use super::super::{Analysis, Moments};
use crate::estimates::NoiseFloor;
use crate::moved::{Answer, Evidence, Move, Movement, Place};

pub(super) fn of(analysis: &Analysis) -> Value {
    let (axes, conventions) = (&analysis.axes, &analysis.conventions);
    let units = axes.units();
    let edge = |of: &Moments| with(json!(of.edge), "edge", of.edge.value());
    let [along_x, along_t] = [&analysis.along_space, &analysis.along_time].map(Option::as_ref);
    let front = analysis.front.as_ref();
    let front = front.map(|front| with(json!(front.headline), "length", front.length));
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
                "frequency": units.frequency,
                "wavenumber": units.wavenumber,
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
        "moved": analysis.answer.as_ref().map(|answer| moved(analysis, answer)),
        "noise": analysis.noise.as_ref().map(NoiseFloor::numbers),
        "parseval": analysis.parseval,
        "direction": analysis.direction,
        "low_high": {
            "frequency": along_x.map(edge),
            "wavenumber": along_t.map(edge),
            "along_x": along_x.map(|of| of.headline),
            "along_t": along_t.map(|of| of.headline),
            "front_passage": front,
        },
        "accuracy": analysis.accuracy,
        "timings": analysis.timings,
    })
}

/// With one more member.
fn with(mut numbers: Value, name: &str, value: impl serde::Serialize) -> Value {
    numbers[name] = json!(value);
    numbers
}

/// `moved`. Frequencies and wavenumbers are in the units of the axes, sites count in the file.
fn moved(analysis: &Analysis, answer: &Answer) -> Value {
    let sites: Ends = [|of| json!(of.rows[0]), |of| json!(of.rows[1])];
    let times: Ends = [|of| json!(of.at); 2];
    let along_x = movement(&answer.frequency, sites);
    let along_x = with(along_x, "profile", answer.along_x.as_ref().map(profile));
    let launch = answer.launch.as_ref().map(|of| movement(of, sites));
    let in_time = movement(&answer.wavenumber, times);
    let reason = analysis.undirected.map(|reason| reason.message());
    let told = analysis.direction_of_waves();
    let direction = analysis.direction.map(|_| {
        json!({
            "toward_plus_x": told.map(|of| of.toward_plus_x),
            "toward_minus_x": told.map(|of| of.toward_minus_x),
            "speed": answer.speed,
            "reason": reason,
        })
    });
    json!({
        "frequency": with(along_x, "launch", launch),
        "wavenumber": with(in_time, "profile", answer.along_t.as_ref().map(profile)),
        "front": answer.front,
        "periodic": answer.is_periodic,
        "direction": direction,
    })
}

/// Where the first and the last place are.
type Ends = [fn(&Place) -> Value; 2];

fn movement(of: &Movement, [first, last]: Ends) -> Value {
    let why = of.reason.map(|reason| reason.parts());
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
        "reason": why.as_ref().map(|(_, reason, _)| reason),
        "reason_code": why.as_ref().map(|(code, ..)| code),
        "advice": why.as_ref().map(|(.., advice)| advice),
    })
}

/// Up and down from the first group to each; errors are halves of 95 % intervals.
fn profile(evidence: &Evidence) -> Value {
    let groups = &evidence.groups;
    let of = |way: usize, part: fn(&Move) -> f64| -> Vec<f64> {
        evidence.moves.iter().map(|both| part(&both[way])).collect()
    };
    json!({
        "position": groups.iter().map(|group| group.place.at).collect::<Vec<_>>(),
        "rows": groups.iter().map(|group| group.place.rows).collect::<Vec<_>>(),
        "up": of(0, |of| of.share),
        "up_error": of(0, |of| of.error),
        "down": of(1, |of| of.share),
        "down_error": of(1, |of| of.error),
        "energy": groups.iter().map(|group| group.energy).collect::<Vec<_>>(),
    })
}
