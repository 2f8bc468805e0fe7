//! The chain: from a scene to velocities, forces and the energy passed.

pub mod contact;
mod drive;
mod elliptic;
mod lanes;
mod lattice;
mod law;
mod many;
mod recorder;
mod result;
mod root;
mod run;
mod simulation;
mod stepping;

pub use drive::{Drive, Waveform};
pub use lattice::{Chain, Ends, Losses, Pattern};
pub use law::Law;
pub use many::{run_each, run_many};
pub use result::{Run, RunReport, RunWarning};
pub use run::CHECK_FACTOR;
pub use simulation::{Accuracy, EndTime, Record, Simulation};
pub use stepping::{Cost, Scheme, StepControl, Window};
