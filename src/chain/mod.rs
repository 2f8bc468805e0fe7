//! The chain: from a scene to velocities, forces and the energy passed.

pub mod contact;
mod dispersion;
mod drive;
mod elliptic;
mod inside;
mod lattice;
mod law;
mod law_rows;
mod many;
mod path;
mod peak;
mod recorder;
mod result;
mod run;
pub mod scene;
mod simulation;
mod stepping;
mod warning;
mod watch;
mod work;

pub use dispersion::{NoBranches, UnitCell};
pub use drive::{Drive, Waveform};
pub use lattice::{Chain, Ends, Losses, Pattern};
pub use law::Law;
pub(crate) use many::runs_a_thread;
pub use many::{run_each, run_many};
pub(crate) use path::{Node, NodeState, NodeVisitor};
pub use peak::Peak;
pub(crate) use peak::largest;
pub use result::{Run, RunReport, RunWarning};
pub use run::CHECK_FACTOR;
pub use simulation::{Accuracy, EndTime, Record, Simulation};
pub use stepping::{Cost, Scheme, StepControl, SteppedSites};
pub(crate) use stepping::{Quintic, openings};
pub(crate) use watch::{ObservedRun, Resolution, SAMPLES_PER_STEP, Signal, StateView};
pub use work::Work;
