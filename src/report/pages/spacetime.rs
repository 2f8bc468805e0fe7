//! The page of a space-time spectrum with intervals.

use maud::html as markup;

use crate::estimates::{SpaceTimeEstimate, interval_factors};
use crate::plot::{Style, spacetime_cuts, spacetime_map};
use crate::report::page::{self, AxisData, CurveGroup, MapData, Page, Picture, Role, number};
use crate::report::{Provenance, SpaceTimeSummary, percent};

const DEFINITIONS: [(&str, &str); 5] = [
    (
        "Space-time spectrum",
        "Power spectral density over wavenumber and frequency, one-sided in f and two-sided in k. Positive k \
         travels towards +x.",
    ),
    (
        "Power",
        "The integral over f and k: the mean square of the samples under the squares of the tapers. Without \
         tapers, and with segments that cover the record, it is the mean square.",
    ),
    (
        "Degrees of freedom",
        "Twice the number of independent realisations: segments, records, and tapers along both axes. \
         Overlapping segments count by their effective number, tapers by their weights: those that leak count less \
         where the spectrum is low.",
    ),
    (
        "Interval",
        "Where the true density lies with the stated probability, if the field is stationary in time and alike \
         along space.",
    ),
    (
        "Transient",
        "A record whose energy lies in a few of its parts is one realisation; only several records give it \
         an interval. If the energy lies at a few sites, tapers along space count as one.",
    ),
];

/// The page of the space-time spectrum of a field with this name.
///
/// # Errors
/// None for results of this library.
pub fn spacetime_html(
    found: &SpaceTimeEstimate,
    name: &str,
    provenance: &Provenance,
    warnings: &[[String; 2]],
    style: &Style,
) -> serde_json::Result<String> {
    let (time_unit, space_unit) = found.units();
    let map = spacetime_map(found);
    let axes = [
        AxisData::new(&map.x_label, (map.x.start, map.x.end), Role::Wavenumber),
        AxisData::new(&map.y_label, (map.y.start, map.y.end), Role::Frequency),
    ];
    let map = MapData::spectrum(
        ("spacetime".into(), "Space-time spectrum S(k, f)".into()),
        "Power by wavenumber and frequency; positive wavenumbers travel towards +x.".into(),
        axes,
        &crate::plot::spacetime_density_label(found),
        found.spectrum.view(),
    );
    let mut rows: Vec<Vec<Picture>> = vec![vec![map.into()]];
    for (i, chart) in spacetime_cuts(found).iter().enumerate() {
        rows.push(vec![
            CurveGroup::of_chart(&format!("chart-{i}"), "", chart).into(),
        ]);
    }
    let independence = &found.independence;
    let interval = match found.degrees_range() {
        Some([least, degrees, most]) => {
            let [low, high] = interval_factors(degrees, found.alpha);
            format!(
                "With probability {} the true density is between {} and {} of a value: {} degrees of freedom{}",
                percent(1.0 - found.alpha),
                number(low),
                number(high),
                number(degrees),
                match least < most {
                    true => format!(" ({} to {})", number(least), number(most)),
                    false => String::new(),
                }
            )
        }
        None => format!("No interval can be stated: {}", found.independence.why()),
    };
    let [plus, minus, neither] = found.directions();
    let unit = found.unit.as_ref().map(|unit| format!(" ({unit})²"));
    let unit = unit.unwrap_or_default();
    let table = page::table(
        "Averages",
        &[
            ("records", independence.records.to_string()),
            ("segments of a record", independence.segments.to_string()),
            ("tapers along time", found.tapers[0].to_string()),
            ("tapers along space", found.tapers[1].to_string()),
            ("samples a segment", found.segment[0].to_string()),
            ("effective realisations", number(independence.effective)),
            ("power", format!("{}{unit}", number(found.power))),
            (
                "mean square",
                format!("{}{unit}", number(found.mean_square)),
            ),
            ("Parseval residual", format!("{:.1e}", found.parseval)),
        ],
    );
    let json = SpaceTimeSummary::new(found, provenance).to_json()?;
    let page = Page {
        title: format!("Space-time spectrum of {name}"),
        sentence: format!(
            "Power spectral density over wavenumber and frequency, times in {time_unit}, positions in {space_unit}"
        ),
        answers: markup! {
            (page::answer("How well is the spectrum known?", interval))
            (page::answer(
                "Which way does the power travel?",
                format!(
                    "{} towards +x, {} towards -x, {} neither",
                    percent(plus),
                    percent(minus),
                    percent(neither)
                ),
            ))
        },
        warnings: page::warnings(
            &warnings
                .iter()
                .map(|[message, advice]| (message.clone(), Some(advice.clone())))
                .collect::<Vec<_>>(),
        ),
        rows,
        rest: markup! {
            (page::numbers(markup! { (table) }))
            (page::how_to_read(&DEFINITIONS))
            (page::folded("summary", "Summary", markup! { pre { (json) } }))
        },
        style: *style,
    };
    Ok(page.html())
}
