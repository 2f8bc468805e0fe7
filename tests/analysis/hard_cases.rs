//! Fields that break careless spectra: short, long, constant, huge, tiny, offset, with holes.

use ndarray::{Array2, s};
use test_support::changed;
use test_support::fields::{TEMPORAL, asking, noise, option, segments};
use wavecascade::analyze::{Analysis, Request, Scaling, TimeRange};
use wavecascade::arrays::{Arrays, LargeArray, Precision};
use wavecascade::estimates::{
    IncrementsRequest, ModesRequest, SpectrumRequest, increments, modes, spectrum,
};
use wavecascade::field::Axis;
use wavecascade::observer::Silent;
use wavecascade::prepare::{Detrend, Window};
use wavecascade::reference::Grid;
use wavecascade::{Error, Field, analyze};

/// Waves both ways, a bit of everything; no symmetry.
fn sample(n: usize, j: usize) -> f64 {
    let (t, x) = (n as f64, j as f64);
    (0.7 * t - 0.4 * x + 0.3).sin() + 0.5 * (0.2 * t + 1.1 * x).cos() + 0.1
}

fn field(shape: (usize, usize)) -> Field {
    Field::from_array(Array2::from_shape_fn(shape, |(n, j)| sample(n, j)))
}

#[track_caller]
fn analyzed(field: &Field, request: &Request) -> (Analysis, Arrays) {
    analyze(field, request).unwrap()
}

fn residuals(analysis: &Analysis) -> impl Iterator<Item = f64> {
    let p = analysis.parseval;
    [p.time, p.space, p.spacetime].into_iter().flatten()
}

#[test]
fn every_length_on_either_axis_keeps_its_energy() {
    let lengths = [
        1, 2, 3, 4, 5, 7, 16, 31, 64, 101, 127, 128, 243, 1000, 1009, 4096,
    ];
    for (nt, nx) in lengths
        .iter()
        .flat_map(|&n| [(n, 1), (1, n), (n, 3), (2, n), (n, 17)])
    {
        for window in [Window::None, Window::Hann] {
            let request = asking(|it| (it.window_time, it.window_space) = (window, window));
            let field = field((nt, nx));
            // A Hann window of one or two samples is 1 or (0, 1): nothing may be left of a field.
            let (analysis, spectra) = analyzed(&field, &request);
            for residual in residuals(&analysis) {
                assert!(
                    residual.abs() < 4e-15,
                    "{nt} x {nx} {window:?}: {residual:e}"
                );
            }
            let temporal = &spectra[&LargeArray::TEMPORAL_SPECTRUM];
            assert_eq!(temporal.dim(), (nt / 2 + 1, nx));
            assert!(temporal.iter().all(|p| p.is_finite()));
        }
    }
}

#[test]
fn amplitudes_at_the_ends_of_the_number_range_scale_exactly() {
    let shape = (64, 12);
    let plain = analyzed(&field(shape), &Request::default());
    for exponent in [-1040, -1000, -665, -300, 300, 500, 665, 1020] {
        // 2^exponent in two steps: the factor itself may be out of range.
        let (half, rest) = (exponent / 2, exponent - exponent / 2);
        let scale = |v: f64| v * 2f64.powi(half) * 2f64.powi(rest);
        let values = Array2::from_shape_fn(shape, |(n, j)| scale(sample(n, j)));
        let (analysis, spectra) = analyzed(&Field::from_array(values), &Request::default());
        let mut warnings = analysis.warnings.iter();
        let warned = warnings.any(|w| w.code == "unrepresentable");
        assert_eq!(warned, exponent.abs() > 470, "2^{exponent}");
        let unit = analysis.accuracy.amplitude_unit;
        let subnormal = exponent < -1022;
        let tolerance = if subnormal { 1e-9 } else { 1e-15 };
        let ours = &spectra[&LargeArray::SPACETIME_SPECTRUM];
        let theirs = &plain.1[&LargeArray::SPACETIME_SPECTRUM];
        let peak = theirs.iter().fold(0.0, |m: f64, v| m.max(*v));
        for (a, b) in ours.iter().zip(theirs) {
            // In units of the square of the stated unit, `a` is b (2^exponent / unit)^2.
            let [b, peak] = [*b, peak].map(|p| p * (scale(1.0) / unit) * (scale(1.0) / unit));
            let is_near = (a - b).abs() <= tolerance * peak;
            assert!(is_near, "2^{exponent}: {a:e} {b:e}");
        }
        let centroid = |a: &Analysis| a.along_space.as_ref().expect("requested").centroid[3];
        let moved = centroid(&analysis) / centroid(&plain.0) - 1.0;
        assert!(moved.abs() < tolerance, "2^{exponent}: {moved:e}");
        assert!(residuals(&analysis).all(|r| r.abs() < 1e-14));
    }
}

