//! The cumulative spectra that an answer rests on.

use super::answer::{Words, both};
use crate::analyze::Analysis;
use crate::analyze::axes::{Axes, Side};
use crate::moved::{Evidence, GroupSpectrum, Movement, Place, Verdict};
use crate::sheet::{BLUE, Chart, FigureLayout, Mark, Series, VERMILLION, Weight, around};

/// Groups drawn at most, beside those compared.
const THIN: usize = 6;

/// Least difference of cumulative shares between neighbouring points of a curve.
const STEP: f64 = 1e-3;

/// Share of the energy below the end of the axis, at first.
const MOST: f64 = 0.995;

/// Ends over the frequency below which a tenth of the energy lies, from which on the axis is logarithmic.
const WIDE: f64 = 40.0;

/// Figures of two charts, along x and in time: the moves along the profile, and the cumulative spectra.
pub(super) fn figures(analysis: &Analysis) -> Vec<FigureLayout> {
    let (Some(answer), Some(words)) = (&analysis.answer, Words::of(analysis)) else {
        return Vec::new();
    };
    let axes = &analysis.axes;
    let (f, k) = (&answer.frequency, &answer.wavenumber);
    let (sites, time) = (
        |place: &Place| words.sites(place),
        |place: &Place| words.time(place),
    );
    let along_x = answer.along_x.as_ref().map(|evidence| Curves {
        axes,
        name: "moved-along-x",
        titles: [
            "Energy moved in frequency, along x",
            "Cumulative spectra C(f) along x",
        ],
        captions: [PROFILE_ALONG_X, MOVED_ALONG_X],
        along: Side::Space,
        label: Side::Frequency,
        evidence,
        of: f,
        marks: moved(f, both(f, |f| words.frequency(f))),
        name_of: &sites,
    });
    let in_time = answer.along_t.as_ref().map(|evidence| Curves {
        axes,
        name: "moved-in-time",
        titles: [
            "Energy moved in wavenumber, in time",
            "Cumulative spectra C(k) in time",
        ],
        captions: [PROFILE_IN_TIME, MOVED_IN_TIME],
        along: Side::Time,
        label: Side::Wavenumber,
        evidence,
        of: k,
        marks: moved(k, both(k, |k| words.wavenumber(k))),
        name_of: &time,
    });
    let curves = along_x.into_iter().chain(in_time);
    curves.map(Curves::figure).collect()
}

const PROFILE_ALONG_X: &str = "The share of the energy that lies above a frequency at a group of sites and below it at \
    the first one (up), or the reverse (down), with 95 % intervals. A curve that rises and falls is a move that comes \
    back.";
const PROFILE_IN_TIME: &str = "The share of the energy that lies above a wavenumber at some times and below it at the \
    first ones (up), or the reverse (down), with 95 % intervals, while the wave is inside.";
const MOVED_ALONG_X: &str = "The gap between bold curves is what moved. A curve to the right of another has its energy \
    at higher frequency; curves that coincide have moved nothing. Colours run along x, from blue to orange; thin curves \
    are other groups of sites. Energy is that of the front window of a pulse, or of the record of a steady field, noise \
    subtracted, each group's total being 1.";
const MOVED_IN_TIME: &str = "The gap between bold curves is what moved. They are averages over times at which the wave \
    is inside. A curve to the right of another has its energy at higher wavenumber. Colours run in time, from blue to \
    orange.";

/// What a verdict states, of the shares that moved up and down.
fn moved(of: &Movement, [up, down]: [String; 2]) -> Vec<Mark> {
    let [up, down] = [Mark::new(of.up.at, up), Mark::new(of.down.at, down)];
    let mut stated = match of.verdict {
        Verdict::Up => vec![up],
        Verdict::Down => vec![down],
        Verdict::Spreads => vec![up, down],
        Verdict::Unchanged | Verdict::Untold => Vec::new(),
    };
    stated.retain(|mark| mark.at.is_finite());
    stated
}

/// The groups between which something moved.
fn ends(evidence: &Evidence, of: &Movement) -> Option<[usize; 2]> {
    let group = |place: Option<Place>| {
        let rows = place?.rows;
        let mut groups = evidence.groups.iter();
        groups.position(|group| group.place.rows == rows)
    };
    Some([group(of.from)?, group(of.to)?])
}

