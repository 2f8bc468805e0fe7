//! What nearly every command speaks of.

pub use std::io::Write;
pub use std::path::{Path, PathBuf};

pub use clap::Args;
pub use wavecascade::observer::Observer;
pub use wavecascade::sheet::Describe;
pub use wavecascade::{Error, Field};

pub use crate::args::Input;
pub(crate) use crate::args::choice;
pub use crate::chain_args::How;
pub use crate::described::*;
pub use crate::failure::Failure;
pub use crate::progress::Progress;
pub use crate::show_args::AxisUnits;
pub use crate::summary::Summary;
pub(crate) use crate::{parse, terminal};