#[test]
fn an_offset_a_billion_times_the_signal_is_removed_or_kept_without_loss() {
    let shape = (500, 40);
    // The signal as it survives being stored on top of the offset.
    let stored = Array2::from_shape_fn(shape, |(n, j)| (1e9 + sample(n, j)) - 1e9);
    let offset = Field::from_array(stored.mapv(|v| v + 1e9));
    let clean = Field::from_array(stored);
    let mean_removed = asking(|it| it.detrend_time = Detrend::Mean);
    for request in [Request::default(), mean_removed] {
        let [a, b] = [&offset, &clean].map(|field| {
            let (_, mut spectra) = analyzed(field, &request);
            spectra.remove(&LargeArray::TEMPORAL_SPECTRUM).unwrap()
        });
        let peak = b.iter().skip(40).fold(0.0, |m: f64, v| m.max(*v));
        for (a, b) in a.iter().zip(&b).skip(40) {
            assert!((a - b).abs() < 1e-14 * peak, "{a:e} {b:e}");
        }
    }
    let (analysis, _) = analyzed(&offset, &Request::default());
    assert!(residuals(&analysis).all(|r| r.abs() < 1e-14));
}

/// One frame over the whole record is the record's own spectrum; frames elsewhere are those of the
/// samples they cover.
#[test]
fn short_time_spectra_are_spectra_of_their_samples() {
    let field = field((96, 20));
    let short = |segment, hop, window| Request {
        scaling: Scaling::Density,
        window_time: window,
        short_time: wavecascade::analyze::ShortTime {
            sites: vec![4, 11],
            times: vec![30.0],
            segment: Some(segment),
            hop: Some(hop),
            segment_space: Some(20),
            hop_space: Some(1),
            window,
        },
        ..Request::default()
    };
    let (analysis, spectra) = analyzed(&field, &short(96, 1, Window::Hann));
    let along_t = analysis.short_time.expect("requested");
    let temporal = &spectra[&LargeArray::TEMPORAL_SPECTRUM];
    assert_eq!(along_t.rows, [4, 11]);
    for (values, row) in along_t.values.outer_iter().zip(&along_t.rows) {
        assert_eq!(values.column(0), temporal.column(*row));
    }
    assert_eq!(along_t.frames, [47.5]);

    let (analysis, _) = analyzed(&field, &short(32, 16, Window::None));
    let frames = analysis.short_time.expect("requested");
    assert_eq!(frames.frames, [15.5, 31.5, 47.5, 63.5, 79.5]);
    for (s, start) in [0, 16, 32, 48, 64].into_iter().enumerate() {
        let part = Request {
            times: TimeRange::Interval {
                from: start as f64,
                to: (start + 31) as f64,
            },
            scaling: Scaling::Density,
            ..Request::default()
        };
        let (_, spectra) = analyzed(&field, &part);
        let temporal = &spectra[&LargeArray::TEMPORAL_SPECTRUM];
        assert_eq!(frames.values.slice(s![1, .., s]), temporal.column(11));
    }
    let along_x = analysis.short_space.expect("requested");
    let untapered = asking(|it| it.scaling = Scaling::Density);
    let (_, spectra) = analyzed(&field, &untapered);
    let spatial = &spectra[&LargeArray::SPATIAL_SPECTRUM];
    assert_eq!(along_x.values.slice(s![0, .., 0]), spatial.row(30));
}

#[test]
fn shares_change_with_the_band_edge_without_steps() {
    let mut field = field((44, 2));
    field.time.step = 1e-3;
    let request = |edge| asking(|it| it.band_edge_frequency = Some(edge));
    let low = |edge: f64| {
        let (analysis, _) = analyzed(&field, &request(edge));
        analysis.along_space.expect("requested").low_share[0]
    };
    // 250 is bin 11 of 44 samples at 1 ms, but the bin as computed lies one rounding above it.
    let around = [
        249.0,
        250.0 * (1.0 - 1e-15),
        250.0,
        250.0 * (1.0 + 1e-15),
        251.0,
    ]
    .map(low);
    assert!(around.is_sorted() && around[0] < around[1] && around[3] < around[4]);
    assert!(around[3] - around[1] < 1e-14);
    // Half of the bin lies below its middle.
    let bin = 1e3 / 44.0;
    let whole = low(250.0 + 0.5 * bin) - low(250.0 - 0.5 * bin);
    let half = low(250.0) - low(250.0 - 0.5 * bin);
    assert!((half / whole - 0.5).abs() < 1e-12);
}

