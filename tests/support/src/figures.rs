//! Analyses made by hand, to draw: plausible pictures, no physics.

use std::f64::consts::{PI, TAU};

use ndarray::Array2;
use wavecascade::Field;
use wavecascade::analyze::*;
use wavecascade::field::Axis;
use wavecascade::plot::{Figure, Style, figures_of};
use wavecascade::prepare::{Window, WindowGains};

/// The figures of an analysis.
pub fn drawn(analysis: &Analysis, style: &Style) -> Vec<Figure> {
    figures_of(
        analysis,
        &analysis.words(),
        &analysis.name,
        "analyze",
        style,
    )
}

/// The one of this name.
pub fn figure(analysis: &Analysis, name: &str, style: &Style) -> Figure {
    let mut all = drawn(analysis, style).into_iter();
    all.find(|figure| figure.name() == name).expect(name)
}

/// A pulse that slows down and breaks into high frequencies, 400 times by 300 sites.
pub fn full() -> Analysis {
    let (n_times, n_sites) = (400, 300);
    let base = analyzed(n_times, n_sites);
    let axes = base.axes.clone();
    let (rows, columns) = (n_times as f64, n_sites as f64);
    let high = 0.5 / axes.time.step;
    let k_high = PI / axes.space.step;
    let field = picture(n_times, n_sites, |t, x| {
        let lag = t - 0.9 * x - 0.05;
        (-(lag * 30.0).powi(2)).exp() + 0.3 * (-(lag * 6.0 - 1.0).powi(2)).exp() * wave(lag, x)
    });
    let temporal = picture(200, n_sites, |f, x| {
        1e-3 * (10f64.powf(-9.0 * f * (1.1 - x)) + 1e-3 * bump(f - 0.45 - 0.1 * x, 0.05) * x)
            * speckle(f, x)
    });
    let spatial = picture(n_times, 150, |t, k| {
        2e-2 * (10f64.powf(-6.0 * k * (1.0 - 0.7 * t)) + 1e-2 * bump(k - 0.7, 0.08) * t)
            * speckle(k, t)
    });
    let spacetime = picture(200, n_sites, |f, k| {
        let k = 2.0 * k - 1.0;
        let ridge = bump(f - 0.8 * (0.5 * PI * k.abs()).sin(), 0.02);
        let side = if k > 0.0 { 1.0 } else { 0.02 };
        (ridge * side + 1e-9) * 10f64.powf(-3.0 * f) * speckle(f, k)
    });
    let flux = picture(n_times, 150, |t, k| {
        (bump(t - 0.3, 0.1) - 0.6 * bump(t - 0.6, 0.08)) * (PI * k).sin() * (1.0 + 0.2 * wave(t, k))
    });
    let map = |values, x: (&str, f64, f64), y: (&str, f64, f64), label: &str| Map {
        values,
        x: map_axis(x),
        y: map_axis(y),
        reduction: Reduction::Max {
            rows: 8,
            columns: 1,
        },
        range: None,
        label: label.into(),
        detail: None,
    };
    let time = ("time (s)", 0.0, rows * axes.time.step);
    let position = ("position (m)", 0.0, columns * axes.space.step);
    let frequency = ("frequency (Hz)", 0.0, high);
    let wavenumber = ("wavenumber (rad/m)", 0.0, k_high);
    let signed = ("wavenumber (rad/m)", -k_high, k_high);
    Analysis {
        direction: Some(Direction {
            toward_plus_x: 0.912,
            toward_minus_x: 0.071,
            undirected: 0.017,
            band: (0.0, high),
        }),
        answer: None,
        undirected: None,
        direction_by_frequency: Some(directions(axes.frequency.len())),
        frequency_edge: Some(BandEdge::Reference {
            value: 0.12 * high,
            index: 0,
            at: 0.0,
        }),
        wavenumber_edge: Some(BandEdge::Given {
            value: 0.3 * k_high,
        }),
        along_space: Some(moments(n_sites, high)),
        along_time: Some(moments(n_times, k_high)),
        headline_space: headline(n_sites),
        headline_time: headline(n_times),
        front: Some(front(n_sites)),
        field_map: Some(Map {
            reduction: Reduction::Extreme {
                rows: 8,
                columns: 1,
            },
            range: None,
            ..map(field, position, time, "velocity (m/s)")
        }),
        temporal_map: Some(map(
            temporal,
            position,
            frequency,
            "energy spectral density [(m/s)² s/Hz]",
        )),
        spatial_map: Some(map(
            spatial,
            wavenumber,
            time,
            "energy spectral density [(m/s)² m/(rad/m)]",
        )),
        spacetime_map: Some(map(
            spacetime,
            signed,
            frequency,
            "energy spectral density [(m/s)² s m/(Hz · rad/m)]",
        )),
        flux_map: Some(map(
            flux,
            wavenumber,
            time,
            "kinetic flux surrogate per unit mass [(m/s)² m/s]",
        )),
        dispersion: vec![DispersionCurve {
            name: "340 <m/s> & \"free\"".into(),
            wavenumber: vec![-k_high, 0.0, k_high],
            branches: vec![vec![340.0 * k_high / TAU, 0.0, f64::NAN]],
        }],
        short_time: Some(short(
            &base.conventions.window_time,
            &axes.frequency,
            (0.0, axes.time.step * rows),
            &[0.0, 1.5, 2.99],
        )),
        short_space: Some(short(
            &base.conventions.window_time,
            &axes.wavenumber,
            (0.0, axes.space.step * columns),
            &[0.05, 0.2],
        )),
        sample_error: None,
        display: Display::whole(&axes),
        warnings: vec![
            Warning::new(
                "3.40 % of the energy lies above frequency 0.4500",
                "sample faster",
            ),
            Warning::new(
                "sites 17, 18 at 0.34, 0.36 m: constant",
                "check the sensors",
            ),
        ],
        ..base
    }
}

