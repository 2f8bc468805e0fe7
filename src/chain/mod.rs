//! The chain: from a scene to velocities, forces and the energy passed.

pub mod contact;
mod drive;
mod elliptic;
mod lattice;
mod law;
mod many;
mod peak;
mod root;
mod run;
pub mod scene;
mod stepping;
mod warning;

pub use drive::{Drive, Waveform};
pub use lattice::{Chain, Ends, Losses, Pattern};
pub use law::Law;
pub use many::{run_each, run_many};
pub use peak::Peak;
pub(crate) use run::available_memory;
pub use run::{Accuracy, CHECK_FACTOR, EndTime, Record, Run, RunReport, RunWarning, Simulation};
pub use stepping::{Cost, Scheme, StepControl, Window};
