//! Curves above one axis, for the page's script.

use serde::Serialize;

use super::{Look, Role, doubles, page_opens, sentence_case};
use crate::plot;

/// Longest curve that is embedded whole; of longer ones, the extremes of each block.
const CURVE_LIMIT: usize = 1 << 16;

/// How much a series stands out.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::report) enum Weight {
    /// Without values on hovering.
    Thin,
    #[default]
    Normal,
    Bold,
    /// A difference between other series.
    Gap,
}

impl Weight {
    fn is_normal(&self) -> bool {
        *self == Weight::Normal
    }
}

/// Values on the group's x, or on their own.
#[derive(Debug, Serialize)]
pub(in crate::report) struct Series {
    label: String,
    look: Look,
    /// Index of its colour; by default that of its place in the chart.
    color: Option<usize>,
    /// Place on a scale of colours, from 0 to 1, in its stead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shade: Option<f64>,
    #[serde(skip_serializing_if = "Weight::is_normal")]
    pub weight: Weight,
    /// Little-endian f64, as all: energies of faint fields are below the range of f32.
    x: Option<String>,
    values: String,
    /// Standard errors.
    errors: Option<String>,
    /// Whether the area down to the series before is filled.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    band: bool,
    #[serde(skip)]
    has_values: bool,
}

impl Series {
    /// Values on the group's x.
    pub fn new(label: impl Into<String>, values: &[f64]) -> Series {
        let embedded: Vec<f64> = match shown(values.len()) {
            EmbeddedCurve::All => values.to_vec(),
            EmbeddedCurve::Blocks(length) => values.chunks(length).flat_map(extremes).collect(),
        };
        Series {
            label: label.into(),
            look: Look::Line,
            color: None,
            shade: None,
            weight: Weight::Normal,
            x: None,
            values: doubles(embedded),
            errors: None,
            band: false,
            has_values: values.iter().any(|value| value.is_finite()),
        }
    }

    /// Values on an x of their own, which are embedded whole.
    pub fn points(label: impl Into<String>, points: &[(f64, f64)]) -> Series {
        Series {
            x: Some(doubles(points.iter().map(|point| point.0))),
            values: doubles(points.iter().map(|point| point.1)),
            has_values: points.iter().any(|point| point.1.is_finite()),
            ..Series::new(label, &[])
        }
    }

    pub fn colored(self, color: usize) -> Series {
        Series {
            color: Some(color),
            ..self
        }
    }

    pub fn looking(self, look: Look) -> Series {
        Series { look, ..self }
    }

    pub fn with_errors(self, errors: impl IntoIterator<Item = f64>) -> Series {
        Series {
            errors: Some(doubles(errors)),
            ..self
        }
    }
}

/// Series on one y axis.
#[derive(Debug, Serialize)]
pub(in crate::report) struct Chart {
    label: String,
    log: bool,
    /// A value marked across the chart.
    mark: Option<f64>,
    pub series: Vec<Series>,
}

impl Chart {
    pub fn new(label: impl Into<String>, series: Vec<Series>) -> Chart {
        Chart {
            label: label.into(),
            log: false,
            mark: None,
            series,
        }
    }

    pub fn log(self) -> Chart {
        Chart { log: true, ..self }
    }

    pub fn has_values(&self) -> bool {
        self.series.iter().any(|series| series.has_values)
    }

    pub fn marked(self, mark: Option<f64>) -> Chart {
        Chart { mark, ..self }
    }
}

/// Charts above one x axis.
#[derive(Debug, Serialize)]
pub(in crate::report) struct CurveGroup {
    pub id: String,
    pub title: String,
    #[serde(skip)]
    pub caption: String,
    /// What the page holds, where that is not every value.
    note: String,
    label: String,
    role: Option<Role>,
    pub log: bool,
    /// Places on x, with their names.
    pub marks: Vec<(f64, String)>,
    /// Whether they rise to 1 towards the right, where names have room below them.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub cumulative: bool,
    /// Ends of what is shown at first, where that is not all.
    shown: Option<[f64; 2]>,
    /// Little-endian f64.
    x: String,
    charts: Vec<Chart>,
}