/// The moves along x or in time, and the spectra of the groups.
struct Curves<'a> {
    axes: &'a Axes,
    name: &'static str,
    /// Of the moves and of the spectra, as all pairs.
    titles: [&'static str; 2],
    captions: [&'static str; 2],
    along: Side,
    label: Side,
    evidence: &'a Evidence,
    of: &'a Movement,
    marks: Vec<Mark>,
    name_of: &'a dyn Fn(&Place) -> String,
}

impl Curves<'_> {
    fn figure(self) -> FigureLayout {
        FigureLayout::on_page(self.name, [self.profile(), self.spectra()])
    }

    fn chart(&self, n: usize, side: Side, y: &str, series: Vec<Series>) -> Chart {
        let x_label = side.label(self.axes);
        let chart = Chart::of(self.titles[n], x_label, y, series);
        let values = chart.series.iter().flat_map(|series| &series.points);
        Chart {
            caption: self.captions[n].into(),
            y: around(values.map(|point| point.1)),
            roles: [Some(side.role()), None],
            ..chart
        }
    }

    /// What moved from the first group to each, with its 95 % interval.
    fn profile(&self) -> Chart {
        let series = |name: &str, way: usize, color: usize| {
            let groups = self.evidence.groups.iter().zip(&self.evidence.moves);
            let points = groups.map(|(group, moves)| {
                let of = &moves[way];
                [group.place.at, of.share, of.error]
            });
            Series::with_errors(name, color, points)
        };
        let both = vec![
            series("moved up", 0, VERMILLION),
            series("moved down", 1, BLUE),
        ];
        let most = self.of.to.filter(|_| self.of.moves());
        let most = most.zip(self.marks.first());
        let most = most.map(|(place, mark)| Mark::new(place.at, mark.label.clone()));
        Chart {
            marks: most.into_iter().collect(),
            ..self.chart(0, self.along, "share of energy moved", both)
        }
    }

    fn spectra(&self) -> Chart {
        let groups = &self.evidence.groups;
        let bold = &self.evidence.compared;
        let thin = self.thin();
        let compared: Vec<&GroupSpectrum> = bold.iter().map(|&n| &groups[n]).collect();
        let others = thin.iter().map(|&n| &groups[n]);
        let drawn: Vec<&GroupSpectrum> = compared.iter().copied().chain(others).collect();
        let upper = &self.evidence.upper;
        let kept = kept(&drawn);
        // A place between two others, from 0 to 1.
        let between = |n: usize, from: usize, to: usize| {
            let far = n.clamp(from, to) - from;
            far as f64 / (to - from).max(1) as f64
        };
        let curve = |n: usize, weight: Weight, shade: f64| {
            let points = kept
                .iter()
                .map(|&kept| (upper[kept], groups[n].cumulative[kept]));
            let points = [(0.0, 0.0)].into_iter().chain(points).collect();
            Series {
                weight,
                shade: Some(shade),
                ..Series::line((self.name_of)(&groups[n].place), BLUE, points)
            }
        };
        // Those compared by their order, others by how far they are from the first to the last of these.
        let (first, last) = (bold[0], bold[bold.len() - 1]);
        let others = thin
            .iter()
            .map(|&n| curve(n, Weight::Thin, between(n, first, last)));
        let compared_curves = bold.iter().enumerate();
        let compared_curves = compared_curves
            .map(|(rank, &n)| curve(n, Weight::Bold, between(rank, 0, bold.len() - 1)));
        let series = others.chain(compared_curves).chain(self.gaps()).collect();
        let label = format!("share of energy up to {}", self.label.role().words()[1]);
        let (log_x, [low, high], not_shown) = self.axis(&compared);
        Chart {
            log_x,
            x: low..high,
            not_shown,
            is_cumulative: true,
            marks: self.marks.clone(),
            ..self.chart(1, self.label, &label, series)
        }
    }

    /// Whether the axis is logarithmic, its ends at first, and what lies beyond.
    fn axis(&self, compared: &[&GroupSpectrum]) -> (bool, [f64; 2], Option<String>) {
        let upper = &self.evidence.upper;
        let reached = |share: f64| {
            compared.iter().map(move |group| {
                let at = group.cumulative.partition_point(|c| *c < share);
                upper[at.min(upper.len() - 1)]
            })
        };
        let least = |share: f64| reached(share).fold(f64::INFINITY, f64::min);
        let end = reached(MOST).fold(0.0, f64::max);
        let is_log = end > WIDE * least(0.1);
        let low = if is_log { 0.7 * least(0.005) } else { 0.0 };
        let is_part = is_log || end < 0.98 * upper[upper.len() - 1];
        let not_shown = is_part.then(|| "not shown: at most 0.5 % of the energy compared".into());
        (is_log, [low, end], not_shown)
    }

    /// Some of the other groups, evenly.
    fn thin(&self) -> Vec<usize> {
        let count = self.evidence.groups.len();
        let step = count.div_ceil(THIN + 1).max(1);
        let others = (step / 2..count).step_by(step);
        others
            .filter(|n| !self.evidence.compared.contains(n))
            .collect()
    }

    /// Between the curves compared, where they differ most.
    fn gaps(&self) -> Vec<Series> {
        let Some(between) = ends(self.evidence, self.of) else {
            return Vec::new();
        };
        let gap = |mark: &Mark| {
            let upper = &self.evidence.upper;
            let n = upper.partition_point(|f| *f < mark.at).min(upper.len() - 1);
            let share = |group: usize| self.evidence.groups[group].cumulative[n];
            let ends = between.map(|group| (mark.at, share(group)));
            Series {
                weight: Weight::Gap,
                ..Series::line(&*mark.label, BLUE, ends.to_vec())
            }
        };
        self.marks.iter().map(gap).collect()
    }
}

/// The points between which some curve rises, and the last.
fn kept(drawn: &[&GroupSpectrum]) -> Vec<usize> {
    let Some(first) = drawn.first() else {
        return Vec::new();
    };
    let count = first.cumulative.len();
    let mut kept: Vec<usize> = Vec::new();
    let rises = |from: Option<usize>, to: usize| {
        drawn.iter().any(|group| {
            let before = from.map_or(0.0, |n| group.cumulative[n]);
            group.cumulative[to] - before >= STEP
        })
    };
    for n in 0..count {
        let last = kept.last().copied();
        if rises(last, n) {
            // What is flat ends where it begins to rise.
            if n > 0 && last.is_none_or(|last| last + 1 < n) {
                kept.push(n - 1);
            }
            kept.push(n);
        }
    }
    if count > 0 && kept.last() != Some(&(count - 1)) {
        kept.push(count - 1);
    }
    kept
}
