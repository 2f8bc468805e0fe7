//! Pages of localized waves: the table of orders, one wave, its travel.

use maud::{Markup, html as markup};

use crate::localized::{Alternation, Exact, Family, Journey, OrderRow, Ratio, Snapshot, Wave};
use crate::plot::{Chart as Drawn, Style, journey_charts, wave_charts};
use crate::report::page::{self, Chart, CurveGroup, Look, Page, Picture, Series, number};

/// Samples on each side of the center of a wave that the table's page draws.
const HALF: usize = 400;
/// Digits of a ratio after the point.
const DIGITS: usize = 12;

const DEFINITIONS: [(&str, &str); 4] = [
    (
        "Localized wave",
        "A pulse that travels along a dimer chain and leaves no energy behind. It exists at isolated \
         ratios, which its order counts from the homogeneous chain on.",
    ),
    (
        "Time in cells",
        "The unit of time is what the wave takes over a cell of two contacts.",
    ),
    (
        "ψ",
        "psi in archives: F^(1/p), with F the force of a contact and p the exponent of its law.",
    ),
    (
        "Estimate",
        "Asymptotic: a fast oscillation driven by the slow wave, exact or fitted.",
    ),
];

/// The page of a table of orders.
pub fn localized_html(family: Family, orders: &[OrderRow]) -> String {
    let exact = orders.iter().filter_map(|row| {
        let exact = row.exact.as_ref()?;
        let ratio = format!("{:.DIGITS$}", exact.ratio.value());
        Some((
            format!("order {}", row.order),
            format!("{ratio} ± {}", error_of(exact)),
        ))
    });
    let unresolved = orders.iter().filter_map(|row| {
        let reason = row.reason.as_ref()?;
        Some((format!("order {} is unresolved: {reason}", row.order), None))
    });
    let page = Page {
        title: "Localized waves".into(),
        sentence: format!(
            "Dimers whose {} alternates, contact law of exponent {}",
            alternating(family.alternation),
            family.exponent
        ),
        answers: page::answers(
            "At which ratios does a dimer carry localized waves?",
            exact.collect(),
        ),
        warnings: page::warnings(&unresolved.collect::<Vec<_>>()),
        rows: table_pictures(orders),
        rest: markup! {
            (page::numbers(table(orders)))
            (page::how_to_read(&DEFINITIONS))
        },
        style: Style::default(),
    };
    page.html()
}

fn alternating(alternation: Alternation) -> &'static str {
    match alternation {
        Alternation::Stiffness => "stiffness",
        Alternation::Mass => "mass",
    }
}

fn table_pictures(orders: &[OrderRow]) -> Vec<Vec<Picture>> {
    let over_order = |label: &str, look: Look, value: &dyn Fn(&OrderRow) -> Option<f64>| {
        let points: Vec<(f64, f64)> = orders
            .iter()
            .filter_map(|row| Some((row.order as f64, value(row)?)))
            .collect();
        (!points.is_empty()).then(|| Series::points(label, &points).looking(look))
    };
    let chart = |id: &str, title: &str, caption: &str, label: &str, series: Vec<Option<Series>>| {
        let series: Vec<Series> = series.into_iter().flatten().collect();
        let axis = ("order", None);
        (!series.is_empty()).then(|| {
            vec![
                CurveGroup::new(
                    (id, title),
                    caption,
                    axis,
                    &[],
                    vec![Chart::new(label, series).log()],
                )
                .into(),
            ]
        })
    };
    let mut rows = Vec::new();
    rows.extend(chart(
        "ratios",
        "Ratios of localized waves",
        "Exact ratios, asymptotic estimates, and where struck chains lose least.",
        "ratio",
        vec![
            over_order("exact", Look::Line, &|row| {
                Some(row.exact.as_ref()?.ratio.value())
            }),
            over_order("estimate, exact wave", Look::Dots, &|row| {
                Some(row.asymptotic?.exact_profile)
            }),
            over_order("estimate, fitted wave", Look::Dots, &|row| {
                row.asymptotic?.fitted_profile
            }),
            over_order("struck chains", Look::Dots, &|row| {
                Some(row.direct?.ratio.value())
            }),
        ],
    ));
    rows.extend(chart(
        "leak",
        "Energy that a pulse loses in a cell",
        "Share of a struck chain's pulse, at the localized ratios and, most, between them.",
        "leak a cell",
        vec![
            over_order("at the order", Look::Line, &|row| Some(row.direct?.leak)),
            over_order("largest before the next", Look::Line, &|row| {
                Some(row.most_dispersive?.leak)
            }),
        ],
    ));
    rows.extend(profiles(orders).map(|group| vec![group.into()]));
    rows
}

