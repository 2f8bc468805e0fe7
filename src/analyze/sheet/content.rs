//! How content is distributed along x and along t, in words.

use super::super::stages::RESOLVED;
use super::super::{
    Analysis, Axes, BandEdge, Front, FrontLength, Headline, Moments, Spot, UndefinedRows,
};
use crate::sheet::{Sheet, number, percent};

/// Where the content moves, along x and along t, and how well that is resolved.
///
/// Shares of the high band are given at the reference, at their largest after it, and at the last
/// site (time) with energy, each with its position.
pub(super) fn describe(analysis: &Analysis, sheet: &mut Sheet) {
    let axes = &analysis.axes;
    if let Some(moments) = &analysis.along_space {
        let along = Along::space(axes);
        let headline = &analysis.headline_space;
        // A part cut by the record's end hardly describes the content.
        let whole = analysis
            .front
            .as_ref()
            .and_then(|front| front.headline.last);
        let last = whole.or(headline.last);
        let mut band = along.describe(sheet, moments, headline, last, analysis.frequency_edge);
        if let Some(front) = &analysis.front {
            let cut = headline.last.filter(|last| !front.fits[last.row]);
            if let (FrontLength::Window { .. }, Some(last)) = (front.length, cut) {
                let place = (along.place)(&last);
                band += &format!("; the record ends while the front passes {place}");
                if headline.largest.is_none() && headline.reference.is_some() {
                    band += ", and every other from the reference on, so that no largest is named";
                }
            }
        }
        sheet.detail(along.band[1], band);
        if let Some(front) = &analysis.front {
            sheet.detail("front passage", along.front(front, axes));
        }
    }
    if let Some(moments) = &analysis.along_time {
        let along = Along::time(axes);
        let headline = &analysis.headline_time;
        let last = headline.last;
        let band = along.describe(sheet, moments, headline, last, analysis.wavenumber_edge);
        sheet.detail(along.band[1], band);
    }
}

/// The words for one of the axes.
struct Along<'a> {
    name: &'static str,
    /// Names of the edge and of the shares of the band above it.
    band: [&'static str; 2],
    rows: &'static str,
    content_unit: String,
    /// What a row without content is.
    single: &'static str,
    /// The content's bin 0.
    zero: &'static str,
    place: Box<dyn Fn(&Spot) -> String + 'a>,
}

impl<'a> Along<'a> {
    fn space(axes: &'a Axes) -> Self {
        Along {
            name: "frequency along x",
            band: ["band edge in f", "high band in f"],
            rows: "sites",
            content_unit: axes.frequency_unit(),
            single: "a single time has no frequencies",
            zero: "f = 0",
            place: Box::new(|spot| match &axes.space.unit {
                Some(unit) => format!("site {} (x = {} {unit})", spot.index, number(spot.at)),
                None => format!("site {}", spot.index),
            }),
        }
    }

    fn time(axes: &'a Axes) -> Self {
        Along {
            name: "wavenumber along t",
            band: ["band edge in k", "high band in k"],
            rows: "times",
            content_unit: axes.wavenumber_unit(),
            single: "a single site has no wavenumbers",
            zero: "k = 0",
            place: Box::new(|spot| {
                let unit = axes.time.unit.as_deref().unwrap_or_default();
                format!("t = {} {unit}", number(spot.at)).trim_end().into()
            }),
        }
    }

    /// Adds the content and the edge; returns the shares of the band above it.
    fn describe(
        &self,
        sheet: &mut Sheet,
        moments: &Moments,
        headline: &Headline,
        last: Option<Spot>,
        edge: Option<BandEdge>,
    ) -> String {
        sheet.detail(self.name, self.content(moments, headline, last));
        if let Some(edge) = edge {
            sheet.detail(self.band[0], self.edge(edge, moments, headline));
        }
        let mut text = shares(headline, &*self.place, "the last with energy")
            .unwrap_or_else(|| "undefined: no band edge".into());
        let all = moments.entropy.len();
        if moments.undefined.total() < all
            && let Some(why) = undefined_rows(moments.undefined)
        {
            text += &format!("; of {all} {}, {why}", self.rows);
        }
        text
    }

    /// Centroid, 90 % and effective bandwidth at the reference and at the row `last`.
    fn content(&self, moments: &Moments, headline: &Headline, last: Option<Spot>) -> String {
        let spots = [headline.reference, last];
        let mut rows: Vec<Spot> = spots.into_iter().flatten().collect();
        rows.dedup_by_key(|spot| spot.row);
        rows.retain(|spot| moments.centroid[spot.row].is_finite());
        let unit = &self.content_unit;
        let parts = rows.iter().map(|spot| {
            let zero = moments.zero_share[spot.row];
            let zero = match zero > 0.5 {
                true => format!(", with {} of the energy at {}", percent(zero), self.zero),
                false => String::new(),
            };
            format!(
                "centroid {}, 90 % below {}, effective bandwidth {} {unit} at {}{zero}",
                number(moments.centroid[spot.row]),
                number(moments.quantile_90[spot.row]),
                number(moments.effective_bandwidth[spot.row]),
                (self.place)(spot)
            )
        });
        let parts: Vec<String> = parts.collect();
        match (parts.is_empty(), headline.last.is_some()) {
            (false, _) => parts.join("; "),
            (true, true) => format!("undefined: {}", self.single),
            (true, false) => "undefined: no energy".into(),
        }
    }

