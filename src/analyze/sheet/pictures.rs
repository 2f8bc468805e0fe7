//! Figures of an analysis: maps, short-time spectra, and the content along x and along t.

use std::ops::Range;

use ndarray::{Array2, ArrayView2, s};

use super::sides;
use crate::analyze::axes::Side;
use crate::analyze::labels::Power;
use crate::analyze::{
    Analysis, DispersionCurve, Extent, Map, MapAxis, Moments, Reduction, ShortTimeSpectra,
};
use crate::arrays::LargeArray;
use crate::sheet::{
    BLUE, Chart, FigureLayout, GREEN, Level, Mark, PURPLE, PlotRow, Series, VERMILLION, around,
    block_extremes, magnitudes, range, six_digits,
};

/// Largest short-time map, bins by frames.
const SHORT_LIMIT: (usize, usize) = (256, 400);
/// Height of a map over that of a chart.
const TALL: f64 = 1.7;
/// Largest over least energy from which on their axis is logarithmic.
const WIDE: f64 = 10.0;

/// A map of an analysis.
struct Kind {
    name: &'static str,
    title: &'static str,
    /// What it shows, and what to look for.
    shows: &'static str,
    array: LargeArray,
}

/// In the order of reading.
const MAPS: [Kind; 5] = [
    Kind {
        name: "space-time",
        title: "Field v(t, x)",
        shows: "The samples themselves. Slopes are speeds: a steeper band is slower. Look for the leading pulse, what it \
                leaves behind, and reflections.",
        array: LargeArray::SAMPLES,
    },
    Kind {
        name: "spacetime-spectrum",
        title: "Space-time spectrum S(k, f)",
        shows: "Energy by wavenumber and frequency: the right half travels towards +x, the left half towards −x. Ridges are \
                dispersion curves, gaps are band gaps; in a chain with a cell of two sites, folding shows a few per cent of \
                a one-way wave on the other side.",
        array: LargeArray::SPACETIME_SPECTRUM,
    },
    Kind {
        name: "temporal-spectrum",
        title: "Temporal spectrum S(f, x)",
        shows: "Which frequencies each site sees. A cascade fills the top of the picture as x grows; the dashed line is the \
                frequency past which energy moves.",
        array: LargeArray::TEMPORAL_SPECTRUM,
    },
    Kind {
        name: "spatial-spectrum",
        title: "Spatial spectrum S(k, t)",
        shows: "Which wavenumbers the field holds at each time. A cascade spreads to the right as time goes on; the dashed \
                line is the wavenumber past which energy moves.",
        array: LargeArray::SPATIAL_SPECTRUM,
    },
    Kind {
        name: "flux-surrogate",
        title: "Kinetic flux surrogate Π_K(k, t), positive towards high k",
        shows: "Rate at which kinetic energy leaves the wavenumbers up to k, from velocity alone: positive towards high k. It \
                counts exchange with contact energy too, so read it as a surrogate and compare it with an exact budget \
                where one can be had.",
        array: LargeArray::KINETIC_FLUX_SURROGATE,
    },
];

/// Those whose results are present.
pub(super) fn figures(analysis: &Analysis) -> Vec<FigureLayout> {
    let maps = MAPS.iter().filter_map(|kind| kind.figure(analysis));
    let in_time = analysis.short_time.as_ref().map(|spectra| Short {
        analysis,
        name: "short-time",
        title: "Short-time spectra of chosen sites",
        shows: "this site's record: when each frequency arrives",
        count: "samples",
        spectra,
        sides: [Side::Time, Side::Frequency],
        at: Side::Space,
    });
    let in_space = analysis.short_space.as_ref().map(|spectra| Short {
        analysis,
        name: "short-space",
        title: "Short-space spectra at chosen times",
        shows: "the profile at this time: where each wavenumber is",
        count: "sites",
        spectra,
        sides: [Side::Space, Side::Wavenumber],
        at: Side::Time,
    });
    let short = in_time.into_iter().chain(in_space);
    let along_x = analysis.along_space.as_ref().map(|moments| Content {
        analysis,
        name: "along-x",
        title: "Frequency content along x",
        caption: "Centroid, median and 90 % frequency of each site, and its energy, over the whole record.",
        moments,
        sides: [Side::Space, Side::Frequency],
        of_each: "site",
    });
    let along_t = analysis.along_time.as_ref().map(|moments| Content {
        analysis,
        name: "along-t",
        title: "Wavenumber content along t",
        caption: "Centroid, median and 90 % wavenumber at each time, and the energy. A wall or the end of the record \
                  shows as a step.",
        moments,
        sides: [Side::Time, Side::Wavenumber],
        of_each: "time",
    });
    let content = along_x.into_iter().chain(along_t).map(Content::figure);
    let direction = direction(analysis);
    let direction =
        direction.filter(|_| !analysis.maps.contains_key(&LargeArray::SPACETIME_SPECTRUM));
    let direction = direction.map(|chart| FigureLayout::on_page("direction", [chart]));
    maps.chain(short.filter_map(Short::figure))
        .chain(content)
        .chain(direction)
        .collect()
}

