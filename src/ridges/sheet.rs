//! What ridges say.

use serde_json::json;

use super::{Ridge, RidgeCut, RidgeFit, RidgeParameter, RidgePoint, Ridges};
use crate::analyze::{DispersionCurve, labels};
use crate::numeric::median;
use crate::sheet::{
    BLACK, BLUE, Chart, Describe, HeatChart, Level, Look, PALETTE, PlotRow, Role, Series, Sheet,
    Table, Units, VERMILLION, extent, name_of, number, percent, with_half, with_unit,
};
use crate::unit::{self, label};

const DEFINITIONS: [[&str; 2]; 5] = [
    [
        "Ridge",
        "A row of peaks of S(k, f): along k at each frequency where a branch is steep, along f at each wavenumber \
         where it is flat. Peaks stand above the level, above what stronger waves leak, and apart from them.",
    ],
    [
        "Level",
        "The power over the mean of the noise about it that noise exceeds anywhere in the spectrum with the \
         stated probability; the noise is the local median.",
    ],
    [
        "Place",
        "The top of the parabola through the logarithms of three bins, corrected for the window; of a broad \
         ridge its centre above half of the maximum. Its error is that of noise, or the spread about neighbouring \
         points.",
    ],
    ["Phase velocity", "2πf/k, positive towards +x."],
    [
        "Group velocity",
        "2π df/dk, of a parabola through the points about it, by least squares.",
    ],
];

/// Points whose velocity is known to a tenth, at least, for one to be named.
const LEAST_KNOWN: usize = 5;
/// Spread of velocities that are one, over their median.
const ALIKE: f64 = 0.15;
/// Mean square of their distances from the median, over their errors, from which on they differ by more than these.
const DIFFERENT: f64 = 4.0;
/// Velocities known no better than this share of them are not drawn.
const RESOLVED: f64 = 0.3;

/// Numbers of a point, by their names in tables and archives.
#[allow(clippy::type_complexity)]
const COLUMNS: [(&str, fn(&RidgePoint) -> f64); 11] = [
    ("frequency", |p| p.frequency),
    ("frequency_error", |p| p.frequency_error),
    ("wavenumber", |p| p.wavenumber),
    ("wavenumber_error", |p| p.wavenumber_error),
    ("power", |p| p.power),
    ("noise", |p| p.noise),
    ("width", |p| p.width),
    ("phase_velocity", |p| p.phase_velocity),
    ("phase_velocity_error", |p| p.phase_velocity_error),
    ("group_velocity", |p| p.group_velocity),
    ("group_velocity_error", |p| p.group_velocity_error),
];

