//! Searches of a fit, each kept in a directory once it has ended: the same fit resumes there.

use serde::{Deserialize, Serialize};

use super::FitRequest;
use super::model::Model;
use crate::Result;
use crate::system::journal::{Journal, StoredRequest};

/// What is fitted, to tell one fit from another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Asked {
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

/// Where a search began and ended, the squares there, and the runs that it took.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Ended {
    pub start: Vec<f64>,
    pub end: Vec<f64>,
    pub squares: f64,
    pub is_settled: bool,
    pub runs: u64,
}

/// The searches that have ended.
pub(super) type Kept = Journal<usize, Ended>;

impl Asked {
    pub fn of(request: &FitRequest, model: &Model) -> Result<Asked> {
        let records = model.records;
        let mut hasher = blake3::Hasher::new();
        for number in records.times.iter().chain(&records.values) {
            hasher.update(&number.to_le_bytes());
        }
        let places = format!("{:?} {}", records.bodies, records.quantity.name());
        hasher.update(places.as_bytes());
        Ok(Asked {
            version: env!("CARGO_PKG_VERSION").into(),
            scene: model.scene.whole_text()?,
            records: hasher.finalize().to_hex().to_string(),
            request: FitRequest {
                bodies: None,
                resume: None,
                ..request.clone()
            },
        })
    }
}
