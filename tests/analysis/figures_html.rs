//! The HTML report: self-contained, escaped, balanced, and true to the maps.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::Value;
use test_support::figures::well_formed;
use wavecascade::analyze::Analysis;
use wavecascade::arrays::LargeArray;
use wavecascade::plot::Style;
use wavecascade::report::{Provenance, sheet_html};

/// Text of the first `<name ...>` element whose opening tag contains `mark`.
fn element<'a>(page: &'a str, name: &str, mark: &str) -> &'a str {
    let (open, close) = (format!("<{name}"), format!("</{name}>"));
    page.split(&open)
        .skip(1)
        .find_map(|rest| {
            let (tag, body) = rest.split_once('>')?;
            tag.contains(mark).then_some(body.split(&close).next()?)
        })
        .unwrap_or_else(|| panic!("no {name} with {mark}"))
}

fn html(analysis: &Analysis) -> String {
    let provenance = Provenance::new(Vec::new(), None, None);
    let (sheet, style) = (analysis.words(), Style::default());
    sheet_html(analysis, &sheet, &analysis.name, &provenance, &style).unwrap()
}

fn payload(analysis: &Analysis) -> Value {
    let page = html(analysis);
    serde_json::from_str(element(&page, "script", "id=\"data\"")).unwrap()
}

fn picture<'a>(data: &'a Value, id: &str) -> &'a Value {
    let mut pictures = data["pictures"].as_array().unwrap().iter();
    pictures.find(|picture| picture["id"] == id).expect(id)
}

fn singles(value: &Value) -> Vec<f32> {
    let bytes = BASE64_STANDARD.decode(value.as_str().unwrap()).unwrap();
    let (words, rest) = bytes.as_chunks::<4>();
    assert!(rest.is_empty());
    words.iter().map(|word| f32::from_le_bytes(*word)).collect()
}

fn doubles(value: &Value) -> Vec<f64> {
    let bytes = BASE64_STANDARD.decode(value.as_str().unwrap()).unwrap();
    let (words, rest) = bytes.as_chunks::<8>();
    assert!(rest.is_empty());
    words.iter().map(|word| f64::from_le_bytes(*word)).collect()
}

fn bits(values: impl IntoIterator<Item = f32>) -> Vec<u32> {
    values.into_iter().map(f32::to_bits).collect()
}

/// The page without its scripts and styles.
fn markup(page: &str) -> String {
    let without = |page: String, name: &str| {
        let (open, close) = (format!("<{name}"), format!("</{name}>"));
        let mut parts = page.split(&open);
        let first = parts.next().unwrap_or_default().to_owned();
        // A script may name its own element.
        let after = |part| str::split_once(part, &close).map_or("", |(_, rest)| rest);
        first + &parts.map(after).collect::<String>()
    };
    ["script", "style"]
        .into_iter()
        .fold(page.to_owned(), without)
}

#[test]
fn nothing_is_loaded_from_elsewhere() {
    // The library's code mentions what the policy of the page forbids.
    let library = include_str!("../../assets/plotly/plotly-cartesian.min.js");
    let page = html(&test_support::figures::full());
    assert!(page.contains(library));
    let page = page.replace(library, "");
    for load in [
        "src=",
        "href=",
        "@import",
        "url(",
        "fetch(",
        "XMLHttpRequest",
        "import(",
    ] {
        assert!(!page.contains(load), "the page has {load}");
    }
    assert!(page.contains("default-src 'none'"));
}

#[test]
fn names_are_escaped() {
    let mut analysis = test_support::figures::full();
    analysis.name = "</script><script>alert(1)</script>".into();
    analysis.unit = Some("<em>".into());
    analysis.maps.get_mut(&LargeArray::SAMPLES).unwrap().label = "</script><i>".into();
    let page = html(&analysis);
    assert!(!page.contains("<script>alert") && !page.contains("<em>") && !page.contains("<i>"));
    assert!(page.contains("&lt;/script&gt;&lt;script&gt;alert(1)"));
    let data = payload(&analysis);
    assert_eq!(picture(&data, "space-time")["label"], "</script><i>");
}