    fn edge(&self, edge: BandEdge, moments: &Moments, headline: &Headline) -> String {
        let unit = &self.content_unit;
        let at = |index: usize, at: f64| {
            (self.place)(&Spot {
                row: 0,
                index,
                at,
                high_share: None,
            })
        };
        match edge {
            BandEdge::Given { value } => format!("{} {unit}, as given", number(value)),
            BandEdge::Reference {
                value,
                index,
                at: x,
            } => format!(
                "{} {unit}, with 90 % of the energy at {} below",
                number(value),
                at(index, x)
            ),
            BandEdge::Unresolved {
                value,
                index,
                at: x,
                bin,
            } => format!(
                "unresolved: 90 % of the energy at {} lies below {} {unit}, within {RESOLVED} bins of 0, \
                 which are {} apart; {}",
                at(index, x),
                number(value),
                number(bin),
                self.resolved(bin, moments, headline)
            ),
            BandEdge::Undefined if headline.last.is_some() => {
                let reason = match headline.reference {
                    Some(_) => self.single,
                    None => "the reference has no energy",
                };
                format!("undefined: {reason}")
            }
            BandEdge::Undefined => "undefined: no energy".into(),
        }
    }

    /// How an edge is had that is resolved.
    fn resolved(&self, bin: f64, moments: &Moments, headline: &Headline) -> String {
        if self.rows != "sites" {
            return "name another `--reference-time`, give `--band-edge-wavenumber`, or, if it is noise \
                    common to all sites, remove it with `--detrend-space mean`"
                .into();
        }
        let such_as = headline.reference.and_then(|spot| {
            let mut quantiles = moments.quantile_90.iter().skip(spot.row);
            let further = quantiles.position(|&quantile| quantile > RESOLVED * bin)?;
            Some(format!(" (such as {})", spot.index + further))
        });
        format!(
            "name another `--reference-site`{}, give `--band-edge-frequency`, or, if it is an offset, \
             remove it with `--detrend-time mean`",
            such_as.unwrap_or_default()
        )
    }

    fn front(&self, front: &Front, axes: &Axes) -> String {
        let time = |t: f64| {
            let unit = axes.time.unit.as_deref().unwrap_or_default();
            format!("{} {unit}", number(t)).trim_end().to_owned()
        };
        match front.length {
            FrontLength::Window {
                window,
                samples,
                pulse_width,
            } => {
                let why = match pulse_width {
                    Some(width) => format!(
                        "{:.0} times the pulse's width of {}",
                        window / width,
                        time(width)
                    ),
                    None => "as given".into(),
                };
                let found = shares(&front.headline, &*self.place, "the last where it fits");
                let found = found.unwrap_or_else(|| match front.headline.last {
                    Some(_) => "undefined: no band edge".into(),
                    None => "undefined: from no arrival on does it fit into the record".into(),
                });
                format!(
                    "high band over {} ({samples} samples, {why}) from each arrival: {found}",
                    time(window)
                )
            }
            FrontLength::NoReference => "undefined: no energy at the reference".into(),
            FrontLength::NoPulse => {
                "undefined: the reference has no pulse whose width would give a length; give `--front-window`".into()
            }
            FrontLength::TooLong { window } => format!(
                "undefined: a window of {} is longer than the record; give a shorter `--front-window`",
                time(window)
            ),
            FrontLength::NoArrival {
                at_once,
                sites,
                noise: true,
            } => format!(
                "undefined: the records are noise, with spectra as flat as those of white noise; it \
                 exceeds a hundredth of the largest value at the first sample at {at_once} of {sites} sites"
            ),
            FrontLength::NoArrival {
                at_once,
                sites,
                noise: false,
            } => format!(
                "undefined: no front is seen to arrive, since {at_once} of {sites} sites exceed a hundredth \
                 of the largest value before it comes, by motion or by noise"
            ),
        }
    }
}

/// How many rows have no measures, and why; `None` where all have.
fn undefined_rows(rows: UndefinedRows) -> Option<String> {
    let many = |count: usize, one: &str, more: &str| match count {
        0 => None,
        1 => Some(format!("1 {one}")),
        _ => Some(format!("{count} {more}")),
    };
    let reasons = [
        many(
            rows.quiet,
            "has too little energy to tell",
            "have too little energy to tell",
        ),
        many(rows.left_out, "is left out", "are left out"),
        many(
            rows.noise_unknown,
            "has noise that is not known",
            "have noise that is not known",
        ),
    ];
    let reasons: Vec<String> = reasons.into_iter().flatten().collect();
    (!reasons.is_empty()).then(|| reasons.join(", "))
}

/// The share of the high band at the places of a headline; rows that play several parts are named
/// once. `None` where there are no shares.
fn shares(headline: &Headline, place: &dyn Fn(&Spot) -> String, last: &str) -> Option<String> {
    let mut named: Vec<(Spot, Vec<&str>)> = Vec::new();
    let parts = [
        (headline.reference, "the reference"),
        (headline.largest, "the largest from there on"),
        (headline.last, last),
    ];
    for (spot, part) in parts {
        let Some(spot) = spot.filter(|spot| spot.high_share.is_some()) else {
            continue;
        };
        match named.iter_mut().find(|(known, _)| known.row == spot.row) {
            Some((_, parts)) => parts.push(part),
            None => named.push((spot, vec![part])),
        }
    }
    let named: Vec<String> = named
        .iter()
        .map(|(spot, parts)| {
            let share = percent(spot.high_share.unwrap_or(f64::NAN));
            let parts = match &parts[..] {
                [first, others @ .., last] if !others.is_empty() => {
                    format!("{first}, {} and {last}", others.join(", "))
                }
                parts => parts.join(" and "),
            };
            format!("{share} at {}, {parts}", place(spot))
        })
        .collect();
    (!named.is_empty()).then(|| named.join("; "))
}
