//! What a result needs to know of the fields beside their samples.

use super::shots::TOGETHER;
use crate::field::{Axis, Field, Quantity};

/// The axes and the unit that all records of an estimate share.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Grid {
    pub times: usize,
    pub sites: usize,
    pub time: Axis,
    pub space: Axis,
    pub quantity: Quantity,
    pub unit: Option<String>,
}

impl Grid {
    pub fn of(field: &Field) -> Grid {
        Grid {
            times: field.n_times(),
            sites: field.n_sites(),
            time: field.time.clone(),
            space: field.space.clone(),
            quantity: field.quantity,
            unit: field.unit.clone(),
        }
    }

    pub(crate) fn tiles(&self) -> usize {
        self.sites.div_ceil(TOGETHER)
    }

    /// Threads that have a tile.
    pub(crate) fn threads(&self) -> u64 {
        self.tiles().min(rayon::current_num_threads()) as u64
    }
}
