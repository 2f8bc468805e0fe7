//! What spectra say.

use ndarray::Array2;
use serde_json::{Value, json};

use super::{
    LeftOutEach, Line, LineTest, NoiseFloor, NoiseSource, SiteNoise, SpectrumAxis,
    SpectrumEstimate, found::DETRENDED,
};
use crate::estimates::realisations::{
    TRANSIENT, degrees_as_numbers, interval_in_words, spectrum_chart, without_mean,
};
use crate::sheet::{
    BLACK, BLUE, Chart, Describe, HeatChart, Level, Look, Mark, PlotRow, Role, Series, Sheet,
    Table, Units, confidence, edges_from_zero, listed, number, percent, range, six_digits,
    with_range,
};
use crate::unit::label;

const DEFINITIONS: [[&str; 2]; 5] = [
    [
        "Power spectral density",
        "One-sided; its integral over f is the mean square of the samples.",
    ],
    [
        "Degrees of freedom",
        "Twice the number of independent realisations that a value averages, less what unequal weights of the \
         tapers cost. Overlapping segments count by their effective number.",
    ],
    [
        "Interval",
        "Where the true density lies with the stated probability if the record is stationary: by the \
         chi-square distribution of Gaussian records, and by the jackknife, which leaves out one realisation \
         at a time and assumes no distribution.",
    ],
    [
        "Test for lines",
        "F compares the power of a sine of constant amplitude with what is left beside it. Without a line it \
         exceeds the level of one cell with the stated probability, and that of all cells anywhere with the same.",
    ],
    TRANSIENT,
];

/// Places that are named at most.
const NAMED: usize = 3;
/// Bins from which on the width of a peak is more than that of a line under a window.
const RESOLVED: f64 = 5.0;
/// What to do about missing samples.
const LEAVE_OUT: &str = "leave out the segments that miss samples: `--gaps leave-out`";
/// Lines that a table lists.
const LISTED: usize = 20;

impl Describe for SpectrumEstimate {
    /// Variables: `frequency` (nf), `position`, `steadiness` (n); `spectrum`, `degrees_of_freedom`, `low`, `high`,
    /// `jackknife_low`, `jackknife_high` (nf, n), NaN where there is no interval; along time `noise`, `noise_low`,
    /// `noise_high` (n), densities; where segments are left out `segments`, `effective_realisations` (n); of several
    /// tapers `f_statistic` (nf, n). Along space, `wavenumber` and `time` take the place of `frequency` and `position`,
    /// beside `mean_spectrum`, `mean_low`, `mean_high`, `effective_snapshots` (nk).
    fn describe(&self) -> Sheet<'_> {
        let (time_unit, space_unit) = self.units();
        let mut sheet = Sheet {
            about: format!(
                "power spectral density at {} {}, times in {time_unit}, positions in {space_unit}",
                self.spectrum.ncols(),
                self.columns_word()
            ),
            answer: self.answer(),
            note: self.note(),
            ..Sheet::of("spectrum", "Spectra with intervals", &DEFINITIONS)
        };
        sheet.numbers(json!({
            "along": self.along,
            "time_unit": time_unit,
            "space_unit": space_unit,
            "unit": self.unit,
        }));
        let degrees = self.degrees_range();
        sheet.fact("interval", interval_in_words(degrees, self.alpha));
        if let Some(left) = &self.segments_left {
            left.describe(&mut sheet, self.columns_word());
        }
        self.noise_facts(&mut sheet);
        if let Some(test) = self.test_of_lines() {
            self.line_facts(test, &mut sheet);
        }
        if degrees.is_some() && self.has_jackknife && self.left_out == LeftOutEach::Record {
            let text = "over records, whose segments are not independent";
            sheet.detail("jackknife", text);
        }
        let inside = 1..self.segment[0].div_ceil(2);
        if let Some(last) = inside.rev().find(|m| self.detrended[*m] > DETRENDED) {
            let most = self.detrended[1..].iter().copied().fold(0.0, f64::max);
            let (most, at, unit) = (percent(most), number(self.bins[last]), self.bin_unit());
            let text =
                format!("takes up to {most} of the power up to {at} {unit}: no interval there");
            sheet.detail("detrending", text);
        }
        let rows = [("without interval", self.without_interval().to_string())];
        self.independence.describe(&mut sheet, self.segment, rows);
        self.warnings(&mut sheet);
        sheet.numbers(json!({
            "half_bandwidth": self.half_bandwidth,
            "segments_left": self.segments_left,
            "steadiness": self.steadiness,
            "without_interval": self.without_interval(),
            "steadiness_in_time": self.mean.as_ref().map(|mean| mean.steadiness),
            "alpha": self.alpha,
            "degrees_of_freedom": degrees_as_numbers(degrees, self.alpha),
            "jackknife_leaves_out": self.has_jackknife.then_some(self.left_out),
            "noise": self.noise.as_ref().map(NoiseFloor::numbers),
            "line_test": self.line_test.as_ref().map(|test| json!({
                "degrees_of_freedom": test.degrees,
                "level": test.level,
                "level_of_all": test.level_of_all,
                "lines": test.lines,
            })),
        }));
        self.variables(&mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let mut rows = vec![PlotRow::of([self.map()]).high(1.1)];
        rows.extend(self.mean_chart().map(|chart| PlotRow::of([chart])));
        rows.push(PlotRow::of([self.loudest_chart()]).high(1.1));
        let lines = self.line_chart();
        rows.extend(lines.map(|chart| PlotRow::of([chart]).high(0.8)));
        rows
    }
}