/// The forces of all waves, each over its largest.
fn profiles(orders: &[OrderRow]) -> Option<CurveGroup> {
    let waves: Vec<&Wave> = orders.iter().filter_map(|row| row.wave.as_ref()).collect();
    let of = |contact: usize, label: &str| {
        let series = waves.iter().map(|wave| {
            let profile = wave.profile(HALF);
            let force = &profile.force[contact];
            let largest = force.iter().fold(0.0, |most: f64, f| most.max(*f));
            let points = profile
                .time
                .iter()
                .zip(force)
                .map(|(t, f)| (*t, f / largest));
            let near: Vec<(f64, f64)> = points.filter(|point| point.0.abs() <= REACH).collect();
            Series::points(format!("order {}", wave.order), &near)
        });
        Chart::new(label, series.collect())
    };
    let names = match waves.first()?.alternation {
        Alternation::Stiffness => ["soft contact", "stiff contact"],
        Alternation::Mass => ["before the light site", "behind it"],
    };
    let labels = names.map(|name| format!("force, {name} / largest"));
    Some(CurveGroup::new(
        ("waves", "The waves"),
        "Force of the two contacts of a cell while the wave passes. The order is the number of maxima \
         in its fast part.",
        ("time (cells)", None),
        &[],
        vec![of(0, &labels[0]), of(1, &labels[1])],
    ))
}

/// Cells on each side of the center that are drawn of all waves.
const REACH: f64 = 2.5;

fn table(orders: &[OrderRow]) -> Markup {
    let head = [
        "order",
        "exact ratio",
        "relative error",
        "estimate, exact wave",
        "estimate, fitted wave",
        "struck chain",
        "leak a cell",
        "printed in the paper",
    ];
    let optional = |value: Option<f64>| value.map_or("–".into(), number);
    let rows = orders.iter().map(|row| {
        let exact = row.exact.as_ref();
        vec![
            row.order.to_string(),
            exact.map_or("unresolved".into(), |e| {
                format!("{:.DIGITS$}", e.ratio.value())
            }),
            optional(exact.map(|e| e.error)),
            optional(row.asymptotic.map(|a| a.exact_profile)),
            optional(row.asymptotic.and_then(|a| a.fitted_profile)),
            optional(row.direct.map(|d| d.ratio.value())),
            optional(row.direct.map(|d| d.leak)),
            optional(row.published.map(|p| p.direct)),
        ]
    });
    page::grid("Orders", &head, &rows.collect::<Vec<_>>())
}

/// Error of a ratio, absolute.
fn error_of(exact: &Exact) -> String {
    page::in_powers(exact.error * exact.ratio.value(), 0)
}

/// The page of one wave.
pub fn wave_html(wave: &Wave, profile: &Snapshot) -> String {
    let exact = Exact::of(wave);
    let rows = [
        ("Ratio", format!("{:.DIGITS$}", exact.ratio.value())),
        ("Relative error", number(exact.error)),
        (
            "Speed, sites per time over F^((p−1)/(2p))",
            number(exact.speed_coefficient),
        ),
        ("Width (sites)", number(exact.width)),
        ("Energy", number(exact.energy)),
        ("Momentum", number(exact.momentum)),
        (
            "Residual of the equation",
            number(exact.convergence.residual),
        ),
        ("Tail", number(exact.convergence.tail)),
    ];
    let answer = format!("{:.DIGITS$} ± {}", exact.ratio.value(), error_of(&exact));
    one_wave(
        format!("Localized wave of order {}", wave.order),
        format!("{}, exponent {}", ratio_name(wave.ratio()), wave.exponent),
        page::answer("At which ratio does it travel?", answer),
        &wave_charts(wave, profile),
        &rows,
    )
}

/// The page of a launched wave.
pub fn journey_html(journey: &Journey) -> String {
    let arrived = &journey.arrived;
    let rows = [
        ("Cells travelled", arrived.cells.to_string()),
        (
            "Shape change over the largest velocity",
            number(arrived.shape_change),
        ),
        (
            "Two runs of different local errors differ by",
            number(journey.stepping_error),
        ),
        ("Leak a cell, of the energy", number(arrived.leak)),
        ("Energy drift", number(arrived.energy_drift)),
    ];
    let answer = format!(
        "After {} cells its velocities differ by {} of the largest; it has lost {} of its energy \
         a cell.",
        arrived.cells,
        page::in_powers(arrived.shape_change, 1),
        page::in_powers(arrived.leak, 1)
    );
    one_wave(
        format!("Launched wave of order {}", journey.order),
        format!("{} {}", ratio_name(journey.ratio), journey.ratio.value()),
        page::answer("Does it keep its shape?", answer),
        &journey_charts(journey),
        &rows,
    )
}

fn ratio_name(ratio: Ratio) -> &'static str {
    match ratio {
        Ratio::Kappa(_) => "Stiffness ratio",
        Ratio::MassRatio(_) => "Mass ratio",
    }
}

fn one_wave(
    title: String,
    sentence: String,
    answers: Markup,
    charts: &[Drawn],
    rows: &[(&str, String)],
) -> String {
    let pictures = charts.iter().enumerate().map(|(n, chart)| {
        let group = CurveGroup::of_chart(&format!("panel-{}", n + 1), "", chart);
        vec![Picture::from(group)]
    });
    let page = Page {
        title,
        sentence,
        answers,
        warnings: page::warnings(&[]),
        rows: pictures.collect(),
        rest: markup! {
            (page::numbers(markup! { div class="tables" { (page::table("The wave", rows)) } }))
            (page::how_to_read(&DEFINITIONS[..3]))
        },
        style: Style::default(),
    };
    page.html()
}
