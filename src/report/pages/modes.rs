//! The page of modes.

use maud::html as markup;

use crate::estimates::{ModeShapes, Modes};
use crate::plot::{Style, mode_charts};
use crate::report::page::{self, CurveGroup, Page, Picture, number};
use crate::report::{ModesSummary, Provenance, percent};

const DEFINITIONS: [(&str, &str); 5] = [
    (
        "Mode",
        "A motion of all sites at one frequency, Re φ(x) exp(−2πi f t), that is uncorrelated with the others. \
         Modes are ordered by their power.",
    ),
    (
        "Eigenvalue λ",
        "Power spectral density of a mode, integrated over x. The eigenvalues of a frequency sum up to that of \
         the field.",
    ),
    (
        "Interval",
        "By chi-square, for the effective number of realisations. It holds for eigenvalues that are well apart.",
    ),
    (
        "Wave",
        "A mode in step with |φ(x)| exp(ikx) to 0.9 of its energy, over at least half a wavelength. A standing \
         wave reaches 0.72.",
    ),
    (
        "Independent realisations",
        "Segments, tapers and records that are averaged, less what overlapping segments share. The segments of a \
         transient are not independent: then the records alone count.",
    ),
];

/// The page of the modes of a field with this name.
///
/// # Errors
/// None for results of this library.
pub fn modes_html(
    found: &Modes,
    name: &str,
    provenance: &Provenance,
    warnings: &[[String; 2]],
    style: &Style,
) -> serde_json::Result<String> {
    let (time_unit, space_unit) = found.units();
    let charts = mode_charts(found)
        .into_iter()
        .enumerate()
        .map(|(i, chart)| {
            let group = CurveGroup::of_chart(&format!("chart-{i}"), "", &chart);
            vec![Picture::from(group)]
        });
    let json = ModesSummary::new(found, provenance).to_json()?;
    let independence = &found.independence;
    let interval = match found.interval(1) {
        Some([low, high]) => format!("{} to {} of it", number(low), number(high)),
        None => "not stated: fewer than two independent realisations".into(),
    };
    let table = page::table(
        "Averages",
        &[
            ("records", independence.records.to_string()),
            ("segments of a record", independence.segments.to_string()),
            ("tapers", independence.tapers.to_string()),
            ("samples a segment", found.segment[0].to_string()),
            ("effective realisations", number(independence.effective)),
            ("interval of an eigenvalue", interval),
        ],
    );
    let page = Page {
        title: format!("Modes of {name}"),
        sentence: format!("Positions in {space_unit}, times in {time_unit}"),
        answers: page::answer(
            "How much of the motion is one coherent motion at each frequency?",
            format!(
                "first modes hold {} of the power",
                percent(found.leading_share_of_all())
            ),
        ),
        warnings: page::warnings(
            &warnings
                .iter()
                .map(|[message, advice]| (message.clone(), Some(advice.clone())))
                .collect::<Vec<_>>(),
        ),
        rows: charts.collect(),
        rest: markup! {
            (page::numbers(table))
            (page::grid("Chosen frequencies", &HEAD, &rows_of(found)))
            (page::how_to_read(&DEFINITIONS))
            (page::folded("summary", "Summary", markup! { pre { (json) } }))
        },
        style: *style,
    };
    Ok(page.html())
}

const HEAD: [&str; 6] = [
    "frequency",
    "mode",
    "share of the power",
    "wavenumber (rad per unit of length)",
    "phase velocity",
    "share in step with the wave",
];

/// A row a mode of each chosen frequency.
fn rows_of(found: &Modes) -> Vec<Vec<String>> {
    let row = |shapes: &ModeShapes, n: usize| {
        let share = found.eigenvalues[[shapes.bin, n]] / found.total[shapes.bin];
        let wave = shapes.waves[n];
        let of_wave = |value: Option<f64>| value.map_or("-".into(), number);
        let is_wave = wave.filter(|wave| wave.is_wave);
        vec![
            number(shapes.frequency),
            (n + 1).to_string(),
            percent(share),
            of_wave(is_wave.map(|wave| wave.wavenumber)),
            of_wave(is_wave.map(|wave| wave.velocity)),
            of_wave(wave.map(|wave| wave.share)),
        ]
    };
    let rows = found.chosen.iter().flat_map(|shapes| {
        let count = shapes.modes.nrows();
        (0..count).map(move |n| row(shapes, n))
    });
    rows.collect()
}