/// What is no picture: axes, conventions and accuracies.
fn analyzed(n_times: usize, n_sites: usize) -> Analysis {
    let axis = |step, unit: &str| Axis {
        origin: 0.0,
        step,
        unit: Some(unit.into()),
    };
    let mut field = Field::from_array(Array2::from_shape_fn((n_times, n_sites), |(n, j)| {
        bump(n as f64 / 400.0 - 0.9 * j as f64 / 300.0 - 0.05, 0.03)
    }));
    (field.time, field.space) = (axis(1e-3, "s"), axis(0.01, "m"));
    field.name = "chirp <& \"friends\"> 'n' \u{3ba}=4.5.npy".into();
    field.content_hash = Some("7f".repeat(32));
    field.unit = Some("m/s".into());
    let request = Request {
        window_time: Window::Hann,
        window_space: Window::Hann,
        maps: false,
        ..Request::default()
    };
    analyze(&field, &request).unwrap().0
}

/// Analyses at the edges of what can be drawn, with their names.
pub fn degenerate() -> Vec<(&'static str, Analysis)> {
    let shapes = [
        ("1x1", 1, 1),
        ("1xN", 1, 40),
        ("Nx1", 40, 1),
        ("empty", 0, 0),
    ];
    let mut cases: Vec<(&str, Analysis)> = shapes
        .map(|(name, rows, columns)| (name, uniform(rows, columns, 2.5)))
        .into();
    cases.push(("zero", uniform(12, 9, 0.0)));
    cases.push(("constant", uniform(12, 9, -3.0)));
    cases.push(("undefined", uniform(12, 9, f32::NAN)));
    cases.push(("infinite", uniform(12, 9, f32::INFINITY)));
    cases.push(("tiny", uniform(12, 9, f32::from_bits(1))));
    let mut huge = uniform(12, 9, f32::MAX);
    huge.axes.time.origin = 1.7e9;
    huge.axes.time.step = 1e-3;
    huge.field_map.as_mut().unwrap().y = map_axis(("time (s)", 1.7e9, 1.7e9 + 12e-3));
    huge.temporal_map.as_mut().unwrap().x = map_axis(("site", f64::NAN, f64::NAN));
    cases.push(("huge", huge));
    cases
}

