//! Samples where they lie, read by blocks.

use std::ops::Range;
use std::sync::Arc;

use ndarray::Array2;

/// Type of one stored sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SampleType {
    F64,
}

#[derive(Debug, Clone)]
pub(crate) struct Storage {
    values: Arc<Array2<f64>>,
}

impl Storage {
    pub(crate) fn from_array(values: Array2<f64>) -> Self {
        Storage {
            values: Arc::new(values),
        }
    }

    pub(crate) fn read(
        &self,
        times: Range<usize>,
        sites: Range<usize>,
        site_major: bool,
        out: &mut [f64],
    ) {
        let mut at = 0;
        if site_major {
            for j in sites {
                for n in times.clone() {
                    out[at] = self.values[[n, j]];
                    at += 1;
                }
            }
        } else {
            for n in times {
                for j in sites.clone() {
                    out[at] = self.values[[n, j]];
                    at += 1;
                }
            }
        }
    }

    pub(crate) fn release_pages(&self) {}
}
