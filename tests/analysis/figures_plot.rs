//! Figures: valid files, labelled axes, and no panic at the edges of what can be drawn.

use std::collections::BTreeSet;
use std::fs;

use test_support::contains_all;
use test_support::figures::well_formed;
use wavecascade::analyze::{Analysis, Reduction};
use wavecascade::arrays::LargeArray;
use wavecascade::plot::plotters::prelude::*;
use wavecascade::plot::{self, Figure, Format, Style, own_chart, px, sans};

const NAMES: [&str; 9] = [
    "along-t",
    "along-x",
    "flux-surrogate",
    "short-space",
    "short-time",
    "space-time",
    "spacetime-spectrum",
    "spatial-spectrum",
    "temporal-spectrum",
];

fn decode(bytes: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
        .read_info()
        .unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width, info.height, pixels)
}

#[test]
fn every_figure_is_written_in_every_format() {
    let dir = tempfile::tempdir().unwrap();
    let analysis = test_support::figures::full();
    let formats = [Format::Png, Format::Svg];
    let paths = plot::save_all(&drawn(&analysis), dir.path(), &formats).unwrap();
    let found: BTreeSet<String> = fs::read_dir(dir.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let expected: BTreeSet<String> = NAMES
        .iter()
        .flat_map(|name| [format!("{name}.png"), format!("{name}.svg")])
        .collect();
    assert_eq!(found, expected);
    assert_eq!(paths.len(), found.len());
    for path in paths {
        let bytes = fs::read(&path).unwrap();
        if path.extension().unwrap() == "png" {
            let (width, height, pixels) = decode(&bytes);
            assert!(width >= 1200, "{path:?}: {width} x {height}");
            assert!(height >= 600, "{path:?}: {width} x {height}");
            let colours: BTreeSet<&[u8]> = pixels.chunks(3).collect();
            assert!(colours.len() > 20, "{path:?} is nearly blank");
        } else {
            assert!(bytes.len() < 500_000, "{path:?}: {} bytes", bytes.len());
            well_formed(std::str::from_utf8(&bytes).unwrap());
        }
    }
}

fn drawn(analysis: &Analysis) -> Vec<Figure> {
    test_support::figures::drawn(analysis, &Style::default())
}

fn text(analysis: &Analysis, name: &str) -> String {
    let figure = test_support::figures::figure(analysis, name, &Style::default());
    let bytes = figure.encode(Format::Svg).unwrap();
    well_formed(&String::from_utf8(bytes).unwrap())
}

#[test]
fn axes_and_colour_bars_are_named_with_their_units() {
    let analysis = test_support::figures::full();
    let (x, t) = ("position (m)", "time (s)");
    let (f, k) = ("frequency (Hz)", "wavenumber (rad/m)");
    for (name, labels) in [
        ("space-time", [x, t, "no value"]),
        ("temporal-spectrum", [x, f, "Temporal spectrum"]),
        ("spatial-spectrum", [k, t, "k a / π"]),
        ("spacetime-spectrum", [k, f, "towards +x: "]),
        ("flux-surrogate", [k, t, "surrogate"]),
        ("along-x", [x, f, "centroid"]),
        ("along-t", [t, k, "k a / π"]),
        ("short-time", [t, f, "position (m) = 1.49"]),
        ("short-space", [x, "time (s) = 0.05", "k a / π"]),
    ] {
        let text = text(&analysis, name);
        for label in labels {
            assert!(text.contains(label), "{label} is missing from {text}");
        }
    }
}

#[test]
fn degenerate_results_are_drawn_without_panic() {
    for (name, analysis) in test_support::figures::degenerate() {
        let dir = tempfile::tempdir().unwrap();
        let formats = [Format::Png, Format::Svg];
        let paths = plot::save_all(&drawn(&analysis), dir.path(), &formats)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(paths.len(), 18, "{name}");
        for path in paths
            .iter()
            .filter(|path| path.extension().unwrap() == "svg")
        {
            let svg = fs::read_to_string(path).unwrap();
            well_formed(&svg);
            assert!(!svg.contains("NaN"), "{name}: {path:?}");
            assert!(!svg.contains("inf"), "{name}: {path:?}");
        }
    }
}

#[test]
fn the_note_states_the_whole_reduction() {
    let mut analysis = test_support::figures::full();
    // The map holds 8 samples a row; 400 by 300 cells are drawn as they are, 1500 by 1500 as 400 by 600.
    for (shape, note) in [
        ((400, 300), "up to 8 (vertical) × 1 (horizontal) samples"),
        ((1500, 1500), "up to 32 (vertical) × 3 (horizontal) samples"),
    ] {
        let map = analysis.maps.get_mut(&LargeArray::SAMPLES).unwrap();
        map.values = ndarray::Array2::zeros(shape);
        map.reduction = Reduction::Extreme {
            rows: 8,
            columns: 1,
        };
        let field = text(&analysis, "space-time");
        assert!(field.contains(note), "{field}");
    }
    assert!(!text(&analysis, "short-time").contains("each cell"));
    let short = analysis.short_time.as_mut().unwrap();
    let centres = |count: usize| (0..count).map(|n| n as f64).collect::<Vec<f64>>();
    (short.bins, short.frames) = (centres(150), centres(2000));
    short.values = ndarray::Array3::ones((short.at.len(), 150, 2000));
    assert!(text(&analysis, "short-time").contains("each cell"));
}

fn noisy(n: usize, value: impl Fn(usize) -> f64) -> wavecascade::analyze::Moments {
    let curve: Vec<f64> = (0..n).map(value).collect();
    wavecascade::analyze::Moments {
        centroid: curve.clone(),
        median: curve.clone(),
        quantile_90: curve.clone(),
        low_share: curve.clone(),
        high_share: curve.clone(),
        energy: curve.iter().map(|value| value * value).collect(),
        ..Default::default()
    }
}

#[test]
fn large_noisy_results_stay_small_files() {
    let mut analysis = test_support::figures::field_only();
    let noise = |i: usize, j: usize| ((i * 7919 + j * 104_729) as f64).sin() * 43_758.545_3 % 1.0;
    let samples = analysis.maps.get_mut(&LargeArray::SAMPLES).unwrap();
    samples.values = ndarray::Array2::from_shape_fn((1500, 1500), |(i, j)| noise(i, j) as f32);
    let mut figures = drawn(&analysis);
    for (n, gap_every) in [(200_000, usize::MAX), (200_000, 3), (4000, 2), (2000, 2)] {
        analysis.axes.n_times = n;
        analysis.along_time = Some(noisy(n, |m| match (m + 1) % gap_every {
            0 => f64::NAN,
            _ => noise(m, 1),
        }));
        figures.extend(drawn(&analysis));
    }
    for figure in figures {
        let bytes = figure.encode(Format::Svg).unwrap();
        let (name, length) = (figure.name(), bytes.len());
        assert!(length < 500_000, "{name}: {length} bytes");
    }
}

#[test]
fn the_same_analysis_gives_the_same_bytes() {
    let analysis = test_support::figures::full();
    let [once, again] = [drawn(&analysis), drawn(&analysis)];
    for format in [Format::Png, Format::Svg] {
        let bytes = |figures: &[Figure]| figures[0].encode(format).unwrap();
        assert_eq!(bytes(&once), bytes(&again));
    }
}

fn drawn_by_plotters(format: Format) -> Vec<u8> {
    let drawn = own_chart("Own <chart>", (400, 300), format, |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("κ = 4.5", sans(20.0))
            .x_label_area_size(px(50.0))
            .y_label_area_size(px(60.0))
            .build_cartesian_2d(0.0..1.0, 0.0..1.0)?;
        chart
            .configure_mesh()
            .label_style(sans(14.0))
            .x_desc("time (s)")
            .y_desc("share")
            .draw()?;
        let curve = (0..50).map(|m| f64::from(m) / 50.0).map(|t| (t, t * t));
        chart.draw_series(LineSeries::new(curve, BLUE.stroke_width(px(2.4))))?;
        chart.draw_series([Circle::new((0.5, 0.5), px(4.5), RED.mix(0.5).filled())])?;
        Ok(())
    });
    drawn.unwrap()
}