impl Kind {
    fn figure(&self, analysis: &Analysis) -> Option<FigureLayout> {
        let map = analysis.maps.get(&self.array)?;
        let [y, x] = Side::of(self.array);
        let is_spacetime = self.array == LargeArray::SPACETIME_SPECTRUM;
        // Past which frequency or wavenumber energy is told to move.
        let past = |side: Side| match side {
            Side::Frequency => analysis.answer.as_ref()?.frequency.past(),
            Side::Wavenumber => analysis.answer.as_ref()?.wavenumber.past(),
            _ => None,
        };
        let levels = past(y).filter(|_| !is_spacetime);
        let standing = is_spacetime.then(|| Mark::new(0.0, ""));
        let marks = past(x).map(|at| Mark::new(at, "verdict"));
        let interval = analysis.interval;
        let interval = interval.filter(|_| self.array == LargeArray::TEMPORAL_SPECTRUM);
        let chart = Chart {
            caption: self.shows.into(),
            roles: [x, y].map(|side| Some(side.role())),
            second: sides::wavenumber_reading(&analysis.axes),
            marks: marks.into_iter().chain(standing).collect(),
            levels: levels
                .map(|at| Level::new(at, "verdict"))
                .into_iter()
                .collect(),
            curves: match is_spacetime {
                true => DispersionCurve::curves(&analysis.dispersion),
                false => Vec::new(),
            },
            interval: interval.and_then(|interval| interval.factors),
            not_shown: sides::not_shown(analysis, &[x, y], true),
            ..Chart::of_map(map)
        };
        let interval = interval.map(|of| match (of.degrees_of_freedom, of.factors) {
            (Some(degrees), Some([low, high])) => format!(
                "95 % interval: {low:.3} to {high:.3} of a value ({degrees:.3} degrees of freedom)"
            ),
            _ => "no interval: a transient is one realisation".into(),
        });
        let shares = analysis.direction_of_waves().filter(|_| is_spacetime);
        let shares = shares.map(|of| {
            let percent = |share: f64| match share.is_finite() {
                true => format!("{:.1} %", 100.0 * share),
                false => "no energy".into(),
            };
            let [minus, plus, rest] =
                [of.toward_minus_x, of.toward_plus_x, of.undirected].map(percent);
            format!("← towards −x: {minus}, → towards +x: {plus}, undirected: {rest}")
        });
        let direction = direction(analysis).filter(|_| is_spacetime);
        let rows = [PlotRow::of([chart]).high(TALL)].into_iter();
        Some(FigureLayout {
            name: self.name,
            title: self.title.into(),
            rows: rows
                .chain(direction.map(|chart| PlotRow::of([chart]).high(0.5)))
                .collect(),
            notes: interval.into_iter().chain(shares).collect(),
            ..FigureLayout::default()
        })
    }
}