impl Describe for Ridges {
    /// Variables of each point: `branch`, `at_frequency` (1 for cuts at a frequency, 0 for those at a wavenumber) and
    /// the columns of [`Ridges::csv`]; of each fit n `fit_n_wavenumber` and `fit_n_frequency` (branches, wavenumbers).
    fn describe(&self) -> Sheet<'_> {
        let axes = &self.analysis.axes;
        let conventions = &self.analysis.conventions;
        let (time_unit, space_unit) = (axes.time_unit(), axes.space_unit());
        let (level, chance) = (number(self.level), percent(self.alpha));
        let above = format!("Peaks exceed {level} times the");
        let (note, of_level) = match self.is_single() {
            true => {
                let why = self.independence.why();
                (
                    format!("{above} background about them."),
                    format!("{level}: {why}"),
                )
            }
            false => {
                let by_chance = format!("noise does so anywhere with probability {chance}.");
                (
                    format!("{above} noise about them; {by_chance}"),
                    format!("{level} at {chance}"),
                )
            }
        };
        let mut sheet = Sheet {
            about: format!("dispersion, times in {time_unit}, lengths in {space_unit}"),
            answer: self.answer(),
            note,
            needs_sites_in_step: true,
            ..Sheet::of("ridges", "Ridges of S(k, f)", &DEFINITIONS)
        };
        if !self.ridges.is_empty() {
            let ridges = format!("{} of {} branches", self.ridges.len(), self.branches());
            let points = self.points().count();
            let text = format!("{ridges} with {points} points above {level} times the noise");
            sheet.fact("ridges", text);
        }
        for fit in &self.fits {
            let law = format!("{}: {}", fit.name, fit.parameters_in_words());
            let [off, chi] = [fit.deviation, fit.reduced].map(number);
            let text = format!("{law}; deviation {off} bins, reduced chi-square {chi}");
            sheet.fact("fit", text);
        }
        if self.is_single() {
            sheet.warnings.push(self.independence.transient("field"));
        }
        sheet.warnings.extend_from_slice(&self.analysis.warnings);
        let [df, dk] = self.bins;
        let df = with_unit(df, &axes.frequency_unit());
        let dk = with_unit(dk, &axes.wavenumber_unit());
        let rows = [
            ("records", self.records.to_string()),
            ("segments of a record", conventions.segments.to_string()),
            ("samples a segment", conventions.segment.to_string()),
            ("effective realisations", number(self.realisations)),
            ("level over the noise", of_level),
            ("bin of frequency", df),
            ("bin of wavenumber", dk),
        ];
        sheet.tables.push(Table::of_values("Spectrum", rows));
        sheet.tables.extend(self.fit_table());
        sheet.numbers(json!({
            "time_unit": time_unit,
            "space_unit": space_unit,
            "records": self.records,
            "segment": conventions.segment,
            "overlap": conventions.overlap,
            "segments": conventions.segments,
            "window_time": conventions.window_time.name,
            "window_space": conventions.window_space.name,
            "realisations": self.realisations,
            "steadiness": self.independence.steadiness,
            "alpha": self.alpha,
            "level": self.level,
            "frequency_bin": self.bins[0],
            "wavenumber_bin": self.bins[1],
            "frequency_resolution": self.resolution[0],
            "wavenumber_resolution": self.resolution[1],
            "branches": self.branches(),
            "lone_peaks": self.lone,
            "ridges": self.ridges.iter().map(Ridge::numbers).collect::<Vec<_>>(),
            "fits": self.fits.iter().map(RidgeFit::numbers).collect::<Vec<_>>(),
        }));
        self.variables(&mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let map = self.map().map(|map| PlotRow::of([map]).high(1.4));
        let places = (!self.ridges.is_empty()).then(|| PlotRow::of([self.place_chart()]).high(1.2));
        let velocities = self.velocity_charts();
        let velocities = (!velocities.is_empty()).then(|| PlotRow::of(velocities));
        [map, places, velocities].into_iter().flatten().collect()
    }
}

impl Ridge {
    fn numbers(&self) -> serde_json::Value {
        let ends = |of: fn(&RidgePoint) -> f64| {
            let all = self.points.iter().map(of);
            let low = all.clone().fold(f64::INFINITY, f64::min);
            [low, all.fold(f64::NEG_INFINITY, f64::max)]
        };
        json!({
            "branch": self.branch,
            "cut": self.cut,
            "points": self.points.len(),
            "frequency": ends(|point| point.frequency),
            "wavenumber": ends(|point| point.wavenumber),
        })
    }
}

impl RidgeFit {
    fn numbers(&self) -> serde_json::Value {
        json!({
            "law": self.name,
            "parameters": self.parameters,
            "points": self.points,
            "deviation_bins": self.deviation,
            "reduced_chi_square": self.reduced,
        })
    }

    /// The parameters with their standard errors, where they have them.
    fn parameters_in_words(&self) -> String {
        let of = |p: &RidgeParameter| match p.error.is_finite() {
            true => format!("{} = {} ± {}", p.name, number(p.value), number(p.error)),
            false => format!("{} = {}", p.name, number(p.value)),
        };
        let all: Vec<String> = self.parameters.iter().map(of).collect();
        all.join(", ")
    }
}

impl Ridges {
    fn velocity_unit(&self) -> String {
        let axes = &self.analysis.axes;
        format!("{}/{}", axes.space_unit(), axes.time_unit())
    }

