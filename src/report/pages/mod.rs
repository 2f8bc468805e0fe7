//! The pages of results, one for each command.

mod analysis;
mod attenuation;
mod bicoherence;
mod budget;
mod budget_pictures;
mod coherence;
mod fields;
mod increments;
mod localized;
mod modes;
mod ridges;
mod slope;
mod spacetime;
mod spectrum;
mod sweep;
mod transfer;
mod triads;

pub use analysis::analysis_html;
pub use attenuation::{attenuation_html, transmission_html};
pub use bicoherence::bicoherence_html;
pub use budget::{budget_html, comparison_html, comparison_rows};
pub use coherence::coherence_html;
pub use fields::fields_html;
pub use increments::increments_html;
pub use localized::{journey_html, localized_html, wave_html};
pub use modes::modes_html;
pub use ridges::ridges_html;
pub use slope::slope_html;
pub use spacetime::spacetime_html;
pub use spectrum::spectrum_html;
pub use sweep::sweep_html;
pub use triads::triads_html;
