//! What spectra say.

use std::collections::BTreeSet;

use ndarray::Array2;
use serde_json::{Value, json};

use super::{LineTest, NoiseFloor, SiteNoise, SpectrumEstimate};
use crate::estimates::realisations::without_mean;
use crate::sheet::{
    BLACK, BLUE, Chart, Column, Describe, Level, Look, Mark, PlotRow, Role, Series, Sheet, Units,
    Weight, confidence, number, percent, six_digits, with_half,
};

const DEFINITIONS: &str = "\
    Power spectral density: One-sided; its integral over f is the mean square of the samples.
    Degrees of freedom: Twice the number of independent realisations that a value averages, less what overlap and unequal \
        weights of the tapers cost.
    Interval: Where the true density lies with the stated probability if the record is stationary: by the chi-square \
        distribution of Gaussian records, and by the jackknife, which assumes no distribution.
    Test for lines: F compares the power of a sine of constant amplitude with what is left beside it. Without a line it \
        exceeds the level of one cell with the stated probability, and that of all cells anywhere with the same.";

impl Describe for SpectrumEstimate {
    /// Variables: `frequency` (nf), `position`, `steadiness` (n); `spectrum`, `degrees_of_freedom`, `low`, `high`,
    /// `jackknife_low`, `jackknife_high` (nf, n), NaN where there is no interval; along time `noise`, `noise_low`,
    /// `noise_high` (n), densities; where segments are left out `segments`, `effective_realisations` (n); of several
    /// tapers `f_statistic` (nf, n). Along space, `wavenumber` and `time` take the place of `frequency` and `position`,
    /// beside `mean_spectrum`, `mean_low`, `mean_high`, `effective_snapshots` (nk).
    fn describe(&self) -> Sheet<'_> {
        let (words, columns) = (self.words(), self.columns_word());
        let (without, all) = (self.without_interval(), self.has_interval.len());
        let mut sheet = Sheet {
            about: format!("power spectral density at {all} {columns}"),
            answer: self.answer(),
            ..Sheet::of("spectrum", "Spectra with intervals", DEFINITIONS)
        };
        sheet.degrees_of_freedom(self.degrees_range(), self.alpha);
        // Those of which nothing is left are named below.
        let left = self.segments_left.as_ref();
        let single = without.saturating_sub(left.map_or(0, |left| left.empty().len()));
        if single > 0 {
            let text = format!(
                "{single} of {all} {columns} have a transient, a short record, or more than a twentieth of it filled, which is one \
                 realisation: no interval is stated"
            );
            let advice = "name several records of the same sites, one a shot; leave gaps out with `--gaps leave-out`";
            sheet.warn(text, advice);
        }
        if let Some(left) = &self.segments_left {
            left.describe(&mut sheet, columns);
        }
        self.noise_facts(&mut sheet);
        let in_time = self.mean.as_ref().map(|mean| mean.steadiness);
        self.independence.describe(&mut sheet, self.segment);
        // Each site has its own realisations, of which the warnings above speak.
        let of_all = self.independence.warning();
        sheet.warnings.retain(|warning| *warning != of_all);
        sheet.numbers(json!({
            "along": self.along,
            "time_unit": words.time,
            "space_unit": words.space,
            "unit": self.unit,
            "half_bandwidth": self.half_bandwidth,
            "segments_left": self.segments_left,
            "steadiness": self.steadiness,
            "without_interval": without,
            "steadiness_in_time": in_time,
            "jackknife_leaves_out": self.has_jackknife.then_some(self.left_out),
            "noise": self.noise.as_ref().map(NoiseFloor::numbers),
            "line_test": self.line_test,
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
    fn words(&self) -> Units {
        Units::in_words(&self.time, &self.space, self.unit.as_deref())
    }

    /// What columns and bins count.
    fn roles(&self) -> [Role; 2] {
        self.along.of([
            [Role::Time, Role::Wavenumber],
            [Role::Position, Role::Frequency],
        ])
    }

    fn bin_unit(&self) -> String {
        self.words().unit(self.roles()[1]).to_owned()
    }

    fn columns_word(&self) -> &'static str {
        self.along.of(["times", "sites"])
    }

    /// The test for lines, where anything is significant.
    fn test_of_lines(&self) -> Option<&LineTest> {
        let test = self.line_test.as_ref();
        test.filter(|_| self.degrees_range().is_some())
    }

    /// The surest line, or the highest peak, in words; how many sites have it, within two bins or its width, and others.
    fn answer(&self) -> String {
        let columns = self.columns_word();
        let (kind, places, size): (_, Vec<_>, _) = match self.test_of_lines() {
            Some(test) => {
                let places = test.lines.iter().map(|line| (line.at, line.column, 0.0));
                let size = test.lines.first().map(|line| {
                    let unit = self.unit.as_deref().unwrap_or_default();
                    let amplitude = with_half(line.amplitude, line.amplitude_error, unit);
                    format!("the surest of amplitude {amplitude}")
                });
                ("lines", places.collect(), size)
            }
            None => {
                let Some(peaks) = self.peaks() else {
                    let why = self.independence.why_none();
                    return format!("no peak can be told from chance: {why}");
                };
                let size = peaks.first().map(|peak| {
                    let ratio = number(peak.ratio);
                    format!("the highest {ratio} times the power beside it")
                });
                let places = peaks.iter().map(|peak| (peak.at, peak.column, peak.width));
                ("peaks", places.collect(), size)
            }
        };
        let (Some(size), Some((at, _, width))) = (size, places.first()) else {
            return format!("no {kind} above chance at any of the {columns}");
        };
        let near = width.max(2.0 * (self.bins[1] - self.bins[0]));
        let is_near = |(other, ..): &&(f64, usize, f64)| (other - at).abs() <= near;
        let same = places.iter().filter(is_near).map(|(_, column, _)| column);
        let (same, all) = (same.collect::<BTreeSet<_>>().len(), self.spectrum.ncols());
        let (count, at, unit) = (places.len(), number(*at), self.bin_unit());
        format!("{kind}: {count}, {size} at {at} {unit} ({same} of {all} {columns})")
    }

    /// How loud the noise is, and what of it was subtracted.
    fn noise_facts(&self, sheet: &mut Sheet) {
        let Some(noise) = &self.noise else { return };
        let (known, all) = (noise.known(), noise.sites.len());
        let mut text = format!("known at {known} of {all} sites");
        if let Some(noise) = noise.median() {
            let [median, low, high] = [noise.density, noise.low, noise.high].map(number);
            let unit = self.words().density(&[&self.bin_unit()], "");
            text += &format!(", median {median} ({low} to {high}) {unit}");
        }
        if let Some(left) = &noise.subtracted {
            let clipped: usize = left.clipped_bins.iter().sum();
            let bins = known * self.bins.len();
            text +=
                &format!("; subtracted there, {clipped} of {bins} bins were below it and are 0");
        }
        sheet.fact("noise", text);
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        let roles = self.roles();
        let density = units.density(&[units.unit(roles[1])], "");
        sheet.axis(roles[1], &units, &self.bins);
        sheet.axis(roles[0], &units, self.coordinates());
        let [columns, bins] = roles.map(|role| role.words()[0]);
        sheet.line("steadiness", columns, "", &self.steadiness);
        if let Some(left) = &self.segments_left {
            left.variables(sheet, columns);
        }
        if let Some(noise) = &self.noise {
            let density = &density[..];
            let densities: [Column<Option<SiteNoise>>; 3] = [
                ("noise", density, |n| n.map_or(f64::NAN, |n| n.density)),
                ("noise_low", density, |n| n.map_or(f64::NAN, |n| n.low)),
                ("noise_high", density, |n| n.map_or(f64::NAN, |n| n.high)),
            ];
            sheet.columns(columns, &noise.sites, &densities);
        }
        let axes = [bins, columns];
        for (name, unit, array) in [
            ("spectrum", &density[..], &self.spectrum),
            ("degrees_of_freedom", "", &self.degrees),
            ("low", &density, &self.low),
            ("high", &density, &self.high),
        ] {
            sheet.plane(name, axes, unit, array);
        }
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

    /// Of all sites, or at all times.
    fn map(&self) -> Chart {
        let (coordinates, words) = (self.coordinates(), self.words());
        let roles = self.roles();
        let values = without_mean(&self.spectrum, self.mean_is_removed);
        let axes = [&coordinates[..], &self.bins];
        Chart {
            title: self.along.of(["spectra S(k, t)", "spectra S(f, x)"]).into(),
            caption: format!("The power at all {}.", self.columns_word()),
            label: words.density_label(&roles[1..]),
            marks: vec![Mark::new(coordinates[self.loudest()], "below")],
            ..Chart::over(&words, roles, axes, values)
        }
    }

    /// A spectrum with its interval, without the value at 0, where nothing is estimated if the mean is removed.
    fn chart(&self, title: String, mut spectrum: Vec<f64>, ends: [&[f64]; 2]) -> Chart {
        let (words, [_, bins]) = (self.words(), self.roles());
        if self.mean_is_removed {
            spectrum[0] = f64::NAN;
        }
        let ends = ends[0].iter().copied().zip(ends[1].iter().copied());
        let interval = format!("{} interval", confidence(self.alpha));
        let line = Series::of("", BLUE, &self.bins, &spectrum).with_band(interval, ends.collect());
        let (x, y) = (words.label(bins), words.density_label(&[bins]));
        Chart::of(title, x, y, vec![line]).logarithmic()
    }

    /// The spectrum of the site with the most energy.
    fn loudest_chart(&self) -> Chart {
        let (words, site) = (self.words(), self.loudest());
        let at = six_digits(self.coordinate(site));
        let column = |array: &Array2<f64>| array.column(site).to_vec();
        let [spectrum, low, high] = [&self.spectrum, &self.low, &self.high].map(column);
        let title = self.along.of([
            format!("spectrum at the time {at} {}", words.time),
            format!("spectrum of site {site} at {at} {}", words.space),
        ]);
        let mut chart = self.chart(title, spectrum.clone(), [&low, &high]);
        let half = column(&self.jackknife);
        if half.iter().any(|half| half.is_finite()) {
            for (sign, label) in [(-1.0, "by the jackknife"), (1.0, "")] {
                let end = end_of(&spectrum, &half, sign);
                let mut series = Series::of(label, BLACK, &self.bins, &end).with(Look::Dashed);
                series.weight = Weight::Thin;
                chart.series.push(series);
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
        let (title, ends) = ("mean over all times", [&mean.low[..], &mean.high]);
        Some(self.chart(title.into(), mean.spectrum.clone(), ends))
    }

    /// The test for lines of that site.
    fn line_chart(&self) -> Option<Chart> {
        let test = self.test_of_lines()?;
        let statistic = test.statistic.column(self.loudest()).to_vec();
        let levels = [("one cell", test.level), ("all cells", test.level_of_all)];
        let level = |(of, at)| Level::new(at, format!("level of {of}, {at:.3}"));
        let lines = test.lines.iter();
        let of_site = lines.filter(|line| line.column == self.loudest());
        let marks = of_site.take(5).map(|line| Mark::new(line.at, "line"));
        let chance = percent(self.alpha);
        let chart = Chart::of(
            format!("test for lines: F, exceeded by chance with probability {chance}"),
            self.words().label(self.roles()[1]),
            "statistic F",
            vec![Series::of("", BLUE, &self.bins, &statistic)],
        );
        let chart = chart.logarithmic();
        Some(Chart {
            marks: marks.collect(),
            y: 0.1..chart.y.end.max(2.0 * test.level_of_all),
            levels: levels.map(level).to_vec(),
            ..chart
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