/// A tone half a bin off: amplitude within the window's scalloping loss in dB (Harris 1978; SciPy), energy to rounding,
/// frequency within half a bin.
#[test]
fn a_tone_between_bins_is_recovered_to_the_bound_of_each_window() {
    let windows = [
        (Window::None, 3.92),
        (Window::Hann, 1.42),
        (Window::Hamming, 1.75),
        (Window::BlackmanHarris, 0.83),
        (Window::FlatTop, 0.01),
        (Window::Tukey { taper: 0.25 }, 2.96),
        (Window::Kaiser { beta: 14.0 }, 0.71),
        (
            Window::Dpss {
                time_bandwidth: 4.0,
            },
            0.81,
        ),
    ];
    let grid = Grid {
        n_times: 1024,
        n_sites: 1,
        dt: 1.0 / 1024.0,
        dx: 1.0,
    };
    for (window, bound) in windows {
        for fraction in [0.0, 0.25, 0.5] {
            let tone = grid.sample("tone", |n, _| {
                let cycles = (200.0 + fraction) * n as f64 / 1024.0;
                3.0 * (std::f64::consts::TAU * cycles.fract()).cos()
            });
            let asked = |scaling| asking(|it| (it.window_time, it.scaling) = (window, scaling));
            let (_, spectra) = analyzed(&tone, &asked(Scaling::Spectrum));
            let spectrum = &spectra[&LargeArray::TEMPORAL_SPECTRUM];
            let bins = spectrum.column(0).into_iter().enumerate();
            let (bin, peak) = bins.max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
            let loss = 20.0 * ((2.0 * *peak).sqrt() / 3.0).log10();
            // The image at negative frequency adds a little to the slow sidelobes of no window.
            let most = if fraction == 0.5 { -bound } else { 0.0 };
            let within = -bound - 0.02..=most + 0.02;
            assert!(within.contains(&loss), "{window:?}: {loss} dB");
            let off = (bin as f64 - 200.0 - fraction).abs();
            assert!(off <= 0.5, "{window:?}: bin {bin}");

            let (analysis, spectra) = analyzed(&tone, &asked(Scaling::Density));
            let density = &spectra[&LargeArray::TEMPORAL_SPECTRUM];
            let power = density.sum() * analysis.axes.frequency[1];
            // Far from the ends of the axis the window weighs the tone's square evenly.
            assert!((power / 4.5 - 1.0).abs() < 2e-3, "{window:?}: {power}");
        }
    }
}

/// `sum S` is the sum of `v^2 dt` (energy), the mean square (density), along either axis.
#[test]
fn integrals_of_spectra_are_what_their_scaling_says() {
    let mut field = field((60, 21));
    field.time = Axis {
        origin: 3.0,
        step: 0.01,
        unit: Some("s".into()),
    };
    field.space.step = 0.25;
    let values = Array2::from_shape_fn((60, 21), |(n, j)| sample(n, j));
    let squares = values.mapv(|v| v * v);
    for (pad_time, pad_space) in [(None, None), (Some(128), Some(64))] {
        for scaling in [Scaling::Energy, Scaling::Density] {
            let request = Request {
                scaling,
                pad_time,
                pad_space,
                ..Request::default()
            };
            let (analysis, spectra) = analyzed(&field, &request);
            let df = analysis.axes.frequency[1];
            let dk = analysis.axes.wavenumber[1];
            let (dt, dx) = match scaling {
                Scaling::Density => (1.0 / 60.0, 1.0 / 21.0),
                _ => (0.01, 0.25),
            };
            let temporal = spectra[&LargeArray::TEMPORAL_SPECTRUM].column(4).sum() * df;
            assert!((temporal / (squares.column(4).sum() * dt) - 1.0).abs() < 1e-14);
            let spatial = spectra[&LargeArray::SPATIAL_SPECTRUM].row(9).sum() * dk;
            assert!((spatial / (squares.row(9).sum() * dx) - 1.0).abs() < 1e-14);
            let both = spectra[&LargeArray::SPACETIME_SPECTRUM].sum() * df * dk;
            assert!((both / (squares.sum() * dt * dx) - 1.0).abs() < 1e-14);
        }
    }
}

/// The band's edge is that of the spectra it splits: segments lose their means in both.
#[test]
fn the_band_edge_of_segments_is_that_of_their_spectra() {
    let slow = |n: usize| 50.0 * (std::f64::consts::TAU * n as f64 / 5000.0).sin();
    let tone = |n: usize| (std::f64::consts::TAU * n as f64 / 8.0).sin();
    let field = Field::from_array(Array2::from_shape_fn((2048, 2), |(n, _)| slow(n) + tone(n)));
    let request = Request {
        detrend_time: Detrend::Linear,
        welch: Some(segments(256, 128)),
        ..Request::default()
    };
    let (analysis, spectra) = analyzed(&field, &request);
    let power = spectra[&LargeArray::TEMPORAL_SPECTRUM].column(0).to_vec();
    let (total, mut below) = (power.iter().sum::<f64>(), 0.0);
    let at = power.iter().position(|p| {
        below += p;
        below >= 0.9 * total
    });
    let at = at.unwrap();
    let part = (0.9 * total - below + power[at]) / power[at];
    let edge = analysis.along_space.unwrap().edge.value();
    let right = analysis.axes.frequency[at] + (part - 0.5) * analysis.axes.frequency[1];
    assert!((edge / right - 1.0).abs() < 1e-12, "{edge} {right}");
    // Without their trends the tone is what is left.
    assert!(edge > 0.1, "{edge}");
}

