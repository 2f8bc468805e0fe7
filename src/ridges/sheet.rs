//! What ridges say.

use serde_json::json;

use super::{Ridge, RidgeCut, RidgeFit, RidgePoint, Ridges};
use crate::analyze::DispersionCurve;
use crate::analyze::axes::Side;
use crate::analyze::labels::Power;
use crate::arrays::LargeArray;
use crate::numeric::sorted;
use crate::sheet::{
    BLUE, Chart, Column, Describe, Look, PlotRow, Role, Series, Sheet, Units, VERMILLION, name_of,
    number, percent, with_half, with_unit,
};
use crate::unit::{self, label};

const DEFINITIONS: &str = "\
    Ridge: A row of peaks of S(k, f): along k at each frequency where a branch is steep, along f at each wavenumber where it is \
        flat. Peaks stand above the level, above what stronger waves leak, and apart from them.
    Level: The power over the local noise that noise exceeds anywhere in the spectrum with the stated probability.
    Place: The top of the parabola through the logarithms of three bins, corrected for the window; of a broad ridge its centre.
    Fitted law: Weighted least squares of all points; ± are standard errors.
    Phase velocity: 2πf/k, positive towards +x.
    Group velocity: 2π df/dk, of a parabola through the points about it, by least squares.";

/// Points whose velocity is known to a tenth, at least, for one to be named.
const LEAST_KNOWN: usize = 5;
/// Velocities known no better than this share of them are not drawn.
const RESOLVED: f64 = 0.3;

/// Numbers of a point in tables and archives.
fn columns<'u>(units: &'u Units, density: &'u str) -> [Column<'u, RidgePoint>; 11] {
    let [f, k, velocity] = [&units.frequency, &units.wavenumber, &units.velocity];
    [
        ("frequency", f, |p| p.frequency),
        ("frequency_error", f, |p| p.frequency_error),
        ("wavenumber", k, |p| p.wavenumber),
        ("wavenumber_error", k, |p| p.wavenumber_error),
        ("power", density, |p| p.power),
        ("noise", density, |p| p.noise),
        // Along k at some points, along f at others.
        ("width", "", |p| p.width),
        ("phase_velocity", velocity, |p| p.phase_velocity),
        ("phase_velocity_error", velocity, |p| p.phase_velocity_error),
        ("group_velocity", velocity, |p| p.group_velocity),
        ("group_velocity_error", velocity, |p| p.group_velocity_error),
    ]
}

impl Describe for Ridges {
    /// Variables of each point: `branch`, `at_frequency` (1 for cuts at a frequency, 0 for those at a wavenumber) and
    /// the columns of [`Ridges::csv`]; of each fit n `fit_n_wavenumber` and `fit_n_frequency` (branches, wavenumbers).
    fn describe(&self) -> Sheet<'_> {
        let conventions = &self.analysis.conventions;
        let words = self.words();
        let level = number(self.level);
        let of_level = match self.is_single() {
            true => format!("{level}; {}", self.independence.why()),
            false => format!("{level}, at {}", percent(self.alpha)),
        };
        let mut sheet = Sheet {
            about: "dispersion read off the space-time spectrum".into(),
            answer: self.answer(),
            note: format!("Level of peaks over the noise: {of_level}."),
            needs_sites_in_step: true,
            ..Sheet::of("ridges", "Ridges of S(k, f)", DEFINITIONS)
        };
        let (ridges, branches) = (self.ridges.len(), self.branches());
        let points = self.points().count();
        let text = format!(
            "{ridges} of {branches} branches with {points} points above {level} times the noise"
        );
        sheet.fact("ridges", text);
        for fit in &self.fits {
            let [off, chi] = [fit.deviation, fit.reduced].map(number);
            let text = format!(
                "{}: {}; deviation {off} bins, reduced chi-square {chi}",
                fit.name,
                fit.parameters_in_words()
            );
            sheet.fact("fit", text);
        }
        if self.is_single() {
            sheet.warnings.push(self.independence.warning());
        }
        sheet.warnings.extend_from_slice(&self.analysis.warnings);
        let [df, dk] = self.bins;
        sheet.numbers(json!({
            "time_unit": words.time,
            "space_unit": words.space,
            "records": self.independence.records,
            "segment": conventions.segment,
            "overlap": conventions.overlap,
            "segments": conventions.segments,
            "window_time": conventions.window_time.name,
            "window_space": conventions.window_space.name,
            "realisations": self.independence.effective,
            "steadiness": self.independence.steadiness,
            "alpha": self.alpha,
            "level": self.level,
            "frequency_bin": df,
            "wavenumber_bin": dk,
            "frequency_resolution": self.resolution[0],
            "wavenumber_resolution": self.resolution[1],
            "branches": branches,
            "lone_peaks": self.lone,
            "ridges": self.ridges.iter().map(Ridge::numbers).collect::<Vec<_>>(),
            "fits": self.fits,
        }));
        self.variables(&mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let map = self.map().map(|map| PlotRow::of([map]).high(1.4));
        let velocities = self.velocity_chart().map(|chart| PlotRow::of([chart]));
        map.into_iter().chain(velocities).collect()
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
    /// The parameters with their standard errors, where they have them.
    fn parameters_in_words(&self) -> String {
        let parameters = self.parameters.iter();
        let all = parameters.map(|p| format!("{} = {}", p.name, with_half(p.value, p.error, "")));
        all.collect::<Vec<_>>().join(", ")
    }
}

impl Ridges {
    fn words(&self) -> Units {
        let axes = &self.analysis.axes;
        Units::in_words(&axes.time, &axes.space, None)
    }

