//! The laws of a chain's contacts.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::Law;
use crate::error::{Error, Result};

/// One law for all contacts, or a cell of laws that repeats along the chain from contact 0 on. A contact with a wall before
/// site 0 has the last one, as if the pattern went on.
#[derive(Debug, Clone, PartialEq)]
pub struct Laws(Arc<[Law]>);

impl From<Law> for Laws {
    fn from(law: Law) -> Laws {
        Laws(Arc::from([law]))
    }
}

impl Laws {
    /// # Errors
    /// [`crate::Error::Request`] for an empty cell.
    pub fn cell(cell: Vec<Law>) -> Result<Laws> {
        Error::require(!cell.is_empty(), "laws", "one law or more", "none")?;
        Ok(Laws(Arc::from(cell)))
    }

    /// The law of contact j.
    pub fn of(&self, contact: usize) -> &Law {
        &self.0[contact % self.0.len()]
    }

    /// The law of a contact with a wall before site 0.
    pub fn before_first(&self) -> &Law {
        &self.0[self.0.len() - 1]
    }

    /// The laws of the cell, in order.
    pub fn each(&self) -> &[Law] {
        &self.0
    }

    /// The law of all contacts, if it is one.
    pub fn only(&self) -> Option<&Law> {
        let first = &self.0[0];
        self.0.iter().all(|law| law == first).then_some(first)
    }

    /// Whether all contacts can only press.
    pub fn all_open(&self) -> bool {
        self.0.iter().all(Law::is_one_sided)
    }

    /// Unit of the coefficients in an SI scene.
    pub(crate) fn coefficient_unit(&self) -> String {
        let units: BTreeSet<String> = self.0.iter().map(Law::coefficient_unit).collect();
        units.into_iter().collect::<Vec<_>>().join(" | ")
    }

    /// The laws as a scene names them.
    pub fn text(&self) -> String {
        match self.only() {
            Some(law) => law.text(),
            None => self.0.iter().map(Law::text).collect::<Vec<_>>().join(" | "),
        }
    }
}
