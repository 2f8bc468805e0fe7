//! The few numbers by which fields are compared.

use serde::{Deserialize, Serialize};

use super::sentences::has_shares;
use crate::analyze::{Analysis, Headline, Moments, Spot};

/// Headline numbers of an analysis; those that are not defined are `None`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Headlines {
    pub times: usize,
    pub sites: usize,
    /// From the reference site to the last one with energy; over the passage of the front where that
    /// is known, else over the whole record.
    pub along_x: Option<Movement>,
    /// From the reference time to the last one with energy.
    pub along_t: Option<Movement>,
    /// Shares of the energy by direction.
    pub toward_plus_x: Option<f64>,
    pub toward_minus_x: Option<f64>,
    pub warnings: usize,
}

/// How the content of a field changes along one of its axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Movement {
    /// Unit of the centroids.
    pub unit: String,
    pub reference: Option<Content>,
    pub last: Option<Content>,
}

/// Content at one site or time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Content {
    /// Index in the file.
    pub index: usize,
    /// Position or time.
    pub at: f64,
    /// Centroid of the spectrum of the whole record (of the whole snapshot).
    pub centroid: Option<f64>,
    /// Share of the energy in the high band.
    pub high_share: Option<f64>,
}

impl Headlines {
    /// The headlines of an analysis; computes nothing new.
    pub fn of(analysis: &Analysis) -> Headlines {
        let axes = &analysis.axes;
        let front = analysis.front.as_ref().map(|front| &front.headline);
        let along_x = front.filter(|headline| has_shares(headline));
        let along_x = along_x.unwrap_or(&analysis.headline_space);
        let movement = |moments: &Option<Moments>, headline: &Headline, unit: String| {
            let content = |spot: Spot| content_at(moments.as_ref()?, spot);
            moments.as_ref()?;
            Some(Movement {
                unit,
                reference: headline.reference.and_then(content),
                last: headline.last.and_then(content),
            })
        };
        let direction = analysis.direction;
        Headlines {
            times: axes.n_times,
            sites: axes.n_sites,
            along_x: movement(&analysis.along_space, along_x, axes.frequency_unit()),
            along_t: movement(
                &analysis.along_time,
                &analysis.headline_time,
                axes.wavenumber_unit(),
            ),
            toward_plus_x: direction.and_then(|d| defined(d.toward_plus_x)),
            toward_minus_x: direction.and_then(|d| defined(d.toward_minus_x)),
            warnings: analysis.warnings.len(),
        }
    }
}

impl Movement {
    /// Centroid at the last row over that at the reference.
    pub fn rise(&self) -> Option<f64> {
        let rise = self.last?.centroid? / self.reference?.centroid?;
        defined(rise)
    }
}

fn content_at(moments: &Moments, spot: Spot) -> Option<Content> {
    Some(Content {
        index: spot.index,
        at: spot.at,
        centroid: moments.centroid.get(spot.row).copied().and_then(defined),
        high_share: spot.high_share,
    })
}

fn defined(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}