    /// The law, or the velocity, in words.
    fn answer(&self) -> String {
        if self.ridges.is_empty() {
            let Some(lone) = self.lone.first() else {
                return "no ridge stands above the noise".into();
            };
            let axes = &self.analysis.axes;
            let peaks = match self.lone.len() {
                1 => "one lone peak stands above the noise, near".to_owned(),
                count => format!("{count} lone peaks stand above the noise, the largest near"),
            };
            let frequency = with_unit(lone[0], &axes.frequency_unit());
            let wavenumber = with_unit(lone[1], &axes.wavenumber_unit());
            return format!("no ridge: {peaks} {frequency}, {wavenumber}");
        }
        // Relative to the number of free points.
        let fits = self.fits.iter().filter(|fit| fit.deviation < 1.0);
        if let Some(fit) = fits.min_by(|a, b| a.reduced.total_cmp(&b.reduced)) {
            let have_errors = fit.parameters.iter().all(|p| p.error.is_finite());
            let errors = if have_errors {
                " (standard errors)"
            } else {
                ""
            };
            let (words, off) = (fit.parameters_in_words(), number(fit.deviation));
            return format!("{} with {words}{errors}, within {off} bins", fit.name);
        }
        let unit = self.velocity_unit();
        let branches = match self.branches() {
            1 => "one branch".to_owned(),
            count => format!("{count} branches"),
        };
        if self.is_single() {
            let speeds = self.points().map(|p| p.group_velocity.abs());
            let around = median(speeds.filter(|speed| speed.is_finite()))
                .map(|speed| format!(", group velocity around {} {unit}", number(speed)));
            let around = around.unwrap_or_default();
            return format!("{branches}{around}; of a single transient no error is stated");
        }
        let magnitudes = |of: fn(&RidgePoint) -> [f64; 2]| {
            let known = self.points().map(of);
            let known = known.filter(|[speed, error]| *error < 0.1 * speed.abs());
            let mut speeds: Vec<[f64; 2]> = known.map(|[speed, e]| [speed.abs(), e]).collect();
            speeds.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let at = |share: f64| speeds[(share * (speeds.len() - 1) as f64).round() as usize][0];
            (speeds.len() >= LEAST_KNOWN).then(|| {
                let [low, middle, high] = [0.05, 0.5, 0.95].map(at);
                let off = speeds.iter().map(|[v, e]| ((v - middle) / e).powi(2));
                let by_errors = off.sum::<f64>() < DIFFERENT * speeds.len() as f64;
                let are_alike = by_errors || high - low < ALIKE * middle;
                ([low, middle, high], are_alike)
            })
        };
        // Folded wavenumbers have other phase velocities, but the same group velocity.
        let group = magnitudes(|p| [p.group_velocity, p.group_velocity_error]);
        if let Some(([low, middle, high], true)) = group {
            let [plus, minus] = [1.0, -1.0].map(|sign| {
                let signed = self.points().filter(|p| sign * p.group_velocity > 0.0);
                signed.count()
            });
            let ways = match minus * 20 < plus {
                true => "towards +x",
                false if plus * 20 < minus => "towards -x",
                false => "both ways",
            };
            let speed = with_half(middle, 0.5 * (high - low), &unit);
            return format!("waves {ways} at a group velocity of {speed} ({branches})");
        }
        let phase = magnitudes(|p| [p.phase_velocity, p.phase_velocity_error]);
        let known = group.map(|known| ("group", known));
        match known.or(phase.map(|known| ("phase", known))) {
            Some((name, ([low, _, high], _))) => {
                let [low, high] = [low, high].map(number);
                format!("{branches}, {name} velocity from {low} to {high} {unit}")
            }
            None => format!("{branches}, no velocity of which is known to a tenth"),
        }
    }

    fn fit_table(&self) -> Option<Table> {
        let rows = self.fits.iter().flat_map(|fit| {
            fit.parameters.iter().map(|parameter| {
                let numbers = [parameter.value, parameter.error, fit.deviation, fit.reduced];
                let names = [fit.name.clone(), parameter.name.clone()];
                names.into_iter().chain(numbers.map(number)).collect()
            })
        });
        let head = [
            "law",
            "parameter",
            "value",
            "standard error",
            "deviation (bins)",
            "reduced χ²",
        ];
        (!self.fits.is_empty()).then(|| Table::of("Fitted laws", &head, rows))
    }

    /// The points as a table, a row each: `branch`, `cut`, then the numbers; empty cells where one is not defined.
    pub fn csv(&self) -> String {
        let names = COLUMNS.map(|(name, _)| name);
        let mut text = format!("branch,cut,{}\n", names.join(","));
        for ridge in &self.ridges {
            for point in &ridge.points {
                let cells = COLUMNS.map(|(_, of)| match of(point) {
                    value if value.is_finite() => value.to_string(),
                    _ => String::new(),
                });
                let (branch, cut) = (ridge.branch, name_of(&ridge.cut));
                text += &format!("{branch},{cut},{}\n", cells.join(","));
            }
        }
        text
    }

