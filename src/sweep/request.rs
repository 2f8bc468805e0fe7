//! The request of a sweep, and the contents of its directory.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::axis::{self, SweptKey};
use super::measures::Measures;
use crate::Result;
use crate::chain::scene::{SceneSource, Setting, Units};
use crate::system::journal::{self, StoredRequest};

/// A request: equal requests have equal members.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Results of different versions are not mixed.
    pub version: String,
    /// The scene that is varied, as its text.
    pub scene: String,
    pub vary: Vec<SweptKey>,
}

impl Request {
    /// How many members there are.
    pub fn members(&self) -> usize {
        self.vary.iter().map(|axis| axis.values.len()).product()
    }

    /// The values of a member, one for each key.
    pub fn values(&self, member: usize) -> Vec<&str> {
        axis::member(&self.vary, member)
    }

    /// The same as settings of the scene.
    pub(super) fn settings(&self, member: usize) -> impl Iterator<Item = Setting> {
        let keys = self.vary.iter().map(|axis| axis.key.as_str());
        let pairs = keys.zip(self.values(member));
        pairs.map(|(key, value)| Setting::new(key, value, format!("values of {key}")))
    }

    /// Whether the numbers of the members are in SI units, by the first of them.
    pub fn is_si(&self) -> bool {
        let first = SceneSource::new(None, self.scene.clone()).with(self.settings(0));
        first.setup().is_ok_and(|setup| setup.units == Units::Si)
    }
}

/// What became of a member.
pub type Outcome = journal::Outcome<Measures>;

/// The members that are known, by their index in the product of the axes.
pub type Outcomes = journal::Outcomes<usize, Measures>;

/// What a directory holds of a sweep.
///
/// # Errors
/// [`crate::Error::Read`] where it cannot be read or holds none; [`crate::Error::Damaged`] where none of its members is
/// one of its request.
pub fn read(directory: &Path) -> Result<(Request, Outcomes)> {
    journal::read(directory)
}

impl StoredRequest for Request {
    const FILE: &'static str = "sweep.json";
    const WORD: &'static str = "sweep";
}