/// Only the field was asked for.
pub fn field_only() -> Analysis {
    Analysis {
        direction: None,
        direction_by_frequency: None,
        frequency_edge: None,
        wavenumber_edge: None,
        along_space: None,
        along_time: None,
        headline_space: Headline::default(),
        headline_time: Headline::default(),
        front: None,
        temporal_map: None,
        spatial_map: None,
        spacetime_map: None,
        flux_map: None,
        dispersion: Vec::new(),
        short_time: None,
        short_space: None,
        sample_error: None,
        warnings: Vec::new(),
        ..full()
    }
}

/// Every map and curve of one value, without units.
fn uniform(rows: usize, columns: usize, value: f32) -> Analysis {
    let map = |x: &str, y: &str| Map {
        values: Array2::from_elem((rows, columns), value),
        x: map_axis((x, 0.0, columns as f64)),
        y: map_axis((y, 0.0, rows as f64)),
        reduction: Reduction::Max {
            rows: 1,
            columns: 1,
        },
        range: None,
        label: "value".into(),
        detail: None,
    };
    let level = |n: usize| {
        let all = vec![f64::from(value); n];
        Moments {
            centroid: all.clone(),
            bandwidth: all.clone(),
            effective_bandwidth: all.clone(),
            zero_share: all.clone(),
            entropy: all.clone(),
            participation: all.clone(),
            median: all.clone(),
            quantile_90: all.clone(),
            low_share: all.clone(),
            high_share: all.clone(),
            energy: all,
        }
    };
    let full = full();
    let one = ShortTimeSpectrum {
        index: 0,
        at: 0.0,
        values: Array2::from_elem((rows, columns), f64::from(value)),
    };
    let short = ShortTimeSpectra {
        bins: (0..rows).map(|m| m as f64).collect(),
        frames: (0..columns).map(|m| m as f64).collect(),
        segment: 1,
        hop: 1,
        window: full.conventions.window_time.clone(),
        spectra: vec![one; 5],
    };
    let axes = Axes {
        time: Axis::index(),
        n_times: rows,
        space: Axis::index(),
        n_sites: columns,
        frequency: (0..rows).map(|m| m as f64).collect(),
        wavenumber: (0..columns).map(|m| m as f64).collect(),
        wavenumber_signed: (0..columns).map(|m| m as f64).collect(),
    };
    Analysis {
        unit: None,
        display: Display::whole(&axes),
        axes,
        direction: Some(Direction {
            toward_plus_x: f64::NAN,
            toward_minus_x: f64::NAN,
            undirected: f64::NAN,
            band: (0.0, 0.0),
        }),
        direction_by_frequency: Some([vec![f64::NAN; rows], vec![f64::NAN; rows]]),
        frequency_edge: Some(BandEdge::Undefined),
        wavenumber_edge: Some(BandEdge::Undefined),
        along_space: Some(level(columns)),
        along_time: Some(level(rows)),
        headline_space: Headline::default(),
        headline_time: Headline::default(),
        front: None,
        field_map: Some(map("site", "time (samples)")),
        temporal_map: Some(map("site", "frequency (cycles/sample)")),
        spatial_map: Some(map("wavenumber (rad/site)", "time (samples)")),
        spacetime_map: Some(map("wavenumber (rad/site)", "frequency (cycles/sample)")),
        flux_map: Some(map("wavenumber (rad/site)", "time (samples)")),
        short_time: Some(short.clone()),
        short_space: Some(short),
        sample_error: None,
        warnings: vec![Warning::new(
            "the prepared field is zero everywhere",
            "check the range",
        )],
        ..full
    }
}

fn map_axis((label, low, high): (&str, f64, f64)) -> MapAxis {
    MapAxis {
        label: label.into(),
        low,
        high,
    }
}

/// `value(y, x)` over the unit square; the last column and one block hold no value.
fn picture(rows: usize, columns: usize, value: impl Fn(f64, f64) -> f64) -> Array2<f32> {
    Array2::from_shape_fn((rows, columns), |(i, j)| {
        let (y, x) = (i as f64 / rows as f64, j as f64 / columns as f64);
        if (0.82..0.86).contains(&x) && (0.7..0.8).contains(&y) {
            f32::NAN
        } else {
            value(y, x) as f32
        }
    })
}