impl NoiseFloor {
    /// Of all sites, `null` where it is not known.
    pub(crate) fn numbers(&self) -> Value {
        json!({
            "known": self.known(),
            "sites": self.sites,
            "subtracted": self.subtracted,
        })
    }
}

impl SpectrumEstimate {
    fn columns_word(&self) -> &'static str {
        self.along.of(["sites", "times"])
    }

    /// The test for lines, where anything is significant.
    fn test_of_lines(&self) -> Option<&LineTest> {
        let test = self.line_test.as_ref();
        test.filter(|_| self.degrees_range().is_some())
    }

    /// Which lines or peaks there are, in words.
    fn answer(&self) -> String {
        let column = self.along.of(["site", "time"]);
        if let Some(test) = self.test_of_lines() {
            let Some(first) = test.lines.first() else {
                return format!("no line stands above chance at any {column}");
            };
            let lines = test.lines.iter().map(|line| (line.at, line.column, 0.0));
            return format!(
                "lines at {}; the surest of amplitude {}",
                self.named(lines, column),
                self.amplitude(first)
            );
        }
        let Some(peaks) = self.peaks() else {
            let why = self.independence.why_none();
            return format!("no peak can be told from chance: {why}");
        };
        let Some(first) = peaks.first() else {
            return format!("no peak stands above the power on either side of it at any {column}");
        };
        let width = match first.width > RESOLVED * self.bins[1] {
            true => format!(", {} {} wide", number(first.width), self.bin_unit()),
            false => String::new(),
        };
        format!(
            "peaks at {}; the highest {} times the power beside it{width}",
            self.named(
                peaks.iter().map(|peak| (peak.at, peak.column, peak.width)),
                column
            ),
            number(first.ratio),
        )
    }

    fn amplitude(&self, line: &Line) -> String {
        let unit = self.unit.as_deref().unwrap_or_default();
        let [amplitude, error] = [line.amplitude, line.amplitude_error].map(number);
        let text = format!("{amplitude} ± {error} {unit}");
        text.trim_end().to_owned()
    }

    /// Frequencies and how many sites have them, `50.00 and 100.0 Hz (64 and 3 sites)`; those within two bins, or the width of one of
    /// them, are one.
    fn named(&self, found: impl Iterator<Item = (f64, usize, f64)>, column: &str) -> String {
        let near = 2.0 * (self.bins[1] - self.bins[0]);
        let mut places: Vec<(f64, Vec<usize>)> = Vec::new();
        for (at, column, width) in found {
            let near = near.max(width);
            let is_near = |place: &&mut (f64, Vec<usize>)| (at - place.0).abs() <= near;
            match places.iter_mut().find(is_near) {
                Some((_, columns)) if columns.contains(&column) => {}
                Some((_, columns)) => columns.push(column),
                None => places.push((at, vec![column])),
            }
        }
        let shown = &places[..places.len().min(NAMED)];
        let at: Vec<String> = shown.iter().map(|(at, _)| number(*at)).collect();
        let counts = shown.iter().map(|(_, columns)| columns.len().to_string());
        let counts = listed(&counts.collect::<Vec<String>>());
        let plural = if counts == "1" { "" } else { "s" };
        let more = match places.len() - shown.len() {
            0 => String::new(),
            more => format!(", and {more} more"),
        };
        let unit = self.bin_unit();
        format!("{} {unit} ({counts} {column}{plural}){more}", listed(&at))
    }

    fn note(&self) -> String {
        let jackknife = match self.left_out {
            _ if !self.has_jackknife => "There is no jackknife.",
            LeftOutEach::Realisation => "The jackknife leaves out one segment and taper at a time.",
            LeftOutEach::Record => "The jackknife leaves out one record at a time.",
        };
        match self.degrees_range() {
            Some([least, median, most]) => {
                let (share, degrees) = (confidence(self.alpha), with_range(least, median, most));
                format!("{share} intervals by {degrees} degrees of freedom. {jackknife}")
            }
            None => {
                let why = self.independence.why_none();
                format!("No interval can be stated: {why}.")
            }
        }
    }

    /// A line with its place and size.
    fn place_of(&self, line: &Line) -> String {
        let (time_unit, space_unit) = self.units();
        let unit = self.along.of([space_unit, time_unit]);
        let at = number(self.coordinate(line.column));
        format!("{} {} at {at} {unit}", number(line.at), self.bin_unit())
    }

    fn line_facts(&self, test: &LineTest, sheet: &mut Sheet) {
        let Some(first) = test.lines.first() else {
            return;
        };
        let (count, at, columns) = (test.lines.len(), test.columns(), self.columns_word());
        let (level, amplitude) = (number(test.level_of_all), self.amplitude(first));
        let place = self.place_of(first);
        let text = format!(
            "{count} at {at} {columns}, F above {level}; the surest: amplitude {amplitude}, {place}"
        );
        sheet.fact("lines", text);
        let row = |line: &Line| vec![self.place_of(line), self.amplitude(line), number(line.f)];
        sheet.tables.push(Table {
            title: "Lines, the surest first".into(),
            head: ["place", "amplitude", "F"].map(str::to_owned).to_vec(),
            rows: test.lines.iter().take(LISTED).map(row).collect(),
            ..Table::default()
        });
    }

    /// How loud the noise is, and what of it was subtracted.
    fn noise_facts(&self, sheet: &mut Sheet) {
        let Some(noise) = &self.noise else { return };
        let Some(median) = noise.median() else {
            let text = "none can be told: no site is quiet at first, or flat below Nyquist";
            sheet.fact("noise", text);
            return;
        };
        let bin_unit = self.bin_unit();
        let source = match median.source {
            NoiseSource::LeadIn { .. } => "before the motion arrives".to_owned(),
            NoiseSource::Top { from } => {
                let from = number(from);
                format!("where the spectrum is flat, from {from} {bin_unit}")
            }
        };
        let unit = match &self.unit {
            Some(unit) => format!(" ({unit})²/{bin_unit}"),
            None => String::new(),
        };
        let (known, all) = (noise.known(), noise.sites.len());
        let [median, low, high] = [median.density, median.low, median.high].map(number);
        let text =
            format!("at {known} of {all} sites, {source}: median {median} ({low} to {high}){unit}");
        sheet.fact("noise", text);
        if let Some(left) = &noise.subtracted {
            let clipped: usize = left.clipped_bins.iter().sum();
            let bins = noise.known() * self.bins.len();
            let added: f64 = left.clipped_power.iter().sum();
            let added = number(added / noise.known() as f64);
            let text = format!(
                "{clipped} of {bins} bins were below the noise and are 0, which adds {added} to the mean square of a \
                 site on average"
            );
            sheet.fact("subtracted", text);
        }
    }

    fn warnings(&self, sheet: &mut Sheet) {
        let columns = self.columns_word();
        let noise = self.noise.as_ref();
        if let Some(noise) = noise.filter(|noise| noise.subtracted.is_some()) {
            let all = noise.sites.len();
            let unknown = all - noise.known();
            if unknown > 0 {
                let message = format!(
                    "nothing is subtracted at {unknown} of {all} sites, whose noise is not known"
                );
                let advice = "record from before the motion arrives, or sample fast enough that noise alone is left at the top";
                sheet.warn(message, advice);
            }
        }
        // Those of which nothing is left are named already.
        let left = self.segments_left.as_ref();
        let empty = left.map_or(0, |left| left.empty().len());
        let filled = self.steadiness.iter().filter(|s| s.is_nan()).count();
        let without = (self.without_interval() - empty).saturating_sub(filled);
        let all = self.has_interval.len();
        if filled > 0 {
            let message = format!(
                "of {filled} of {all} {columns} more than a twentieth of the samples were filled: no interval is stated"
            );
            sheet.warn(message, LEAVE_OUT);
        }
        let inside = ndarray::s![1..self.segment[0].div_ceil(2), ..];
        let cells = self.degrees.slice(inside);
        let has_power = |m: usize, j: usize| {
            let is_own = self.detrended[m + 1] <= DETRENDED;
            is_own && self.has_interval[j] && self.spectrum[[m + 1, j]] > 0.0
        };
        let cells = cells.indexed_iter().filter(|((m, j), _)| has_power(*m, *j));
        let cells: Vec<bool> = cells.map(|(_, degrees)| degrees.is_nan()).collect();
        let below = cells.iter().filter(|is_below| **is_below).count();
        if below > 0 {
            let share = percent(below as f64 / cells.len() as f64);
            let message = format!(
                "{share} of the powers are below ten times what filled samples leave: no interval is stated there"
            );
            sheet.warn(message, LEAVE_OUT);
        }
        match self.along {
            _ if without == 0 => {}
            _ if self.independence.is_short => sheet.warn(
                format!("{}: no interval is stated", self.independence.why()),
                "record for longer, or at more sites, or name several records of the same sites",
            ),
            SpectrumAxis::Time => sheet.warn(
                format!(
                    "{without} of {all} sites have a transient, which is one realisation: no interval is stated"
                ),
                "name several records of the same sites, one a shot",
            ),
            SpectrumAxis::Space => sheet.warn(
                format!(
                    "{without} of {all} snapshots have their energy at a few sites: no interval is stated"
                ),
                "read the mean over the times, if it has an interval, or name several records, one a shot",
            ),
        }
        if let Some(mean) = &self.mean
            && mean.low.iter().all(|v| v.is_nan())
        {
            let steadiness = number(mean.steadiness);
            let message = format!(
                "the mean over the times has no interval: energy changes (steadiness {steadiness}), or times are few"
            );
            let advice = "analyze a part of the record in which it is steady";
            sheet.warn(message, advice);
        }
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        let [(bins, bin_unit), (columns, column_unit)] = self.along.of([
            [("frequency", &units.frequency), ("position", &units.space)],
            [("wavenumber", &units.wavenumber), ("time", &units.time)],
        ]);
        let density = units.density(bin_unit, "");
        sheet.line(bins, bins, bin_unit, &self.bins);
        sheet.line(columns, columns, column_unit, self.coordinates());
        sheet.line("steadiness", columns, "", &self.steadiness);
        if let Some(left) = &self.segments_left {
            left.variables(sheet, columns);
        }
        if let Some(noise) = &self.noise {
            let known = |site: &Option<SiteNoise>| match site {
                Some(noise) => [noise.density, noise.low, noise.high],
                None => [f64::NAN; 3],
            };
            for (i, name) in ["noise", "noise_low", "noise_high"].into_iter().enumerate() {
                let values = noise.sites.iter().map(|site| known(site)[i]);
                sheet.line(name, columns, &density, values.collect::<Vec<f64>>());
            }
        }
        let axes = [bins, columns];
        sheet.plane("spectrum", axes, &density, &self.spectrum);
        sheet.plane("degrees_of_freedom", axes, "", &self.degrees);
        sheet.plane("low", axes, &density, &self.low);
        sheet.plane("high", axes, &density, &self.high);
        let (rows, across) = self.spectrum.dim();
        for (name, sign) in [("jackknife_low", -1.0), ("jackknife_high", 1.0)] {
            let values = end_of(&self.spectrum, &self.jackknife, sign);
            let axes = [(bins, rows), (columns, across)];
            sheet.variable(name, &axes, &density, values);
        }
        if let Some(test) = &self.line_test {
            sheet.plane("f_statistic", axes, "", &test.statistic);
        }
        if let Some(mean) = &self.mean {
            sheet.line("mean_spectrum", bins, &density, &mean.spectrum);
            sheet.line("mean_low", bins, &density, &mean.low);
            sheet.line("mean_high", bins, &density, &mean.high);
            sheet.line("effective_snapshots", bins, "", &mean.effective_snapshots);
        }
    }

    fn density_label(&self) -> String {
        let bins = self.bin_unit();
        let unit = match &self.unit {
            Some(unit) => {
                let bins = self.along.of([bins.clone(), format!("({bins})")]);
                format!("({unit})²/{bins}")
            }
            None => format!("per {bins}"),
        };
        label("power spectral density", &unit)
    }

    fn bin_label(&self) -> String {
        let name = self.along.of(["frequency f", "wavenumber k"]);
        label(name, &self.bin_unit())
    }

    /// Of all sites, or at all times.
    fn map(&self) -> HeatChart {
        let (time_unit, space_unit) = self.units();
        let coordinates = self.coordinates();
        let title = self.along.of(["spectra S(f, x)", "spectra S(k, t)"]);
        let x_labels = [("position x", space_unit), ("time t", time_unit)];
        let (name, unit) = self.along.of(x_labels);
        let roles = [
            [Role::Position, Role::Frequency],
            [Role::Time, Role::Wavenumber],
        ];
        HeatChart {
            title: title.into(),
            caption: format!("The power at all {}.", self.columns_word()),
            x_label: label(name, &unit),
            y_label: self.bin_label(),
            label: self.density_label(),
            x: range(&coordinates),
            y: edges_from_zero(&self.bins),
            values: without_mean(&self.spectrum, self.mean_is_removed),
            marks: vec![Mark::new(coordinates[self.loudest()], "below")],
            roles: Some(self.along.of(roles)),
            ..HeatChart::default()
        }
    }

    /// The values without that at 0, where nothing is estimated if the mean is removed.
    fn of_bins(&self, mut values: Vec<f64>) -> Vec<f64> {
        if self.mean_is_removed {
            values[0] = f64::NAN;
        }
        values
    }

    /// A spectrum, with its interval if it has one.
    fn chart(&self, title: String, values: [&[f64]; 3], interval: &str) -> Chart {
        let x = (self.bin_label(), &self.bins[..]);
        let interval = format!("{} {interval}", confidence(self.alpha));
        spectrum_chart(title, x, self.density_label(), values, interval)
    }

    /// The spectrum of the site with the most energy.
    fn loudest_chart(&self) -> Chart {
        let (time_unit, space_unit) = self.units();
        let site = self.loudest();
        let at = six_digits(self.coordinate(site));
        let column = |array: &Array2<f64>| self.of_bins(array.column(site).to_vec());
        let [spectrum, low, high] = [&self.spectrum, &self.low, &self.high].map(column);
        let title = self.along.of([
            format!("spectrum of site {site} at {at} {space_unit}"),
            format!("spectrum at the time {at} {time_unit}"),
        ]);
        let mut chart = self.chart(title, [&spectrum, &low, &high], "interval");
        let half = column(&self.jackknife);
        if half.iter().any(|h| h.is_finite()) {
            for (sign, label) in [(-1.0, "by the jackknife"), (1.0, "")] {
                let end = end_of(&spectrum, &half, sign);
                chart.series.push(Series {
                    width: 1.4,
                    ..Series::of(label, BLACK, &self.bins, &end).with(Look::Dashed)
                });
            }
        }
        let noise = self.noise.as_ref();
        let noise = noise.filter(|noise| noise.subtracted.is_none());
        let noise = noise.and_then(|noise| noise.sites[site]);
        let level = noise.map(|noise| Level::new(noise.density, "noise"));
        chart.levels.extend(level);
        chart
    }

    /// Along space, the mean over the times.
    fn mean_chart(&self) -> Option<Chart> {
        let mean = self.mean.as_ref()?;
        let spectrum = self.of_bins(mean.spectrum.clone());
        let values = [&spectrum[..], &mean.low, &mean.high];
        let interval = "interval, by parts of the record";
        Some(self.chart("mean over all times".into(), values, interval))
    }

    /// The test for lines of that site.
    fn line_chart(&self) -> Option<Chart> {
        let test = self.line_test.as_ref()?;
        let statistic = test.statistic.column(self.loudest()).to_vec();
        let known = statistic.iter().copied();
        let known = known.filter(|f| f.is_finite() && *f > 0.0);
        let largest = known.fold(test.level_of_all, f64::max);
        let levels = [("one cell", test.level), ("all cells", test.level_of_all)].into_iter();
        let levels = levels.filter(|_| self.degrees_range().is_some());
        let level = |(of, at)| Level::new(at, format!("level of {of}, {at:.3}"));
        let lines = test.lines.iter();
        let of_site = lines.filter(|line| line.column == self.loudest());
        let marks = of_site.take(5).map(|line| Mark::new(line.at, "line"));
        let chance = percent(self.alpha);
        Some(Chart {
            marks: marks.collect(),
            y: 0.1..2.0 * largest,
            log_y: true,
            levels: levels.map(level).collect(),
            ..Chart::of(
                format!("test for lines: F, exceeded by chance with probability {chance}"),
                self.bin_label(),
                "statistic F",
                vec![Series::of("", BLUE, &self.bins, &statistic)],
            )
        })
    }
}

/// The lower or the upper end of the intervals that these halves of `ln S` are of.
fn end_of<'v>(
    spectrum: impl IntoIterator<Item = &'v f64>,
    half: impl IntoIterator<Item = &'v f64>,
    sign: f64,
) -> Vec<f64> {
    let cells = spectrum.into_iter().zip(half);
    cells.map(|(s, half)| s * (sign * half).exp()).collect()
}
