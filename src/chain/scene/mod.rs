//! Scenes: a chain and a run of it as text.
//!
//! [`SceneSource`] is a text with settings that override it. It is parsed to a [`Scene`], whose
//! fields are optional and hold the typed values, and resolved to a [`Setup`], in which everything
//! is checked and determined. Faults name their key and its place. The declaration of [`Scene`] is
//! the only list of fields: schema, template and options are generated from it.

mod bodies;
mod check;
mod choices;
mod coefficients;
mod description;
mod drive;
mod files;
mod laws;
mod masses;
mod motion;
mod pattern;
mod places;
mod presets;
mod properties;
mod resonators;
mod setup;
mod source;
mod template;
mod typed;

pub use crate::error::{KeyPlace, SceneFault};
pub use crate::measure;
pub use choices::{
    Defect, DriveTyped, EndTimeTyped, EndsTyped, FirstContact, MaterialTyped, Recorded, Shape,
    Units, WaveformTyped,
};
pub use description::{Description, ResonatorsDescription};
pub use presets::{PRESETS, Preset, preset};
pub use properties::{Choice, Kind, Property, properties, schema};
pub use setup::Setup;
pub use source::{SceneSource, Setting, UNSET};
pub use template::template;
pub use typed::Scene;