#[test]
fn tags_are_balanced() {
    for (name, analysis) in test_support::figures::degenerate()
        .into_iter()
        .chain([("full", test_support::figures::full())])
        .chain([("field only", test_support::figures::field_only())])
    {
        let page = markup(&html(&analysis));
        assert!(well_formed(&page).len() > 100, "{name}");
    }
}

#[test]
fn maps_decode_to_the_values_of_the_analysis() {
    let analysis = test_support::figures::full();
    let data = payload(&analysis);
    let maps = [
        ("space-time", LargeArray::SAMPLES),
        ("spacetime-spectrum", LargeArray::SPACETIME_SPECTRUM),
        ("temporal-spectrum", LargeArray::TEMPORAL_SPECTRUM),
        ("spatial-spectrum", LargeArray::SPATIAL_SPECTRUM),
        ("flux-surrogate", LargeArray::KINETIC_FLUX_SURROGATE),
    ];
    let pictures = data["pictures"].as_array().unwrap().iter();
    for (found, (id, array)) in pictures.filter(|of| of["kind"] == "map").zip(maps) {
        let map = &analysis.maps[&array];
        assert_eq!(found["id"], id);
        assert_eq!(found["rows"], map.values.nrows());
        assert_eq!(found["columns"], map.values.ncols());
        assert_eq!(found["x"]["low"], map.x.low);
        assert_eq!(found["y"]["high"], map.y.high);
        let decoded = singles(&found["values"]);
        assert!(decoded.iter().any(|value| value.is_nan()));
        assert_eq!(bits(decoded), bits(map.values.iter().copied()), "{id}");
    }
}

#[test]
fn curves_decode_to_the_moments() {
    let analysis = test_support::figures::full();
    let data = payload(&analysis);
    let centroid = &picture(&data, "along-x")["charts"][0]["series"][0];
    assert_eq!(centroid["label"], "centroid");
    let expected = &analysis.along_space.as_ref().unwrap().centroid;
    let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<u64>>();
    assert_eq!(bits(&doubles(&centroid["values"])), bits(expected));
}

#[test]
fn long_curves_keep_their_extremes() {
    let mut analysis = test_support::figures::field_only();
    let n = 400_000;
    let mut plus = vec![0.5; n];
    (plus[777], plus[54_321]) = (1.0, 0.0);
    analysis.axes.frequency = (0..n).map(|m| m as f64).collect();
    analysis.direction_by_frequency = Some([plus, vec![0.5; n]]);
    let data = payload(&analysis);
    let shown = doubles(&picture(&data, "direction")["charts"][0]["series"][0]["values"]);
    assert!((1 << 15..=1 << 16).contains(&shown.len()));
    assert!(shown.contains(&1.0) && shown.contains(&0.0));
}

/// A pulse of constant shape whose second half of sites has a part of twice the frequency.
fn moved() -> Analysis {
    let values = ndarray::Array2::from_shape_fn((1024, 48), |(i, j)| {
        let t = i as f64 - 100.0 - 6.0 * j as f64;
        let high = 0.02 * j as f64;
        let envelope = (-(t / 30.0).powi(2)).exp();
        envelope * ((0.3 * t).cos() + high * (0.6 * t).cos())
    });
    let field = wavecascade::Field::from_array(values);
    wavecascade::analyze(&field, &Default::default()).unwrap().0
}

#[test]
fn the_verdict_comes_first_then_its_picture_then_warnings_and_numbers() {
    let mut analysis = moved();
    analysis.warnings = test_support::figures::full().warnings;
    let page = html(&analysis);
    let verdict = analysis.words().answer;
    assert!(verdict.starts_with("energy moves up"), "{verdict}");
    let heading = element(&page, "h1", "").replace('\u{a0}', " ");
    assert_eq!(heading.to_lowercase(), verdict.to_lowercase());
    let places = [
        "<h1>",
        "id=\"moved-along-x-2\"",
        "class=\"facts\"",
        "id=\"warnings\"",
        "id=\"space-time\"",
        "id=\"spacetime-spectrum\"",
        "id=\"summary\"",
        "estimated by",
    ];
    let places = places.map(|text| page.find(text).unwrap_or_else(|| panic!("no {text}")));
    assert!(places.is_sorted(), "{places:?}");
}