fn directions(n: usize) -> [Vec<f64>; 2] {
    let plus = |m: usize| {
        let f = m as f64 / n as f64;
        if f > 0.9 {
            f64::NAN
        } else {
            0.95 - 0.3 * f + 0.03 * (60.0 * f).sin()
        }
    };
    let both: Vec<f64> = (0..n).map(plus).collect();
    let minus = both.iter().map(|share| 0.98 - share).collect();
    [both, minus]
}

fn moments(n: usize, high: f64) -> Moments {
    let curve = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (0..n)
            .map(|j| match j as f64 / n as f64 {
                x if (0.5..0.52).contains(&x) => f64::NAN,
                x => f(x),
            })
            .collect()
    };
    let ripple = |x: f64| 1.0 + 0.04 * (90.0 * x).sin();
    let low_share = curve(&|x| 0.9 - 0.45 * x * ripple(x));
    Moments {
        centroid: curve(&|x| high * (0.07 + 0.2 * x) * ripple(x)),
        bandwidth: curve(&|x| high * (0.05 + 0.1 * x)),
        effective_bandwidth: curve(&|x| high * (0.08 + 0.2 * x)),
        zero_share: curve(&|x| 0.1 - 0.05 * x),
        entropy: curve(&|x| 0.4 + 0.3 * x),
        participation: curve(&|x| 10.0 + 30.0 * x),
        median: curve(&|x| high * (0.05 + 0.15 * x) * ripple(x)),
        quantile_90: curve(&|x| high * (0.12 + 0.5 * x) * ripple(x)),
        high_share: low_share.iter().map(|share| 1.0 - share).collect(),
        low_share,
        energy: curve(&|x| 3e-4 * (-4.0 * x).exp() * ripple(x)),
    }
}

/// At the first row, in the middle and at the last one.
fn headline(n: usize) -> Headline {
    let spot = |row: usize, share: f64| {
        Some(Spot {
            index: row,
            at: row as f64,
            high_share: Some(share),
        })
    };
    Headline {
        reference: spot(0, 0.1),
        largest: spot(n / 3, 0.251),
        last: spot(n - 1, 0.2),
    }
}

fn front(n: usize) -> Front {
    let high_share: Vec<f64> = (0..n).map(|j| 0.1 + 0.3 * j as f64 / n as f64).collect();
    Front {
        length: Some(FrontWindow {
            window: 0.02,
            samples: 40,
            pulse_width: Some(0.002),
        }),
        arrival: (0..n).map(|j| 1e-3 * j as f64).collect(),
        fits: vec![true; n],
        high_share,
        headline: headline(n),
    }
}

fn short(
    window: &WindowGains,
    bins: &[f64],
    (from, to): (f64, f64),
    at: &[f64],
) -> ShortTimeSpectra {
    let bins: Vec<f64> = bins.iter().step_by(2).copied().collect();
    let frames: Vec<f64> = (0..60)
        .map(|m| from + (to - from) * (m as f64 + 2.0) / 64.0)
        .collect();
    let spectra = at
        .iter()
        .enumerate()
        .map(|(index, &at)| {
            let delay = 0.15 + 0.25 * index as f64;
            let values = Array2::from_shape_fn((bins.len(), frames.len()), |(i, j)| {
                let (f, t) = (i as f64 / bins.len() as f64, j as f64 / 60.0);
                1e-4 * bump(t - delay - 0.1 * f, 0.1) * 10f64.powf(-4.0 * f) * speckle(f, t) + 1e-13
            });
            ShortTimeSpectrum { index, at, values }
        })
        .collect();
    ShortTimeSpectra {
        bins,
        frames,
        segment: 64,
        hop: 16,
        window: window.clone(),
        spectra,
    }
}

fn bump(x: f64, width: f64) -> f64 {
    (-(x / width).powi(2)).exp()
}

fn wave(t: f64, x: f64) -> f64 {
    (2.0 * PI * 40.0 * t * (1.0 + x)).sin()
}

/// A fixed, positive, irregular factor.
fn speckle(x: f64, y: f64) -> f64 {
    let hash = ((x * 127.1 + y * 311.7).sin() * 43758.5453).fract().abs();
    0.1 - (1.0 - hash).max(1e-6).ln()
}
