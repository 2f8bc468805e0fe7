//! Analyses that show every map, curve and label, and some at the edges of what can be drawn.

use std::f64::consts::TAU;

use ndarray::Array2;
use wavecascade::Field;
use wavecascade::analyze::*;
use wavecascade::field::Axis;
use wavecascade::plot::{Figure, Style, figures_of};
use wavecascade::prepare::Window;

/// The figures of an analysis.
pub fn drawn(analysis: &Analysis, style: &Style) -> Vec<Figure> {
    let name = &analysis.name;
    figures_of(analysis, &analysis.words(), name, "analyze", style)
}

/// The one of this name.
pub fn figure(analysis: &Analysis, name: &str, style: &Style) -> Figure {
    let mut all = drawn(analysis, style).into_iter();
    all.find(|figure| figure.name() == name).expect(name)
}

/// A pulse that grows a tail of high frequency, 400 times by 300 sites, with a law to compare and
/// two warnings; a block of each map holds no value.
pub fn full() -> Analysis {
    let mut law = Dispersion::parse("340*k", &Default::default()).unwrap();
    law.name = "340 <m/s> & \"free\"".into();
    let request = Request {
        dispersion: Some(vec![law]),
        ..request(&[0.05, 0.2])
    };
    let mut analysis = analyze(&pulse(), &request).unwrap().0;
    analysis.warnings = [
        (
            "3.40 % of the energy lies above frequency 0.4500",
            "sample faster",
        ),
        (
            "sites 17, 18 at 0.34, 0.36 m: constant",
            "check the sensors",
        ),
    ]
    .map(|(found, advice)| Warning::new(found, advice))
    .into();
    for map in analysis.maps.values_mut() {
        let (rows, columns) = map.values.dim();
        let block = ndarray::s![
            rows * 7 / 10..rows * 8 / 10,
            columns * 4 / 5..columns * 6 / 7
        ];
        map.values.slice_mut(block).fill(f32::NAN);
    }
    analysis
}

/// Only the field was asked for.
pub fn field_only() -> Analysis {
    let request = Request {
        results: Results::NONE,
        ..request(&[])
    };
    analyze(&pulse(), &request).unwrap().0
}

/// Analyses of fields of few values, of one value, and of results without a value, with their names.
pub fn degenerate() -> Vec<(&'static str, Analysis)> {
    let of = |rows, columns, value| {
        let field = Field::from_array(Array2::from_elem((rows, columns), value));
        analyze(&field, &request(&[0.0])).unwrap().0
    };
    let mut cases = vec![
        ("1x1", of(1, 1, 2.5)),
        ("1xN", of(1, 40, 2.5)),
        ("Nx1", of(40, 1, 2.5)),
        ("zero", of(12, 9, 0.0)),
        ("constant", of(12, 9, -3.0)),
        ("tiny", of(12, 9, f64::from(f32::from_bits(1)))),
        ("huge", of(12, 9, f64::from(f32::MAX))),
    ];
    for (name, value) in [("undefined", f32::NAN), ("infinite", f32::INFINITY)] {
        let mut analysis = of(12, 9, 1.0);
        for map in analysis.maps.values_mut() {
            map.values.fill(value);
            map.x.low = f64::from(value);
        }
        cases.push((name, analysis));
    }
    cases
}

/// Everything, with short-time spectra at these times.
fn request(times: &[f64]) -> Request {
    let whole = ShowAxis::Interval {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };
    let mut request = Request {
        window_time: Window::Hann,
        window_space: Window::Hann,
        show: Show {
            frequency: whole,
            wavenumber: whole,
            time: whole,
            space: whole,
        },
        ..Request::default()
    };
    request.short_time.times = times.to_vec();
    request
}

fn pulse() -> Field {
    let mut field = Field::from_array(Array2::from_shape_fn((400, 300), |(n, j)| {
        let (t, x) = (n as f64 / 400.0, j as f64 / 300.0);
        let lag = t - 0.8 * x - 0.05;
        let tail = x * (-(12.0 * lag - 1.0).powi(2)).exp();
        (-(40.0 * lag).powi(2)).exp() + 0.3 * tail * (TAU * 40.0 * lag * (1.0 + x)).sin()
    }));
    let axis = |step, unit: &str| Axis {
        origin: 0.0,
        step,
        unit: Some(unit.into()),
    };
    (field.time, field.space) = (axis(1e-3, "s"), axis(0.01, "m"));
    field.name = "chirp <& \"friends\"> 'n' \u{3ba}=4.5.npy".into();
    field.content_hash = Some("7f".repeat(32));
    field.unit = Some("m/s".into());
    field
}

/// Asserts that tags nest and close; returns the text between them.
#[track_caller]
pub fn well_formed(page: &str) -> String {
    let (mut open, mut texts) = (Vec::new(), String::new());
    for piece in page.split('<').skip(1) {
        let (tag, text) = piece.split_once('>').expect("a tag closes");
        let name = tag.split_whitespace().next().unwrap();
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') && !tag.starts_with('!') && name != "meta" {
            open.push(name);
        }
        texts.push_str(text);
    }
    assert!(open.is_empty(), "{open:?} stay open");
    texts
}