/// The energy travelling each way at each frequency. Where the answer withholds the shares, nothing else states them.
fn direction(analysis: &Analysis) -> Option<Chart> {
    let [plus, minus] = analysis.direction_by_frequency.as_ref()?;
    let is_any = [plus, minus]
        .into_iter()
        .flatten()
        .any(|share| share.is_finite());
    if analysis.undirected.is_some() || !is_any {
        return None;
    }
    let frequency = &analysis.axes.frequency;
    let series = vec![
        Series::of("towards +x", BLUE, frequency, plus),
        Series::of("towards −x", VERMILLION, frequency, minus),
    ];
    let chart = Chart::of(
        "direction of travel at each frequency",
        "",
        "share of energy",
        series,
    );
    Some(Chart {
        caption:
            "Share of the energy that travels each way. What is missing to 1 has no direction: it \
                  lies on f = 0, on k = 0 or on a Nyquist line."
                .into(),
        y: 0.0..1.0,
        ..along(chart, analysis, Side::Frequency)
    })
}

/// With x as the display limits have it.
fn along(chart: Chart, analysis: &Analysis, side: Side) -> Chart {
    let extent = analysis.display.part(side);
    Chart {
        x_label: side.label(&analysis.axes),
        x: extent.low..extent.high,
        roles: [Some(side.role()), None],
        not_shown: sides::not_shown(analysis, &[side], true),
        ..chart
    }
}

/// Where the energy lies in frequency or wavenumber, along x or t.
struct Content<'a> {
    analysis: &'a Analysis,
    name: &'static str,
    title: &'static str,
    caption: &'static str,
    moments: &'a Moments,
    /// What it is along, and of which content.
    sides: [Side; 2],
    of_each: &'static str,
}

impl Content<'_> {
    fn figure(self) -> FigureLayout {
        FigureLayout {
            name: self.name,
            title: self.title.into(),
            rows: vec![
                PlotRow::of([self.content()]).high(0.8),
                PlotRow::of([self.energies()]).high(0.5),
            ],
            shared_x: true,
            ..FigureLayout::default()
        }
    }

    fn curve(&self, label: &str, colour: usize, y: &[f64]) -> Series {
        let along = self.sides[0].coordinates(&self.analysis.axes);
        Series::of(label, colour, &along, y)
    }

    /// The part of values along x or t that is shown.
    fn shown<'v>(&self, values: &'v [f64]) -> &'v [f64] {
        &values[self.analysis.display.part(self.sides[0]).bins.clone()]
    }

    fn content(&self) -> Chart {
        let Moments {
            centroid,
            median,
            quantile_90,
            ..
        } = self.moments;
        // A row of little energy beyond the display limits would stretch the axis.
        let extent = self.analysis.display.part(self.sides[1]);
        let half = 0.5 * (extent.high - extent.low) / (extent.bins.len() as f64 - 1.0).max(1.0);
        let limits = extent.low - half..=extent.high + half;
        let values = [centroid, median, quantile_90].map(|values| self.shown(values));
        let values = values.into_iter().flatten().copied();
        let y = around(values.filter(|value| extent.is_whole() || limits.contains(value)));
        let curves = vec![
            self.curve("centroid", BLUE, centroid),
            self.curve("90 % of the energy lies below", VERMILLION, quantile_90),
            self.curve("median", GREEN, median),
        ];
        let axes = &self.analysis.axes;
        let chart = Chart::of("", "", self.sides[1].label(axes), curves);
        Chart {
            caption: self.caption.into(),
            y,
            roles: self.sides.map(|side| Some(side.role())),
            second: sides::wavenumber_reading(axes),
            ..along(chart, self.analysis, self.sides[0])
        }
    }

    /// On a logarithmic axis where they are far apart.
    fn energies(&self) -> Chart {
        let shown = self.shown(&self.moments.energy);
        let label = format!("energy of each {} (integral of its spectrum)", self.of_each);
        let curves = vec![self.curve(&label, PURPLE, &self.moments.energy)];
        let energy = Power::of(self.analysis).energy(self.sides[1]);
        let chart = Chart::of("", "", energy, curves);
        let most = shown.iter().copied().fold(0.0, f64::max);
        let chart = match shown.iter().any(|energy| WIDE * energy < most) {
            true => chart.logarithmic(),
            false => Chart {
                y: around(shown.iter().copied()),
                ..chart
            },
        };
        along(chart, self.analysis, self.sides[0])
    }
}

