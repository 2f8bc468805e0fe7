//! The cumulative spectra that an answer rests on.

use super::words;
use crate::analyze::Analysis;
use crate::analyze::sheet::{Words, both};
use crate::moved::{Evidence, GroupSpectrum, Movement, Place, Verdict};
use crate::plot::labels;
use crate::report::page::{Chart, CurveGroup, Role, Series, Weight};
use crate::sheet::{BLUE, VERMILLION};

/// Groups drawn at most, beside those compared.
const THIN: usize = 6;

/// Least difference of cumulative shares between neighbouring points of a curve.
const STEP: f64 = 1e-3;

/// Share of the energy below the end of the axis, at first.
const MOST: f64 = 0.995;

/// Ends over the frequency below which a tenth of the energy lies, from which on the axis is logarithmic.
const WIDE: f64 = 40.0;

/// Rows of two pictures, along x and in time: the moves along the profile, and the cumulative spectra.
pub(super) fn of(analysis: &Analysis) -> Vec<Vec<CurveGroup>> {
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
        ids: ["profile-along-x", "moved-along-x"],
        along: (labels::position(axes), Role::Position),
        label: (labels::frequency(axes), Role::Frequency),
        symbol: "f",
        evidence,
        of: f,
        marks: moved(f, both(f, |f| words.frequency(f))),
        name: &sites,
    });
    let in_time = answer.along_t.as_ref().map(|evidence| Curves {
        ids: ["profile-in-time", "moved-in-time"],
        along: (labels::time(axes), Role::Time),
        label: (labels::wavenumber(axes), Role::Wavenumber),
        symbol: "k",
        evidence,
        of: k,
        marks: moved(k, both(k, |k| words.wavenumber(k))),
        name: &time,
    });
    let rows = along_x.into_iter().map(Curves::row);
    let mut rows: Vec<_> = rows.chain(in_time.map(Curves::row)).collect();
    rows.iter_mut()
        .for_each(|row| row.retain(CurveGroup::has_values));
    rows.retain(|row| !row.is_empty());
    rows
}

/// What a verdict states, of the shares that moved up and down.
fn moved(of: &Movement, [up, down]: [String; 2]) -> Vec<(f64, String)> {
    let [up, down] = [(of.up.at, up), (of.down.at, down)];
    let mut stated = match of.verdict {
        Verdict::Up => vec![up],
        Verdict::Down => vec![down],
        Verdict::Spreads => vec![up, down],
        Verdict::Unchanged | Verdict::Untold => Vec::new(),
    };
    stated.retain(|(at, _)| at.is_finite());
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
    /// Of the moves and of the spectra.
    ids: [&'static str; 2],
    along: (String, Role),
    label: (String, Role),
    /// Of frequency or wavenumber.
    symbol: &'static str,
    evidence: &'a Evidence,
    of: &'a Movement,
    marks: Vec<(f64, String)>,
    name: &'a dyn Fn(&Place) -> String,
}

impl Curves<'_> {
    fn row(self) -> Vec<CurveGroup> {
        vec![self.profile(), self.group()]
    }

    /// What moved from the first group to each, with its 95 % interval.
    fn profile(&self) -> CurveGroup {
        let groups = self.evidence.groups.iter();
        let places: Vec<f64> = groups.map(|group| group.place.at).collect();
        let series = |name: &str, way: usize, color: usize| {
            let moves = || self.evidence.moves.iter().map(|both| both[way]);
            let shares: Vec<f64> = moves().map(|of| of.share).collect();
            let errors = moves().map(|of| of.error);
            Series::new(name, &shares)
                .with_errors(errors)
                .colored(color)
        };
        let both = vec![
            series("moved up", 0, VERMILLION),
            series("moved down", 1, BLUE),
        ];
        let most = self.of.to.filter(|_| self.of.moves());
        let most = most.zip(self.marks.first());
        let (id, (label, role)) = (self.ids[0], self.along.clone());
        let mut group = CurveGroup::new(
            (id, words::title(id)),
            words::curve_caption(id),
            (label, Some(role)),
            &places,
            vec![Chart::new("share of energy moved", both)],
        );
        group.marks = Vec::from_iter(most.map(|(place, (_, text))| (place.at, text.clone())));
        group
    }

    fn group(self) -> CurveGroup {
        let groups = &self.evidence.groups;
        let bold = &self.evidence.compared;
        let thin = self.thin();
        let compared: Vec<&GroupSpectrum> = bold.iter().map(|&n| &groups[n]).collect();
        let others = thin.iter().map(|&n| &groups[n]);
        let drawn: Vec<&GroupSpectrum> = compared.iter().copied().chain(others).collect();
        let upper = &self.evidence.upper;
        let kept = kept(&drawn);
        let mut x = vec![0.0];
        x.extend(kept.iter().map(|&n| upper[n]));
        // A place between two others, from 0 to 1.
        let between = |n: usize, from: usize, to: usize| {
            let far = n.clamp(from, to) - from;
            far as f64 / (to - from).max(1) as f64
        };
        let curve = |n: usize, weight: Weight, shade: f64| {
            let mut shares = vec![0.0];
            shares.extend(kept.iter().map(|&kept| groups[n].cumulative[kept]));
            let mut series = Series::new((self.name)(&groups[n].place), &shares);
            (series.weight, series.shade) = (weight, Some(shade));
            series
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
        let label = format!("share of energy up to {}", self.symbol);
        let (is_log, shown, not_shown) = self.axis(&compared);
        let id = self.ids[1];
        let mut group = CurveGroup::new(
            (id, words::title(id)),
            words::curve_caption(id),
            (self.label.0, Some(self.label.1)),
            &x,
            vec![Chart::new(label, series)],
        );
        (group.log, group.cumulative, group.marks) = (is_log, true, self.marks);
        group.limited(shown, not_shown)
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
        let gap = |(at, text): &(f64, String)| {
            let upper = &self.evidence.upper;
            let n = upper.partition_point(|f| f < at).min(upper.len() - 1);
            let ends = between.map(|group| (*at, self.evidence.groups[group].cumulative[n]));
            let mut series = Series::points(text, &ends);
            series.weight = Weight::Gap;
            series
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
