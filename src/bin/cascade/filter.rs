//! `cascade filter`: what of a field lies in a band, travels at a speed, or in a direction.

use std::io::Write;
use std::path::{Path, PathBuf};

use cascade::analyze::filtered;
use cascade::report::FieldFile;
use cascade::transform::{Passband, Travelling};
use cascade::{Error, Field};
use clap::{Args, ValueEnum};
use serde_json::json;

use crate::analyze::open_options;
use crate::args::Input;
use crate::chain_args::How;
use crate::failure::Failure;
use crate::parse;
use crate::terminal::number;

/// What `cascade filter` takes.
#[derive(Debug, Args)]
pub struct Filter {
    /// File with the field.
    pub field: PathBuf,

    /// File for what passes (.npz); by default the field's name with `-filtered.npz`, here.
    #[arg(long, short, value_name = "FILE")]
    pub out: Option<PathBuf>,

    /// Replace an existing result.
    #[arg(long)]
    pub force: bool,

    /// Frequencies that pass, in cycles per unit of time, both ends included; one may be left out.
    #[arg(long, value_name = "FROM:TO", value_parser = parse::interval)]
    pub frequency: Option<(f64, f64)>,

    /// Magnitudes of wavenumbers that pass, in rad per unit of length.
    #[arg(long, value_name = "FROM:TO", value_parser = parse::interval)]
    pub wavenumber: Option<(f64, f64)>,

    /// Phase velocities that pass, a fan in (f, k).
    #[arg(long, value_name = "FROM:TO", value_parser = parse::interval)]
    pub speed: Option<(f64, f64)>,

    /// Which waves pass by their direction.
    #[arg(long, value_enum)]
    pub towards: Option<Towards>,

    /// Extend the field by as many zeros again along both axes first; without them what leaves at
    /// one end enters at the other.
    #[arg(long)]
    pub pad: bool,

    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub how: How,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Towards {
    /// Waves that travel towards +x.
    PlusX,
    /// Waves that travel towards -x.
    MinusX,
    /// What has no direction: f or k is 0 or at a Nyquist limit.
    Nowhere,
}

/// Runs the command.
pub fn run(typed: Filter) -> Result<(), Failure> {
    crate::analyze::use_threads(typed.how.threads.map(usize::from))?;
    let band = typed.band()?;
    let out = typed
        .out
        .clone()
        .unwrap_or_else(|| default_out(&typed.field));
    // Before any work: could the result be written?
    FieldFile::check(&out, typed.force)?;
    let field = Field::open(&typed.field, &open_options(&typed.input, None))?;
    let found = filtered(&field, &band, typed.pad, None)?;
    field.check_unchanged()?;
    FieldFile::write(&out, typed.force, &found.field)?;
    let mut stdout = std::io::stdout().lock();
    if typed.how.json {
        let summary = json!({
            "file": out,
            "energy_before": found.energy_before,
            "energy_after": found.energy_after,
        });
        let text = serde_json::to_string_pretty(&summary).map_err(std::io::Error::from)?;
        writeln!(stdout, "{text}")?;
    } else if !typed.how.quiet {
        let share = found.energy_after / found.energy_before;
        writeln!(stdout, "{} of the energy passes", number(share))?;
        writeln!(stdout, "wrote {}; next: cascade analyze {0}", out.display())?;
    }
    Ok(())
}

impl Filter {
    fn band(&self) -> Result<Passband, Error> {
        let band = Passband {
            frequency: self.frequency.map(from_zero),
            wavenumber: self.wavenumber.map(from_zero),
            speed: self.speed.map(from_zero),
            travelling: match self.towards {
                None => Travelling::Anywhere,
                Some(Towards::PlusX) => Travelling::TowardPlusX,
                Some(Towards::MinusX) => Travelling::TowardMinusX,
                Some(Towards::Nowhere) => Travelling::Nowhere,
            },
        };
        if band == Passband::default() {
            return Err(Error::Request {
                option: "frequency",
                expected: "what passes: --frequency, --wavenumber, --speed, or --towards".into(),
                found: "none of them".into(),
            });
        }
        band.check()?;
        Ok(band)
    }
}

/// A lower end that is left out is 0, since bands are of magnitudes.
fn from_zero((from, to): (f64, f64)) -> (f64, f64) {
    match from {
        f64::NEG_INFINITY => (0.0, to),
        from => (from, to),
    }
}

fn default_out(field: &Path) -> PathBuf {
    let mut name = field.file_stem().unwrap_or("field".as_ref()).to_owned();
    name.push("-filtered.npz");
    name.into()
}