/// Spectra of short pieces.
struct Short<'a> {
    analysis: &'a Analysis,
    name: &'static str,
    title: &'static str,
    /// What the pieces are of, and what their lengths count.
    shows: &'static str,
    count: &'static str,
    spectra: &'a ShortTimeSpectra,
    /// Of frames, and of bins.
    sides: [Side; 2],
    /// What each spectrum is at.
    at: Side,
}

impl Short<'_> {
    /// `None` where there is no spectrum to show.
    fn figure(self) -> Option<FigureLayout> {
        let each = self.spectra.values.outer_iter();
        let maps: Vec<Map> = each.map(|one| self.map(one)).collect();
        let shared = magnitudes(maps.iter().map(Map::shown));
        let columns = match maps.len() {
            0 => return None,
            1 => 1,
            2..=8 => 2,
            _ => 3,
        };
        let spectra = self.spectra;
        let caption = format!(
            "Spectra of short pieces of {}. Segments of {} {}, {} apart, window {}.",
            self.shows, spectra.segment, self.count, spectra.hop, spectra.window.name
        );
        let axes = &self.analysis.axes;
        let charts = maps.iter().zip(&spectra.at).map(|(map, at)| Chart {
            title: format!("{} = {}", self.at.label(axes), six_digits(*at)),
            caption: caption.clone(),
            roles: self.sides.map(|side| Some(side.role())),
            second: sides::wavenumber_reading(axes),
            shared: Some(shared),
            not_shown: sides::not_shown(self.analysis, &self.sides, false),
            ..Chart::of_map(map)
        });
        let mut grid = FigureLayout::grid(self.title, columns, charts);
        grid.rows.iter_mut().for_each(|row| row.height = 1.4);
        Some(FigureLayout {
            name: self.name,
            ..grid
        })
    }

    /// A spectrum with the part of it that is shown.
    fn map(&self, one: ArrayView2<f64>) -> Map {
        let centres = [&self.spectra.frames, &self.spectra.bins];
        let whole = centres.map(|centres| 0..centres.len());
        let part = |n: usize| within(centres[n], self.analysis.display.part(self.sides[n]));
        let part = [0, 1].map(part);
        let detail = (part != whole).then(|| Box::new(self.part(one, part)));
        Map {
            detail,
            ..self.part(one, whole)
        }
    }

    fn part(&self, one: ArrayView2<f64>, [frames, bins]: [Range<usize>; 2]) -> Map {
        let values = one.slice(s![bins.clone(), frames.clone()]);
        let axis = |side: Side, centres: &[f64]| {
            let ends = range(centres);
            MapAxis {
                label: side.label(&self.analysis.axes),
                low: ends.start,
                high: ends.end,
            }
        };
        let cells = SHORT_LIMIT;
        Map {
            values: self.known(values),
            x: axis(self.sides[0], &self.spectra.frames[frames]),
            y: axis(self.sides[1], &self.spectra.bins[bins]),
            reduction: Reduction::Max {
                rows: values.nrows().div_ceil(cells.0).max(1),
                columns: values.ncols().div_ceil(cells.1).max(1),
            },
            label: Power::of(self.analysis).density(&self.sides),
            ..Map::default()
        }
    }

    /// Without what is below the error of the samples, which a scale of a site that is not reached would show.
    fn known(&self, values: ArrayView2<f64>) -> Array2<f32> {
        let error = self.analysis.sample_error.unwrap_or(0.0);
        let least = error * error * self.spectra.largest();
        let known = |value: f64| match value >= least {
            true => value as f32,
            false => f32::NAN,
        };
        block_extremes(values, SHORT_LIMIT).mapv(known)
    }
}

/// The bins (frames) at `centres` that lie within the display limits of their axis, by index; all of
/// them where there are none.
fn within(centres: &[f64], extent: &Extent) -> Range<usize> {
    if extent.is_whole() {
        return 0..centres.len();
    }
    let slack = 1e-9 * (extent.high - extent.low);
    let is_below = |centre: &f64| *centre < extent.low - slack;
    let first = centres.partition_point(is_below);
    // The bin after the last one still holds a part of what is shown.
    let end = centres.partition_point(|centre| *centre < extent.high - slack) + 1;
    let end = end.min(centres.len());
    match first < end {
        true => first..end,
        false => 0..centres.len(),
    }
}
