//! The request of a sweep, and the contents of its directory.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::axis::{self, SweptKey};
use super::measures::Measures;
use crate::Result;
use crate::chain::scene::{SceneSource, Setting, Units};
use crate::system::journal::{self, Check, StoredRequest};

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
    /// The values of a member, one for each key.
    pub fn values(&self, member: usize) -> Vec<&str> {
        axis::member(&self.vary, member)
    }

    /// Whether the numbers of the members are in SI units, by the first of them.
    pub fn is_si(&self) -> bool {
        let keys = self.vary.iter().map(|axis| axis.key.as_str());
        let settings = keys
            .zip(self.values(0))
            .map(|(key, value)| Setting::new(key, value, format!("values of {key}")));
        let first = SceneSource::new(None, self.scene.clone()).with(settings);
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
/// [`crate::Error::Read`] where it cannot be read or holds none; [`crate::Error::Damaged`] for a line
/// that is no member.
pub fn read(directory: &Path) -> Result<(Request, Outcomes)> {
    journal::read(directory, |request: &Request| {
        Ok(Box::new(below(axis::count(&request.vary)?)) as Check<usize>)
    })
}

/// Members are numbered.
pub(crate) fn below(members: usize) -> impl Fn(&usize) -> std::result::Result<(), String> {
    move |&member| match member < members {
        true => Ok(()),
        false => Err(format!("expected a member below {members}, found {member}")),
    }
}

impl StoredRequest for Request {
    const FILE: &'static str = "sweep.json";
    const WORD: &'static str = "sweep";

    fn difference(&self, asked: &Request) -> Option<String> {
        let varies = |request: &Request| {
            let of_axis = |axis: &SweptKey| {
                let (first, last) = (axis.values.first(), axis.values.last());
                let end = |v: Option<&String>| v.cloned().unwrap_or_default();
                let n = axis.values.len();
                format!(
                    "{} from {} to {} in {n} values",
                    axis.key,
                    end(first),
                    end(last)
                )
            };
            let axes: Vec<String> = request.vary.iter().map(of_axis).collect();
            axes.join(", ")
        };
        if self.version != asked.version {
            let (found, asked) = (&self.version, &asked.version);
            Some(format!("it was made by version {found}, this is {asked}"))
        } else if self.vary != asked.vary {
            Some(format!("it varies {}", varies(self)))
        } else if self.scene != asked.scene {
            let line = self
                .scene
                .lines()
                .zip(asked.scene.lines())
                .position(|(a, b)| a != b);
            let shorter = self.scene.lines().count().min(asked.scene.lines().count());
            Some(format!(
                "its scene differs in line {}",
                line.unwrap_or(shorter) + 1
            ))
        } else {
            None
        }
    }
}
