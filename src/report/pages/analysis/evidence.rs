//! The cumulative spectra that an answer rests on.

use super::words;
use crate::analyze::Analysis;
use crate::analyze::sheet::Words;
use crate::moved::{Evidence, GroupSpectrum, Movement, Place, Verdict};
use crate::plot::labels;
use crate::report::page::{Chart, CurveGroup, Look, Role, Series, Weight};

/// Groups drawn at most, beside those compared.
const THIN: usize = 6;

/// Least difference of cumulative shares between neighbouring points of a curve.
const STEP: f64 = 1e-3;

/// Share of the energy below the end of the axis, at first.
const MOST: f64 = 0.995;

/// Ends over the frequency below which a tenth of the energy lies, from which on the axis is logarithmic.
const WIDE: f64 = 40.0;

/// The groups along x, then those in time, where there are some.
pub(super) fn of(analysis: &Analysis) -> Vec<CurveGroup> {
    let (Some(answer), Some(words)) = (&analysis.answer, Words::of(analysis)) else {
        return Vec::new();
    };
    let has_groups = |evidence: &&Evidence| !evidence.groups.is_empty();
    let along_x = answer.along_x.as_ref().filter(has_groups);
    let along_x = along_x.map(|evidence| {
        let of = &answer.frequency;
        let launch = answer.launch.as_ref();
        let larger = launch.filter(|launch| launch.most() > of.most());
        let shown = larger.unwrap_or(of);
        let mut marks = moved(shown, words.in_frequency(shown));
        if larger.is_some() {
            marks
                .iter_mut()
                .for_each(|(_, text)| *text = format!("launch: {text}"));
        }
        let compared = [of, launch.unwrap_or(of)];
        Curves {
            id: "moved-along-x",
            label: (labels::frequency(&analysis.axes), Role::Frequency),
            symbol: "f",
            evidence,
            bold: bold(evidence, &compared),
            gap: ends(evidence, shown),
            marks,
            name: &|place| words.named_sites(place),
        }
        .group()
    });
    let along_t = answer.along_t.as_ref().filter(has_groups);
    let along_t = along_t.map(|evidence| {
        let of = &answer.wavenumber;
        Curves {
            id: "moved-in-time",
            label: (labels::wavenumber(&analysis.axes), Role::Wavenumber),
            symbol: "k",
            evidence,
            bold: bold(evidence, &[of]),
            gap: ends(evidence, of),
            marks: moved(of, words.in_wavenumber(of)),
            name: &|place| words.named_time(place),
        }
        .group()
    });
    let mut groups: Vec<CurveGroup> = along_x.into_iter().chain(along_t).collect();
    groups.retain(CurveGroup::has_values);
    groups
}

/// What a verdict states, of the shares that moved up and down.
fn moved(of: &Movement, [up, down]: [(f64, String); 2]) -> Vec<(f64, String)> {
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

/// The groups compared, in their order.
fn bold(evidence: &Evidence, compared: &[&Movement]) -> Vec<usize> {
    let ends = compared.iter().filter_map(|of| ends(evidence, of));
    let mut bold: Vec<usize> = ends.flatten().collect();
    if bold.is_empty() {
        bold = evidence.compared.to_vec();
    }
    bold.sort_unstable();
    bold.dedup();
    bold
}

struct Curves<'a> {
    id: &'static str,
    label: (String, Role),
    /// Of frequency or wavenumber.
    symbol: &'static str,
    evidence: &'a Evidence,
    /// Groups that are compared.
    bold: Vec<usize>,
    /// Those between which the shares of the marks moved.
    gap: Option<[usize; 2]>,
    marks: Vec<(f64, String)>,
    name: &'a dyn Fn(&Place) -> String,
}

impl Curves<'_> {
    fn group(self) -> CurveGroup {
        let groups = &self.evidence.groups;
        let bold = &self.bold;
        let thin = self.thin();
        let tail = &self.evidence.tail;
        let compared: Vec<&GroupSpectrum> = bold.iter().map(|&n| &groups[n]).collect();
        let others = thin.iter().map(|&n| &groups[n]).chain(tail);
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
        if let Some(tail) = tail {
            let tail = curve("tail".into(), tail);
            series.push(tail.looking(Look::Dashed).colored(3));
        }
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
        others.filter(|n| !self.bold.contains(n)).collect()
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
