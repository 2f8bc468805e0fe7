//! Searches of a fit, each kept in a directory once it has ended: the same fit resumes there.

use serde::{Deserialize, Serialize};

use super::model::Model;
use super::solver::{Minimum, Problem, square};
use super::{Counted, FitRequest};
use crate::Result;
use crate::system::journal::{Journal, Outcome, StoredRequest};

/// What is fitted, to tell one fit from another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    version: String,
    scene: String,
    /// BLAKE3 of the records that are fitted.
    records: String,
    request: FitRequest,
}

impl StoredRequest for Asked {
    const FILE: &'static str = "fit.json";
    const WORD: &'static str = "fit";
}

/// Where a search began and ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Ended {
    start: Vec<f64>,
    end: Vec<f64>,
    is_settled: bool,
    runs: u64,
}

/// The searches that have ended, kept in a directory if there is one.
pub(super) struct Kept(Option<Journal<usize, Ended>>);

/// A start, the minimum next to it and the runs that took.
pub(super) type Searched = (Vec<f64>, Minimum, u64);

impl Kept {
    /// # Errors
    /// As [`Journal::open`].
    pub fn open(request: &FitRequest, model: &Model) -> Result<Kept> {
        let Some(directory) = &request.resume else {
            return Ok(Kept(None));
        };
        let records = model.records;
        let mut hasher = blake3::Hasher::new();
        for number in records.times.iter().chain(&records.values) {
            hasher.update(&number.to_le_bytes());
        }
        let places = format!("{:?} {}", records.bodies, records.quantity.name());
        hasher.update(places.as_bytes());
        let asked = Asked {
            version: env!("CARGO_PKG_VERSION").into(),
            scene: model.scene.whole_text()?,
            records: hasher.finalize().to_hex().to_string(),
            request: FitRequest {
                bodies: None,
                resume: None,
                ..request.clone()
            },
        };
        Ok(Kept(Some(Journal::open(Some(directory), &asked)?)))
    }

    /// A search, as `find` makes it with a model that counts its runs, or as it is kept.
    ///
    /// # Errors
    /// Those of runs; [`crate::Error::Write`].
    pub fn search(
        &self,
        search: usize,
        model: &Model,
        find: impl FnOnce(&Model) -> Result<(Vec<f64>, Minimum)>,
    ) -> Result<Searched> {
        let counted = Counted::new(model.observer);
        let model = Model {
            observer: &counted,
            ..*model
        };
        let known = self.0.as_ref().and_then(|journal| journal.known(&search));
        if let Some(Outcome::Done(ended)) = known {
            let residual = model.residual(&ended.end)?;
            let minimum = Minimum {
                at: ended.end,
                squares: square(&residual),
                residual,
                columns: Vec::new(),
                is_settled: ended.is_settled,
            };
            return Ok((ended.start, minimum, ended.runs));
        }
        let (start, minimum) = find(&model)?;
        let runs = counted.runs();
        if let Some(journal) = &self.0 {
            let ended = Ended {
                start: start.clone(),
                end: minimum.at.clone(),
                is_settled: minimum.is_settled,
                runs,
            };
            journal.add(&search, Outcome::Done(ended))?;
            journal.sync()?;
        }
        Ok((start, minimum, runs))
    }
}