/// A sample that no segment reaches decides neither unit nor spectra, and where it is transformed along
/// space beside others that vanish against it, the run is an error.
#[test]
fn regress_what_no_segment_reaches_does_not_count() {
    let field = |huge: Option<f64>| {
        let mut values = test_support::fields::noise(1000, 6);
        if let Some(huge) = huge {
            values[(998, 2)] = huge;
        }
        Field::from_array(values)
    };
    let request = |results, precision| Request {
        results,
        precision,
        welch: Some(segments(128, 64)),
        ..Request::default()
    };
    for (precision, huge) in [(Precision::F32, 1e45), (Precision::F64, 1e300)] {
        let of = |huge| analyze(&field(huge), &request(TEMPORAL, precision));
        let (found, spectra) = of(Some(huge)).unwrap();
        assert_eq!(spectra, of(None).unwrap().1, "{precision:?}");
        assert!(found.parseval.time.is_some_and(|r| r.abs() < 1e-6));
        let all = request(wavecascade::analyze::Results::ALL, precision);
        let error = analyze(&field(Some(huge)), &all).unwrap_err();
        assert!(matches!(error, Error::Unresolved(_)), "{error}");
        assert!(!error.is_usage());
    }
}

#[test]
fn val_a_parseval_residual_above_its_bound_is_an_error() {
    use wavecascade::analyze::Parseval;
    let with = |residual| changed(Parseval::default(), |it| it.space = Some(residual));
    for (residual, precision, passes) in [
        (1e-12, Precision::F64, true),
        (-1.0, Precision::F64, false),
        (1e-6, Precision::F64, false),
        (1e-6, Precision::F32, true),
        (-1.0, Precision::F32, false),
        (f64::NAN, Precision::F32, false),
        (f64::INFINITY, Precision::F64, false),
    ] {
        let found = with(residual).check(precision);
        assert_eq!(found.is_ok(), passes, "{residual} {precision:?}");
    }
}

/// Amplitudes whose fourth powers leave the range of numbers are refused, their densities not stated as 0 or infinite.
#[test]
fn val_amplitudes_without_fourth_powers_are_refused() {
    let values = noise(1024, 8);
    for (amplitude, is_refused) in [
        (1e-165, true),
        (1e-70, true),
        (1e-40, false),
        (1e40, false),
        (1e70, true),
        (1e154, true),
    ] {
        let field = Field::from_array(&values * amplitude);
        let fields = [&field];
        let refused = |found: Result<(), Error>| {
            let error = found.err().map(|error| error.to_string());
            let is_told = |error: &String| error.contains("another unit");
            assert!(error.as_ref().is_none_or(is_told), "{amplitude}: {error:?}");
            error.is_some()
        };
        let found = [
            spectrum(&fields, &SpectrumRequest::default(), &Silent).map(|_| ()),
            modes(&fields, &ModesRequest::default(), &Silent).map(|_| ()),
            increments(&fields, &IncrementsRequest::default(), &Silent).map(|_| ()),
        ];
        assert_eq!(found.map(refused), [is_refused; 3], "{amplitude}");
    }
}

/// Axes that a program sets wrongly, and the plan of another field.
#[test]
fn val_axes_without_a_step_are_refused() {
    for (is_time, step) in [
        (true, 0.0),
        (true, f64::INFINITY),
        (false, f64::NAN),
        (false, -1.0),
    ] {
        let mut field = field((64, 8));
        let (named, axis) = match is_time {
            true => ("dt", &mut field.time),
            false => ("dx", &mut field.space),
        };
        axis.step = step;
        let of_analysis = analyze(&field, &Request::default()).unwrap_err();
        let of_spectrum = spectrum(&[&field], &SpectrumRequest::default(), &Silent).unwrap_err();
        for error in [of_analysis, of_spectrum] {
            assert_eq!(option(error), named);
        }
    }
    let plan = wavecascade::analyze::plan(&field((64, 8)), &Request::default()).unwrap();
    for other in [field((32, 8)), field((64, 4))] {
        let nowhere = wavecascade::arrays::Nowhere;
        let ran = wavecascade::analyze::run(&other, &plan, &nowhere, &Silent);
        assert_eq!(option(ran.unwrap_err()), "plan");
    }
}
