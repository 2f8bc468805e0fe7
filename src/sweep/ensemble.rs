//! Ensembles: members of a sweep that differ in the seed alone.

use std::collections::HashMap;

use serde::Serialize;

use super::{Outcomes, Request, SweptKey};
use crate::numeric::{deviation, sorted};

/// Names of measures with their values of each member.
type Columns = Vec<(String, Vec<f64>)>;

/// The key whose values are the members of an ensemble.
const SEED: &str = "seed";

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
    fn seed(&self) -> Option<usize> {
        let is_seed = |axis: &SweptKey| axis.key == SEED && axis.values.len() > 1;
        self.vary.iter().position(is_seed)
    }

    /// The keys but a seed that is varied.
    pub(super) fn axes(&self) -> Vec<&SweptKey> {
        let mut axes: Vec<&SweptKey> = self.vary.iter().collect();
        if let Some(seed) = self.seed() {
            axes.remove(seed);
        }
        axes
    }

    /// The ensembles of a sweep over seeds, in the order of its table; none where the seed is not varied.
    pub fn ensembles(&self, outcomes: &Outcomes) -> Vec<Ensemble> {
        let seed = self.seed();
        seed.map_or(Vec::new(), |_| self.grouped(outcomes, seed))
    }

    /// The members that are done, those together which differ in the key `but` alone.
    pub(super) fn grouped(&self, outcomes: &Outcomes, but: Option<usize>) -> Vec<Ensemble> {
        let mut groups: Vec<(Vec<&str>, Columns)> = Vec::new();
        let mut places = HashMap::new();
        for (&member, outcome) in outcomes {
            let Some(measures) = outcome.done() else {
                continue;
            };
            let mut values = self.values(member);
            if let Some(key) = but {
                values.remove(key);
            }
            let at = *places.entry(values.clone()).or_insert_with(|| {
                groups.push((values, Vec::new()));
                groups.len() - 1
            });
            let columns = &mut groups[at].1;
            let measures = serde_json::to_value(measures).unwrap_or_default();
            for (column, value) in measures.as_object().into_iter().flatten() {
                let value = value.as_f64().or(value.as_bool().map(f64::from));
                let Some(value) = value else { continue };
                match columns.iter_mut().find(|(known, _)| known == column) {
                    Some((_, values)) => values.push(value),
                    None => columns.push((column.clone(), vec![value])),
                }
            }
        }
        let ensembles = groups.into_iter().map(|(values, columns)| Ensemble {
            values: values.into_iter().map(str::to_owned).collect(),
            columns: columns.into_iter().map(spread).collect(),
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

fn spread((column, values): (String, Vec<f64>)) -> Spread {
    let values = sorted(values.into_iter());
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