#[test]
fn own_charts_are_drawn_between_the_pixels() {
    let svg = String::from_utf8(drawn_by_plotters(Format::Svg)).unwrap();
    let text = well_formed(&svg);
    for label in ["Own &lt;chart&gt;", "κ = 4.5", "time (s)", "share", "0.5"] {
        assert!(text.contains(label), "{label} is missing from {text}");
    }
    contains_all(
        &svg,
        &["stroke-width=\"24\"", "r=\"45\"", "opacity=\"0.5\""],
    );
    let (first, _) = svg.split_once('\n').unwrap();
    contains_all(
        first,
        &["width=\"105.83mm\"", "viewBox=\"0 0 4000.0 3000.0\""],
    );
    assert!(!svg.contains("stroke-width=\"1\""), "thinner than a pixel");
    let curve = svg.split("points=\"").find(|s| {
        s.split('"')
            .next()
            .is_some_and(|list| list.matches(',').count() == 50)
    });
    let places: BTreeSet<char> = curve
        .expect("the curve is one line")
        .split(['"', ' ', ','])
        .take(100)
        .filter_map(|number| number.chars().last())
        .collect();
    assert!(places.len() > 5, "snapped to pixels: {places:?}");

    let (width, height, pixels) = decode(&drawn_by_plotters(Format::Png));
    assert_eq!((width, height), (600, 450));
    let colours: BTreeSet<&[u8]> = pixels.chunks(3).collect();
    assert!(colours.len() > 100, "no smooth edges");
}

#[test]
fn texts_are_measured_in_the_font_that_draws_them() {
    let size = |text: &str| f64::from(sans(100.0).box_size(text).unwrap().0);
    // DejaVu Sans: a digit is 1303 of 2048 units wide. `plotters` leaves some more room.
    let digit = f64::from(px(100.0 * 1303.0 / 2048.0));
    for (text, count) in [("0", 1.0), ("0000", 4.0)] {
        let over = size(text) / (count * digit);
        assert!((1.0..1.1).contains(&over), "{over}");
    }
}
