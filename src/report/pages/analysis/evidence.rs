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
    let along_x = answer.along_x.as_ref().map(|evidence| {
        let of = &answer.frequency;
        let marks = moved(of, both(of, |f| words.frequency(f)));
        let position = (labels::position(axes), Role::Position);
        let profile = profile("profile-along-x", position, evidence, of, &marks);
        let curves = Curves {
            id: "moved-along-x",
            label: (labels::frequency(axes), Role::Frequency),
            symbol: "f",
            evidence,
            gap: ends(evidence, of),
            marks,
            name: &|place| words.sites(place),
        };
        vec![profile, curves.group()]
    });
    let along_t = answer.along_t.as_ref().map(|evidence| {
        let of = &answer.wavenumber;
        let marks = moved(of, both(of, |k| words.wavenumber(k)));
        let time = (labels::time(axes), Role::Time);
        let profile = profile("profile-in-time", time, evidence, of, &marks);
        let curves = Curves {
            id: "moved-in-time",
            label: (labels::wavenumber(axes), Role::Wavenumber),
            symbol: "k",
            evidence,
            gap: ends(evidence, of),
            marks,
            name: &|place| words.time(place),
        };
        vec![profile, curves.group()]
    });
    let mut rows: Vec<Vec<CurveGroup>> = along_x.into_iter().chain(along_t).collect();
    rows.iter_mut()
        .for_each(|row| row.retain(CurveGroup::has_values));
    rows.retain(|row| !row.is_empty());
    rows
}

/// What moved from the first group to each, with its 95 % interval.
fn profile(
    id: &str,
    (label, role): (String, Role),
    evidence: &Evidence,
    of: &Movement,
    marks: &[(f64, String)],
) -> CurveGroup {
    let places: Vec<f64> = evidence.groups.iter().map(|group| group.place.at).collect();
    let series = |name: &str, way: usize, color: usize| {
        let moves = || evidence.moves.iter().map(|both| both[way]);
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
    let most = of.to.filter(|_| of.moves());
    let most = most
        .zip(marks.first())
        .map(|(place, (_, text))| (place.at, text.clone()));
    CurveGroup::new(
        (id, words::title(id)),
        words::curve_caption(id),
        (label, Some(role)),
        &places,
        vec![Chart::new("share of energy moved", both)],
    )
    .marked(most.into_iter().collect())
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

struct Curves<'a> {
    id: &'static str,
    label: (String, Role),
    /// Of frequency or wavenumber.
    symbol: &'static str,
    evidence: &'a Evidence,
    /// Those between which the shares of the marks moved.
    gap: Option<[usize; 2]>,
    marks: Vec<(f64, String)>,
    name: &'a dyn Fn(&Place) -> String,
}

impl Curves<'_> {
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
        let curve = |label: String, group: &GroupSpectrum| {
            let mut shares = vec![0.0];
            shares.extend(kept.iter().map(|&n| group.cumulative[n]));
            Series::new(label, &shares)
        };
        let of_group = |n: usize| curve((self.name)(&groups[n].place), &groups[n]);
        // Those compared by their order, others by how far they are from the first to the last of these.
        let (first, last) = (bold[0], bold[bold.len() - 1]);
        let place = |n: usize, from: usize, to: usize| {
            let far = n.clamp(from, to) - from;
            far as f64 / (to - from).max(1) as f64
        };
        let mut series: Vec<Series> = thin
            .iter()
            .map(|&n| of_group(n).shaded(place(n, first, last)))
            .map(|series| series.weighing(Weight::Thin))
            .collect();
        series.extend(bold.iter().enumerate().map(|(rank, &n)| {
            let shade = place(rank, 0, bold.len() - 1);
            of_group(n).shaded(shade).weighing(Weight::Bold)
        }));
        series.extend(self.gaps());
        let label = format!("share of energy up to {}", self.symbol);
        let (is_log, shown, not_shown) = self.axis(&compared);
        CurveGroup::new(
            (self.id, words::title(self.id)),
            words::curve_caption(self.id),
            (self.label.0, Some(self.label.1)),
            &x,
            vec![Chart::new(label, series)],
        )
        .on_log_axis(is_log)
        .cumulative()
        .marked(self.marks)
        .limited(shown, not_shown)
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
        let Some(between) = self.gap else {
            return Vec::new();
        };
        let gap = |(at, text): &(f64, String)| {
            let upper = &self.evidence.upper;
            let n = upper.partition_point(|f| f < at).min(upper.len() - 1);
            let ends = between.map(|group| (*at, self.evidence.groups[group].cumulative[n]));
            Series::points(text, &ends).weighing(Weight::Gap)
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