/// The bold curves are those of the groups compared, and the mark is where they differ most.
#[test]
fn the_picture_shows_the_share_that_moved() {
    let analysis = moved();
    let answer = analysis.answer.as_ref().unwrap();
    let data = payload(&analysis);
    let [profile, picture] = [0, 1].map(|i| &data["pictures"][i]);
    assert_eq!(profile["id"], "moved-along-x");
    let moves = &answer.along_x.as_ref().unwrap().moves;
    let up = doubles(&profile["charts"][0]["series"][0]["values"]);
    assert!(
        up.iter()
            .zip(moves)
            .all(|(drawn, both)| *drawn == both[0].share)
    );
    assert_eq!(picture["id"], "moved-along-x-2");
    assert_eq!(picture["marks"][0][0], answer.frequency.up.at);
    let series = picture["charts"][0]["series"].as_array().unwrap();
    let weighing = |weight: &str| {
        let of = |one: &&Value| one["weight"] == weight;
        series.iter().filter(of).collect::<Vec<_>>()
    };
    let bold = weighing("bold");
    let [first, last] = [answer.frequency.from, answer.frequency.to].map(|place| {
        let [from, to] = place.unwrap().rows;
        format!("sites {from}-{to}")
    });
    assert_eq!(bold.len(), 2);
    assert_eq!([&bold[0]["label"], &bold[1]["label"]], [&first, &last]);
    for curve in &bold {
        let shares = doubles(&curve["values"]);
        assert!(shares.is_sorted() && shares[0] == 0.0, "{shares:?}");
        assert!((shares[shares.len() - 1] - 1.0).abs() < 1e-9);
    }
    let gap = doubles(&weighing("gap")[0]["values"]);
    assert!(
        (gap[0] - gap[1] - answer.frequency.up.share).abs() < 1e-9,
        "{gap:?}"
    );
    assert!(!weighing("thin").is_empty());
}

/// A pulse between samples of the map: the largest magnitude alone would drop its other sign.
#[test]
fn cells_of_a_signed_map_keep_both_signs() {
    let values = ndarray::Array2::from_shape_fn((4000, 3), |(i, j)| {
        (if i % 2 == 0 { 1.0 } else { -0.5 }) * (1.0 + j as f64)
    });
    let field = wavecascade::Field::from_array(values);
    let (analysis, _) = wavecascade::analyze(&field, &Default::default()).unwrap();
    let data = payload(&analysis);
    let map = picture(&data, "space-time");
    let [values, least, largest] = ["values", "least", "largest"].map(|name| singles(&map[name]));
    assert_eq!(values.len(), 1200);
    for (n, ((value, least), largest)) in values.iter().zip(&least).zip(&largest).enumerate() {
        let size = 1.0 + (n % 3) as f32;
        assert_eq!([*value, *least, *largest], [size, -0.5 * size, size], "{n}");
    }
}

/// Of a run whose samples stand to a tenth: short-time spectra show no value below a hundredth of the largest.
#[test]
fn values_below_the_error_of_a_run_are_left_out() {
    let mut analysis = test_support::figures::full();
    let shown = |analysis: &Analysis| {
        let data = payload(analysis);
        let maps = data["pictures"].as_array().unwrap().iter();
        let maps = maps.filter(|map| map["id"].as_str().unwrap().starts_with("short-time"));
        maps.flat_map(|map| singles(&map["values"]))
            .collect::<Vec<f32>>()
    };
    let all = shown(&analysis);
    let largest = all.iter().copied().fold(0.0, f32::max);
    assert!(all.iter().all(|value| value.is_finite()));
    analysis.sample_error = Some(0.1);
    for (value, before) in shown(&analysis).iter().zip(&all) {
        match *before >= 0.01 * largest {
            true => assert_eq!(value, before),
            false => assert!(value.is_nan(), "{value} of {largest}"),
        }
    }
}
