//! `summary.json`: what a program or a person needs to know of a run, without the arrays.

use serde::Serialize;
use serde_json::{Map, Value};

use super::Unresolved;
use crate::analyze::{
    Accuracy, Analysis, BandEdge, FrontLength, Headline, Scaling, Timing, Warning,
};
use crate::estimates::{NoiseFloor, SpectrumInterval};
use crate::field::Quantity;
use crate::prepare::WindowGains;

/// Version of the layout of `summary.json` and `spectra.npz`.
pub const SCHEMA: &str = "cascade.analyze/3";

/// Where a result came from.
#[derive(Debug, Clone, Serialize)]
pub struct Provenance {
    pub program: &'static str,
    pub version: &'static str,
    /// The command as typed, word by word.
    pub command: Vec<String>,
    pub input: Option<String>,
    /// BLAKE3 of the input file, hexadecimal.
    pub input_blake3: Option<String>,
    /// How the input was read, where it does not state it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub read_as: Vec<String>,
}

impl Provenance {
    /// Of this program, for `command` on `input`, whose content has this hash.
    pub fn new(command: Vec<String>, input: Option<String>, input_blake3: Option<String>) -> Self {
        Provenance {
            program: "cascade",
            version: env!("CARGO_PKG_VERSION"),
            command,
            input,
            input_blake3,
            read_as: Vec::new(),
        }
    }
}

/// What to do about a doubt, in the words of the caller.
pub type Advice<'a> = &'a dyn Fn(Doubt) -> Option<String>;

/// A reason for doubt, for which a caller may know a remedy.
#[derive(Debug, Clone, Copy)]
pub enum Doubt<'a> {
    Warning(&'a Warning),
    Unresolved(Unresolved),
}

/// The whole summary; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct Summary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    field: FieldSummary<'a>,
    conventions: ConventionsSummary<'a>,
    /// Of the temporal spectrum.
    interval: Option<SpectrumInterval>,
    /// What moved, where, and how sure.
    answer: Option<Value>,
    /// What was subtracted from spectra along time.
    noise: Option<Value>,
    parseval: ParsevalSummary,
    direction: Option<DirectionSummary>,
    low_high: LowHigh,
    accuracy: &'a Accuracy,
    timings: &'a [Timing],
    warnings: Vec<WarningSummary<'a>>,
}

#[derive(Debug, Serialize)]
struct FieldSummary<'a> {
    name: &'a str,
    /// `[times, sites]` analysed.
    shape: [usize; 2],
    /// First time row and first site of the file that were analysed.
    first: [usize; 2],
    t0: f64,
    dt: f64,
    x0: f64,
    dx: f64,
    units: Units<'a>,
    quantity: Quantity,
}

#[derive(Debug, Serialize)]
struct Units<'a> {
    /// `null`: not known, so the axis counts samples (sites).
    time: Option<&'a str>,
    space: Option<&'a str>,
    value: Option<&'a str>,
    frequency: String,
    wavenumber: String,
}

#[derive(Debug, Serialize)]
struct ConventionsSummary<'a> {
    sign: &'static str,
    sidedness: &'static str,
    frequency: &'static str,
    wavenumber: &'static str,
    scaling: Scaling,
    window: Windows<'a>,
    segment: usize,
    overlap: usize,
    segments: usize,
    transform_length: TransformLength,
}

#[derive(Debug, Serialize)]
struct Windows<'a> {
    time: &'a WindowGains,
    space: &'a WindowGains,
}

#[derive(Debug, Serialize)]
struct TransformLength {
    time: usize,
    space: usize,
}

#[derive(Debug, Serialize)]
struct ParsevalSummary {
    time: Option<f64>,
    space: Option<f64>,
    spacetime: Option<f64>,
}

#[derive(Debug, Serialize)]
struct DirectionSummary {
    toward_plus_x: Option<f64>,
    toward_minus_x: Option<f64>,
    undirected: Option<f64>,
    band: [f64; 2],
}

#[derive(Debug, Serialize)]
struct LowHigh {
    frequency: Option<Edge>,
    wavenumber: Option<Edge>,
    /// Share of the energy in the high band, at three sites and at three times.
    along_x: Option<Headline>,
    along_t: Option<Headline>,
    front_passage: Option<FrontSummary>,
}

