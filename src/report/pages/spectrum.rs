//! The page of spectra with intervals.

use maud::html as markup;

use crate::estimates::{SpectrumAxis, SpectrumEstimate, interval_factors};
use crate::plot::{Style, mean_spectrum_chart, spectrum_chart, spectrum_lines, spectrum_map};
use crate::report::page::{self, AxisData, CurveGroup, MapData, Page, Picture, Role, number};
use crate::report::{Provenance, SpectrumSummary, percent};

const DEFINITIONS: [(&str, &str); 5] = [
    (
        "Power spectral density",
        "One-sided; its integral over f is the mean square of the samples.",
    ),
    (
        "Degrees of freedom",
        "Twice the number of independent realisations that a value averages, less what unequal weights of the \
         tapers cost. Overlapping segments count by their effective number.",
    ),
    (
        "Interval",
        "Where the true density lies with the stated probability if the record is stationary: by the \
         chi-square distribution of Gaussian records, and by the jackknife, which leaves out one realisation \
         at a time and assumes no distribution.",
    ),
    (
        "Test for lines",
        "F compares the power of a sine of constant amplitude with what is left beside it. Without a line it \
         exceeds the level of one cell with the stated probability, and that of all cells anywhere with the same.",
    ),
    (
        "Transient",
        "A record whose energy lies in a few of its parts is one realisation; only several records give it \
         an interval.",
    ),
];

/// Lines that the page lists.
const LISTED: usize = 20;

/// The page of the spectra of a field with this name.
///
/// # Errors
/// None for results of this library.
pub fn spectrum_html(
    found: &SpectrumEstimate,
    name: &str,
    provenance: &Provenance,
    warnings: &[[String; 2]],
    style: &Style,
) -> serde_json::Result<String> {
    let (time_unit, space_unit) = found.units();
    let map = spectrum_map(found);
    let (roles, title, columns) = match found.along {
        SpectrumAxis::Time => (
            [Role::Position, Role::Frequency],
            "Spectra S(f, x)",
            "sites",
        ),
        SpectrumAxis::Space => ([Role::Time, Role::Wavenumber], "Spectra S(k, t)", "times"),
    };
    let axes = [
        AxisData::new(&map.x_label, (map.x.start, map.x.end), roles[0]),
        AxisData::new(&map.y_label, (map.y.start, map.y.end), roles[1]),
    ];
    let map = MapData::spectrum(
        ("spectrum".into(), title.into()),
        format!("The power at all {columns}."),
        axes,
        &crate::plot::density_label(found),
        found.spectrum.view(),
    );
    let mut rows: Vec<Vec<Picture>> = vec![vec![map.into()]];
    let charts = [
        mean_spectrum_chart(found),
        Some(spectrum_chart(found)),
        spectrum_lines(found),
    ];
    for (i, chart) in charts.into_iter().flatten().enumerate() {
        let group = CurveGroup::of_chart(&format!("chart-{i}"), "", &chart);
        rows.push(vec![group.into()]);
    }
    let independence = &found.independence;
    let confidence = percent(1.0 - found.alpha);
    let interval = match found.degrees_range() {
        Some([least, median, most]) => {
            let [low, high] = interval_factors(median, found.alpha);
            format!(
                "With probability {confidence} the true density is between {} and {} of a value: {} degrees \
                 of freedom ({} to {})",
                number(low),
                number(high),
                number(median),
                number(least),
                number(most)
            )
        }
        None => format!("No interval can be stated: {}", found.independence.why()),
    };
    let lines = found
        .line_test
        .as_ref()
        .filter(|_| found.degrees_range().is_some());
    let line_answer = lines.map(|test| match test.lines.len() {
        0 => format!("None: no F is above {}", number(test.level_of_all)),
        all => format!(
            "{all} at {} {columns}: F above {}, which happens anywhere by chance with probability {}",
            test.columns(),
            number(test.level_of_all),
            percent(found.alpha)
        ),
    });
    let unit = found.unit.as_deref().unwrap_or("");
    let listed: Vec<(String, String)> = lines
        .iter()
        .flat_map(|test| test.lines.iter().take(LISTED))
        .map(|line| {
            (
                format!(
                    "{} {} at {} {}",
                    number(line.at),
                    found.bin_unit(),
                    number(found.coordinate(line.column)),
                    match found.along {
                        SpectrumAxis::Time => &space_unit,
                        SpectrumAxis::Space => &time_unit,
                    }
                ),
                format!(
                    "amplitude {} ± {} {unit}, F {}",
                    number(line.amplitude),
                    number(line.amplitude_error),
                    number(line.f)
                ),
            )
        })
        .collect();
    let table = page::table(
        "Averages",
        &[
            ("records", independence.records.to_string()),
            ("segments of a record", independence.segments.to_string()),
            ("tapers", independence.tapers.to_string()),
            ("samples a segment", found.segment[0].to_string()),
            ("effective realisations", number(independence.effective)),
            ("without interval", found.without_interval().to_string()),
        ],
    );
    let json = SpectrumSummary::new(found, provenance).to_json()?;
    let page = Page {
        title: format!("Spectra of {name}"),
        sentence: format!(
            "Power spectral density at {} {columns}, times in {time_unit}, positions in {space_unit}",
            found.spectrum.ncols()
        ),
        answers: markup! {
            (page::answer("How well are the spectra known?", interval))
            @if let Some(answer) = line_answer {
                (page::answer("Are there lines?", answer))
            }
        },
        warnings: page::warnings(
            &warnings
                .iter()
                .map(|[message, advice]| (message.clone(), Some(advice.clone())))
                .collect::<Vec<_>>(),
        ),
        rows,
        rest: markup! {
            (page::numbers(markup! {
                (table)
                @if !listed.is_empty() { (page::table("Lines, the surest first", &listed)) }
            }))
            (page::how_to_read(&DEFINITIONS))
            (page::folded("summary", "Summary", markup! { pre { (json) } }))
        },
        style: *style,
    };
    Ok(page.html())
}