    /// The law, or the velocity, in words.
    fn answer(&self) -> String {
        let words = self.words();
        if self.ridges.is_empty() {
            let lone = self.lone.first().map(|[frequency, wavenumber]| {
                let frequency = with_unit(*frequency, &words.frequency);
                let wavenumber = with_unit(*wavenumber, &words.wavenumber);
                let count = self.lone.len();
                format!("; lone peaks: {count}, the largest near {frequency}, {wavenumber}")
            });
            let lone = lone.unwrap_or_default();
            return format!("no ridge stands above the noise{lone}");
        }
        // Relative to the number of free points.
        let fits = self.fits.iter().filter(|fit| fit.deviation < 1.0);
        if let Some(fit) = fits.min_by(|a, b| a.reduced.total_cmp(&b.reduced)) {
            let (parameters, off) = (fit.parameters_in_words(), number(fit.deviation));
            return format!("{} with {parameters}, within {off} bins", fit.name);
        }
        let spread = |name: &str, of: fn(&RidgePoint) -> [f64; 2]| {
            let known = self.points().map(of).filter(|[speed, error]| {
                let is_single = self.is_single() && speed.is_finite();
                is_single || *error < 0.1 * speed.abs()
            });
            let known: Vec<f64> = known.map(|[speed, _]| speed).collect();
            let plus = known.iter().filter(|speed| **speed > 0.0).count();
            let share = percent(plus as f64 / known.len() as f64);
            let speeds = sorted(known.iter().map(|speed| speed.abs()));
            let last = speeds.len().saturating_sub(1) as f64;
            let at = |share: f64| number(speeds[(share * last).round() as usize]);
            let unit = &words.velocity;
            (speeds.len() >= LEAST_KNOWN).then(|| {
                let [low, middle, high] = [0.05, 0.5, 0.95].map(at);
                format!("{name} velocity {middle} {unit} ({low} to {high} at nine of ten points), {share} of them towards +x")
            })
        };
        // Folded wavenumbers have other phase velocities, but the same group velocity.
        let group = spread("group", |p| [p.group_velocity, p.group_velocity_error]);
        let phase = || spread("phase", |p| [p.phase_velocity, p.phase_velocity_error]);
        let known = group.or_else(phase);
        let known = known.unwrap_or("no velocity is known to a tenth".into());
        format!("branches: {}; {known}", self.branches())
    }

    /// The points as a table, a row each: `branch`, `cut`, then the numbers; empty cells where one is not defined.
    pub fn csv(&self) -> String {
        let words = self.words();
        let columns = columns(&words, "");
        let mut text = format!("branch,cut,{}\n", columns.map(|(name, ..)| name).join(","));
        for (ridge, point) in self.of_points() {
            let cells = columns.map(|(_, _, of)| match of(point) {
                value if value.is_finite() => value.to_string(),
                _ => String::new(),
            });
            let (branch, cut) = (ridge.branch, name_of(&ridge.cut));
            text += &format!("{branch},{cut},{}\n", cells.join(","));
        }
        text
    }

    fn of_points(&self) -> impl Iterator<Item = (&Ridge, &RidgePoint)> {
        (self.ridges.iter()).flat_map(|ridge| ridge.points.iter().map(move |point| (ridge, point)))
    }

    fn variables(&self, sheet: &mut Sheet) {
        let axes = &self.analysis.axes;
        let units = Units::of(&axes.time, &axes.space, None);
        let density = Power::of(&self.analysis).of_array(LargeArray::SPACETIME_SPECTRUM);
        let branches = self.of_points().map(|(ridge, _)| ridge.branch as f64);
        sheet.line("branch", "point", "", branches.collect::<Vec<_>>());
        let at_frequency = |p: &RidgePoint| f64::from(u8::from(p.cut == RidgeCut::Frequency));
        let at_frequency: Vec<f64> = self.points().map(at_frequency).collect();
        sheet.line("at_frequency", "point", "", at_frequency);
        let points = self.ridges.iter().flat_map(|ridge| &ridge.points);
        sheet.columns("point", points, &columns(&units, unit::split(&density).1));
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
    pub(crate) fn map(&self) -> Option<Chart> {
        let analysis = &self.analysis;
        let map = analysis.maps.get(&LargeArray::SPACETIME_SPECTRUM)?;
        let map = map.shown();
        Some(Chart {
            title: "space-time spectrum S(k, f)".into(),
            caption: "Power by wavenumber and frequency; positive wavenumbers travel towards +x."
                .into(),
            values: map.values.mapv(f64::from),
            reduced: None,
            curves: DispersionCurve::curves(&self.analysis.dispersion),
            roles: [Role::Wavenumber, Role::Frequency].map(Some),
            ..Chart::of_map(map)
        })
    }

    /// Phase and group velocity over frequency, where they are known; those of a transient without errors.
    fn velocity_chart(&self) -> Option<Chart> {
        let series = |name, colour, of: fn(&RidgePoint) -> [f64; 3]| {
            let known = self.points().map(of).filter(|[_, velocity, error]| {
                velocity.is_finite() && (error.is_nan() || *error < RESOLVED * velocity.abs())
            });
            Series::with_errors(name, colour, known).with(Look::Dots)
        };
        let phase = series("phase", BLUE, |p| {
            [p.frequency, p.phase_velocity, p.phase_velocity_error]
        });
        let group = series("group", VERMILLION, |p| {
            [p.frequency, p.group_velocity, p.group_velocity_error]
        });
        let frequency = Side::Frequency.label(&self.analysis.axes);
        let velocity = label("velocity", &self.words().velocity);
        (self.points().next())
            .map(|_| Chart::of("velocities", frequency, velocity, vec![phase, group]).about_zero())
    }
}