/// Shares over the passage of the front.
#[derive(Debug, Serialize)]
struct FrontSummary {
    length: FrontLength,
    #[serde(flatten)]
    headline: Headline,
}

#[derive(Debug, Serialize)]
struct Edge {
    edge: Option<f64>,
    #[serde(flatten)]
    how: BandEdge,
}

#[derive(Debug, Serialize)]
struct WarningSummary<'a> {
    #[serde(skip)]
    of: &'a Warning,
    code: &'static str,
    message: String,
    /// How to resolve it, if the caller knows.
    #[serde(skip_serializing_if = "Option::is_none")]
    advice: Option<String>,
    numbers: Map<String, Value>,
}

impl<'a> Summary<'a> {
    /// Gathers the summary of `analysis`; computes nothing new.
    pub fn new(analysis: &'a Analysis, provenance: &'a Provenance) -> Self {
        let axes = &analysis.axes;
        let conventions = &analysis.conventions;
        let edge = |edge: Option<BandEdge>| {
            edge.map(|how| Edge {
                edge: defined(how.value()),
                how,
            })
        };
        Summary {
            schema: SCHEMA,
            provenance,
            field: FieldSummary {
                name: &analysis.name,
                shape: [axes.n_times, axes.n_sites],
                first: [analysis.offset.0, analysis.offset.1],
                t0: axes.time.origin,
                dt: axes.time.step,
                x0: axes.space.origin,
                dx: axes.space.step,
                units: Units {
                    time: axes.time.unit.as_deref(),
                    space: axes.space.unit.as_deref(),
                    value: analysis.unit.as_deref(),
                    frequency: axes.frequency_unit(),
                    wavenumber: axes.wavenumber_unit(),
                },
                quantity: analysis.quantity,
            },
            conventions: ConventionsSummary {
                sign: "plane wave exp(i (k x - 2 pi f t)): f > 0, k > 0 travels towards +x",
                sidedness: "one-sided in f, and in k for the spatial spectrum; bins doubled but \
                            for 0 and, at even lengths, Nyquist",
                frequency: "cycles per unit of time",
                wavenumber: "rad per unit of length",
                scaling: conventions.scaling,
                window: Windows {
                    time: &conventions.window_time,
                    space: &conventions.window_space,
                },
                segment: conventions.segment,
                overlap: conventions.overlap,
                segments: conventions.segments,
                transform_length: TransformLength {
                    time: conventions.padded_time,
                    space: conventions.padded_space,
                },
            },
            interval: analysis.interval,
            answer: super::answer::as_json(analysis),
            noise: analysis.noise.as_ref().map(NoiseFloor::numbers),
            parseval: ParsevalSummary {
                time: analysis.parseval.time,
                space: analysis.parseval.space,
                spacetime: analysis.parseval.spacetime,
            },
            direction: analysis.direction.map(|d| DirectionSummary {
                toward_plus_x: defined(d.toward_plus_x),
                toward_minus_x: defined(d.toward_minus_x),
                undirected: defined(d.undirected),
                band: [d.band.0, d.band.1],
            }),
            low_high: LowHigh {
                frequency: edge(analysis.frequency_edge),
                wavenumber: edge(analysis.wavenumber_edge),
                along_x: analysis
                    .along_space
                    .as_ref()
                    .map(|_| analysis.headline_space),
                along_t: analysis.along_time.as_ref().map(|_| analysis.headline_time),
                front_passage: analysis.front.as_ref().map(|front| FrontSummary {
                    length: front.length,
                    headline: front.headline,
                }),
            },
            accuracy: &analysis.accuracy,
            timings: &analysis.timings,
            warnings: analysis.warnings.iter().map(warning).collect(),
        }
    }

    /// The same with what the caller advises about each warning.
    pub fn with_advice(mut self, advice: Advice) -> Self {
        for warning in &mut self.warnings {
            warning.advice = advice(Doubt::Warning(warning.of));
        }
        self
    }

    /// The summary as indented JSON.
    ///
    /// # Errors
    /// None in practice: every part is plain data.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

fn defined(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

fn warning(warning: &Warning) -> WarningSummary<'_> {
    WarningSummary {
        of: warning,
        code: warning.code(),
        message: warning.message(),
        advice: None,
        numbers: warning.numbers(),
    }
}