impl CurveGroup {
    /// Charts of values at `x`, which may be empty where each series has its own. Charts without a
    /// value are left out.
    pub fn new(
        (id, title): (&str, &str),
        caption: impl Into<String>,
        (label, role): (impl Into<String>, Option<Role>),
        x: &[f64],
        mut charts: Vec<Chart>,
    ) -> CurveGroup {
        charts.retain(Chart::has_values);
        let shown = shown(x.len());
        let embedded: Vec<f64> = match shown {
            EmbeddedCurve::All => x.to_vec(),
            EmbeddedCurve::Blocks(length) => x
                .chunks(length)
                .flat_map(|block| [block[block.len() / 4], block[3 * block.len() / 4]])
                .collect(),
        };
        CurveGroup {
            id: id.into(),
            title: title.into(),
            caption: caption.into(),
            note: match shown {
                EmbeddedCurve::All => String::new(),
                EmbeddedCurve::Blocks(length) => {
                    format!(" The page holds the least and the largest of every {length} values.")
                }
            },
            label: label.into(),
            role,
            log: false,
            marks: Vec::new(),
            cumulative: false,
            shown: None,
            x: doubles(embedded),
            charts,
        }
    }

    /// The chart of a figure, whose picks nothing follows.
    pub fn of_chart(id: &str, caption: &str, chart: &plot::Chart) -> CurveGroup {
        let ends = chart.series.iter().flat_map(|series| {
            let band = series.band.iter().flat_map(|band| {
                let end = |of: fn(&(f64, f64)) -> f64, which: &str| {
                    let ends = series.points.iter().zip(&band.ends);
                    let points: Vec<_> = ends.map(|(point, ends)| (point.0, of(ends))).collect();
                    Series::points(format!("{}, {which} end", band.label), &points)
                        .colored(series.colour)
                };
                let upper = Series {
                    band: true,
                    ..end(|ends| ends.1, "upper")
                };
                [end(|ends| ends.0, "lower"), upper]
            });
            band.collect::<Vec<_>>()
        });
        let series = chart.series.iter().map(|series| {
            let drawn = Series::points(&series.label, &series.points)
                .colored(series.colour)
                .looking(series.look);
            match series.errors.iter().any(|error| *error > 0.0) {
                true => drawn.with_errors(series.errors.iter().copied()),
                false => drawn,
            }
        });
        let one = Chart {
            log: chart.log_y,
            ..Chart::new(&chart.y_label, ends.chain(series).collect())
        };
        let marks = chart.marks.iter().map(|mark| (mark.at, mark.label.clone()));
        let heading = (id, &*sentence_case(&chart.title));
        CurveGroup {
            log: chart.log_x,
            marks: marks.collect(),
            ..CurveGroup::new(heading, caption, (&chart.x_label, None), &[], vec![one])
        }
    }

    /// Shows a part of x at first, if `not_shown` says what it leaves out.
    pub fn limited(self, shown: [f64; 2], not_shown: Option<String>) -> CurveGroup {
        match not_shown {
            None => self,
            Some(not_shown) => CurveGroup {
                shown: Some(shown),
                caption: self.caption + &page_opens(&not_shown),
                ..self
            },
        }
    }

    pub fn has_values(&self) -> bool {
        !self.charts.is_empty()
    }

    /// Whether the page shows a part of it at first.
    pub fn opens_on_part(&self) -> bool {
        self.shown.is_some()
    }
}

/// How much of a curve is embedded.
enum EmbeddedCurve {
    All,
    /// The extremes of each block of this many samples, one after the other.
    Blocks(usize),
}

fn shown(samples: usize) -> EmbeddedCurve {
    match samples {
        0..=CURVE_LIMIT => EmbeddedCurve::All,
        _ => EmbeddedCurve::Blocks(samples.div_ceil(CURVE_LIMIT / 2)),
    }
}

/// The smallest and the largest value, in their order of appearance.
fn extremes(block: &[f64]) -> [f64; 2] {
    let (mut low, mut high) = ((0, f64::NAN), (0, f64::NAN));
    for (index, &value) in block.iter().enumerate() {
        if low.1.is_nan() || value < low.1 {
            low = (index, value);
        }
        if high.1.is_nan() || value > high.1 {
            high = (index, value);
        }
    }
    match low.0 <= high.0 {
        true => [low.1, high.1],
        false => [high.1, low.1],
    }
}
