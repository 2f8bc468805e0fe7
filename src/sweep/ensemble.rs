//! Ensembles: members of a sweep that differ in the seed alone.

use serde::Serialize;
use serde_json::Value;

use super::{Outcome, Outcomes, Request};
use crate::numeric::deviation;

/// The key whose values are the members of an ensemble.
pub(super) const SEED: &str = "seed";

/// Names and known values.
type Columns = Vec<(String, Vec<f64>)>;

/// Members with the same values of all keys but the seed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ensemble {
    /// Values of the other keys, in their order.
    pub values: Vec<String>,
    /// Of each column of the sweep's table.
    pub columns: Vec<Spread>,
}

/// How a column of the table spreads over the members of an ensemble.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spread {
    /// Of the column.
    pub column: String,
    /// Members in which it is known.
    pub members: usize,
    /// What 5, 50 and 95 % of them are below, by linear interpolation of their order statistics.
    pub p05: f64,
    pub median: f64,
    pub p95: f64,
    pub mean: f64,
    /// Standard deviation, of n - 1 degrees of freedom; 0 for one member.
    pub deviation: f64,
}

impl Request {
    /// The index of the seed among the keys, if it has several values.
    pub(super) fn seed(&self) -> Option<usize> {
        let is_seed = |axis: &super::SweptKey| axis.key == SEED && axis.values.len() > 1;
        self.vary.iter().position(is_seed)
    }

    /// The ensembles of a sweep over seeds, in the order of its table; none where the seed is not varied.
    pub fn ensembles(&self, outcomes: &Outcomes) -> Vec<Ensemble> {
        let Some(seed) = self.seed() else {
            return Vec::new();
        };
        let mut groups: Vec<(Vec<String>, Columns)> = Vec::new();
        for (&member, outcome) in outcomes {
            let Outcome::Done(measures) = outcome else {
                continue;
            };
            let mut values = self.values(member);
            values.remove(seed);
            let found = groups.iter().position(|(known, _)| *known == values);
            let at = found.unwrap_or_else(|| {
                groups.push((values.into_iter().map(str::to_owned).collect(), Vec::new()));
                groups.len() - 1
            });
            let Ok(Value::Object(measures)) = serde_json::to_value(measures) else {
                continue;
            };
            for (column, value) in measures {
                let value = match value {
                    Value::Bool(is) => Some(f64::from(u8::from(is))),
                    value => value.as_f64(),
                };
                let columns = &mut groups[at].1;
                match (
                    value,
                    columns.iter_mut().find(|(known, _)| *known == column),
                ) {
                    (Some(value), Some((_, values))) => values.push(value),
                    (Some(value), None) => columns.push((column, vec![value])),
                    (None, _) => {}
                }
            }
        }
        let ensembles = groups.into_iter().map(|(values, columns)| Ensemble {
            values,
            columns: columns
                .into_iter()
                .map(|(name, all)| spread(name, all))
                .collect(),
        });
        ensembles.collect()
    }
}

impl Ensemble {
    /// The spread of a column.
    pub fn of(&self, column: &str) -> Option<&Spread> {
        self.columns.iter().find(|spread| spread.column == column)
    }
}

fn spread(column: String, mut values: Vec<f64>) -> Spread {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let below = |share: f64| {
        let at = share * (n - 1) as f64;
        let (low, rest) = (at.floor() as usize, at.fract());
        values[low] + rest * (values[(low + 1).min(n - 1)] - values[low])
    };
    Spread {
        column,
        members: n,
        p05: below(0.05),
        median: below(0.5),
        p95: below(0.95),
        mean: values.iter().sum::<f64>() / n as f64,
        deviation: deviation(&values),
    }
}

/// The ensembles as CSV: the other keys, then a row for each column.
pub(super) fn csv(request: &Request, ensembles: &[Ensemble]) -> Result<String, csv::Error> {
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(Vec::new());
    let keys = request.vary.iter().map(|axis| axis.key.as_str());
    let keys = keys.filter(|key| *key != SEED);
    let head = [
        "column",
        "members",
        "p05",
        "median",
        "p95",
        "mean",
        "deviation",
    ];
    writer.write_record(keys.chain(head))?;
    for ensemble in ensembles {
        for spread in &ensemble.columns {
            writer.serialize((&ensemble.values, spread))?;
        }
    }
    let bytes = writer.into_inner().map_err(|error| error.into_error())?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