    fn variables(&self, sheet: &mut Sheet) {
        let (axes, sample) = (&self.analysis.axes, self.analysis.unit.as_deref());
        let units = Units::of(&axes.time, &axes.space, sample);
        let density = labels::Power::of(&self.analysis).over_both();
        let density = unit::split(&density).1;
        let mut line = |name, unit: &str, values: Vec<f64>| sheet.line(name, "point", unit, values);
        let points = self.ridges.iter();
        let ridges = points.flat_map(|ridge| ridge.points.iter().map(move |_| ridge));
        let is_cut = |ridge: &Ridge| f64::from(u8::from(ridge.cut == RidgeCut::Frequency));
        let branch = |ridge: &Ridge| ridge.branch as f64;
        line("branch", "", ridges.clone().map(branch).collect());
        line("at_frequency", "", ridges.map(is_cut).collect());
        for (name, of) in COLUMNS {
            let of_column = match name {
                "frequency" | "frequency_error" => &units.frequency,
                "wavenumber" | "wavenumber_error" => &units.wavenumber,
                "power" | "noise" => density,
                // Along k at some points, along f at others.
                "width" => "",
                _ => &units.velocity,
            };
            line(name, of_column, self.points().map(of).collect());
        }
        for (n, fit) in self.fits.iter().enumerate() {
            let curve = &fit.curve;
            let [axis, branches, name] =
                ["wavenumber", "branch", "frequency"].map(|name| format!("fit_{n}_{name}"));
            sheet.line(&axis, &axis, &units.wavenumber, curve.wavenumber.clone());
            let axes = [
                (&branches[..], curve.branches.len()),
                (&axis, curve.wavenumber.len()),
            ];
            sheet.variable(&name, &axes, &units.frequency, curve.branches.concat());
        }
    }

    /// The spectrum, with the curves over it.
    fn map(&self) -> Option<HeatChart> {
        let analysis = &self.analysis;
        let map = analysis.spacetime_map.as_ref()?.shown();
        Some(HeatChart {
            title: "space-time spectrum S(k, f)".into(),
            caption: "Power by wavenumber and frequency; positive wavenumbers travel towards +x."
                .into(),
            x_label: map.x.label.clone(),
            y_label: map.y.label.clone(),
            label: map.label.clone(),
            x: map.x.low..map.x.high,
            y: map.y.low..map.y.high,
            values: map.values.mapv(f64::from),
            curves: DispersionCurve::curves(&analysis.dispersion),
            roles: Some([Role::Wavenumber, Role::Frequency]),
            ..HeatChart::default()
        })
    }

    /// Frequency over wavenumber, with the fitted laws.
    fn place_chart(&self) -> Chart {
        let axes = &self.analysis.axes;
        let colours = PALETTE.len() - 1;
        let branch = |branch: usize| {
            let name = match branch < colours {
                true => format!("branch {branch}"),
                false => String::new(),
            };
            let ridges = self.ridges.iter().filter(|ridge| ridge.branch == branch);
            let points = ridges.flat_map(|ridge| &ridge.points);
            let points = points.map(|p| (p.wavenumber, p.frequency));
            Series::line(name, branch % colours, points.collect()).with(Look::Dots)
        };
        let laws: Vec<DispersionCurve> = self.fits.iter().map(|fit| fit.curve.clone()).collect();
        let fitted = DispersionCurve::curves(&laws).into_iter();
        let fitted = fitted.map(|curve| Series::line(curve.label, BLACK, curve.points));
        let fitted = fitted.map(|series| series.with(Look::Dashed));
        let series = (0..self.branches()).map(branch).chain(fitted).collect();
        let (k, f) = (labels::wavenumber(axes), labels::frequency(axes));
        Chart {
            x: extent(axes.wavenumber_signed.iter().copied()),
            ..Chart::of("ridges", k, f, series)
        }
    }

    /// Phase and group velocity over frequency, where they are known.
    fn velocity_charts(&self) -> Vec<Chart> {
        let chart = |title: &str, colour, of: &dyn Fn(&RidgePoint) -> [f64; 2]| {
            let known = self.points().map(|point| (point.frequency, of(point)));
            let known = known.filter(|(_, [value, error])| *error < RESOLVED * value.abs());
            let points = known.map(|(f, [value, error])| [f, value, error]);
            let series = Series::with_errors("", colour, points).with(Look::Dots);
            let frequency = labels::frequency(&self.analysis.axes);
            let velocity = label("velocity", &self.velocity_unit());
            (series.points.len() > 1).then(|| Chart {
                levels: vec![Level::zero()],
                ..Chart::of(title, frequency, velocity, vec![series])
            })
        };
        let phase = chart("phase velocity", BLUE, &|p| match self.is_single() {
            // That of a transient is as good as the place of its peak, without an error; slopes are not.
            true => [p.phase_velocity, 0.0],
            false => [p.phase_velocity, p.phase_velocity_error],
        });
        let group = chart("group velocity", VERMILLION, &|p| {
            [p.group_velocity, p.group_velocity_error]
        });
        phase.into_iter().chain(group).collect()
    }
}
