//! `cascade filter`: the part of a field in a band, at a speed, or in a direction.

use serde_json::json;
use wavecascade::analyze::{Filtered, filtered};
use wavecascade::field::Axis;
use wavecascade::measure::{Frequency, Wavenumber, cycles_per};
use wavecascade::report::{FieldFile, percent};
use wavecascade::sheet::Warning;
use wavecascade::transform::{Passband, Travelling};

use crate::analyze::{named_after, open_options, own, print_notes};
use crate::prelude::*;
use crate::show_args::{Ends, ends};
use crate::terminal::{number, print_json};

/// What `cascade filter` takes.
#[derive(Debug, Args)]
pub struct Filter {
    /// File with the field.
    pub field: PathBuf,

    /// File for what passes: an archive (.npz), NetCDF (.nc), or an array (.npy) or table (.csv) with its
    /// axes in a sidecar beside it (field.npy.toml); by default the field's name with `-filtered.npz`, here.
    #[arg(long, short, value_name = "FILE")]
    pub out: Option<PathBuf>,

    /// Replace an existing result.
    #[arg(long)]
    pub force: bool,

    /// Frequencies that pass, in cycles per unit of time or with their unit (2kHz:6kHz), both ends included; one
    /// may be left out.
    #[arg(long, value_name = "FROM:TO", value_parser = ends::<Frequency>)]
    pub frequency: Option<Ends<Frequency>>,

    /// Magnitudes of wavenumbers that pass, in rad per unit of length or with their unit, likewise.
    #[arg(long, value_name = "FROM:TO", value_parser = ends::<Wavenumber>)]
    pub wavenumber: Option<Ends<Wavenumber>>,

    /// Phase velocities that pass, in units of length per unit of time, likewise: a fan in (f, k).
    #[arg(long, value_name = "FROM:TO", value_parser = parse::interval)]
    pub speed: Option<(f64, f64)>,

    /// Which waves pass by their direction.
    #[arg(long, value_enum)]
    pub towards: Option<Towards>,

    /// First double the field with zeros along both axes; without them the filtered field wraps
    /// around at its ends.
    #[arg(long)]
    pub pad: bool,

    /// Working memory, such as 500MB or 2GiB [default: the available memory]. The field is in memory three
    /// times, with `--pad` twelve times; where that does not fit, it is filtered in blocks, with the same
    /// bits, through scratch files of twice its size (`--pad`: three times) in the folder for temporary files.
    #[arg(long, value_name = "SIZE", value_parser = parse::bytes)]
    pub memory: Option<u64>,

    #[command(flatten)]
    pub how: How,
    #[command(flatten)]
    pub input: Input,
}

choice!(Towards => Travelling {
    /// Waves that travel towards +x.
    PlusX => Self::TowardPlusX,
    /// Waves that travel towards -x.
    MinusX => Self::TowardMinusX,
    /// What has no direction: f or k is 0 or at a Nyquist limit.
    Nowhere,
});

/// Runs the command.
pub fn run(typed: Filter) -> Result<(), Failure> {
    typed.check()?;
    let named = || named_after(&typed.field, "npy", "-filtered.npz");
    let out = typed.out.clone().unwrap_or_else(named);
    // Before any work: could the result be written?
    FieldFile::check(&out, typed.force)?;
    let progress = Progress::new(false);
    let field = Field::open(&typed.field, &open_options(&typed.input, typed.memory))?;
    let band = typed.band(&field)?;
    print_notes(&field, typed.how.quiet);
    let memory = typed.memory.map(|stated| stated - own(Some(stated)));
    let found = on_threads(typed.how.threads, || {
        filtered(&field, &band, typed.pad, memory, &progress)
    });
    let found = found.map_err(|error| error.of_file(&typed.field))?;
    field.check_unchanged()?;
    drop(field);
    typed.check_passes(&found)?;
    progress.begin_writing();
    FieldFile::write_observed(&out, typed.force, &found.field, &progress)?;
    progress.clear();
    let warnings = warnings(&typed, &found);
    if !typed.how.quiet {
        terminal::warn(&warnings);
    }
    if typed.how.json {
        return print_json(&json!({
            "file": out,
            "energy_before": found.energy_before,
            "energy_after": found.energy_after,
            "warnings": warnings,
        }));
    }
    if !typed.how.quiet {
        let passed = found.energy_after / found.energy_before;
        let passes = match found.energy_before > 0.0 {
            true => format!("{} of the energy passes", percent(passed)),
            false => "there is no energy to pass".into(),
        };
        let subject = subject_of(std::slice::from_ref(&typed.field));
        let mut summary = Summary::new(&subject, &passes);
        let out = out.display();
        summary.last(&format!("wrote {out}; next: cascade analyze {out}"));
        summary.print(typed.how.verbose)?;
    }
    Ok(())
}

/// Words for the units of both axes, and the options that state the steps that are counted.
fn units(field: &Field) -> (String, String, &'static str) {
    let (time, space) = (&field.time, &field.space);
    let counts = |axis: &Axis| axis.unit.is_none() && axis.step == 1.0;
    let unit_of = |axis: &Axis, counted: &str, stepped: &str| match &axis.unit {
        Some(unit) => unit.clone(),
        None if counts(axis) => counted.into(),
        None => stepped.into(),
    };
    let missing = match (counts(time), counts(space)) {
        (true, true) => "`--dt` and `--dx`",
        (true, false) => "`--dt`",
        (false, true) => "`--dx`",
        (false, false) => "",
    };
    let time = unit_of(time, "sample", "unit of time");
    (time, unit_of(space, "site", "unit of length"), missing)
}

/// What the user should know of the result, each with what to do.
pub fn warnings(typed: &Filter, found: &Filtered) -> Vec<Warning> {
    let (time_unit, space_unit, missing) = units(&found.field);
    let mut warnings = Vec::new();
    if typed.speed.is_some() && !missing.is_empty() {
        let message = format!("speeds are in {space_unit} per {time_unit}: steps are not stated");
        warnings.push(Warning::new(message, format!("state {missing}")));
    }
    if found.energy_before == 0.0 {
        let advice = "check the file and, of an archive, the member";
        warnings.push(Warning::new("the field is zero everywhere", advice));
    }
    warnings
}

impl Filter {
    /// What passes.
    pub fn band(&self, field: &Field) -> Result<Passband, Error> {
        let units = AxisUnits::of(field);
        let frequency = self.frequency.map(|ends| units.ends("frequency", ends));
        let wavenumber = self.wavenumber.map(|ends| units.ends("wavenumber", ends));
        let band = Passband {
            frequency: frequency.transpose()?.map(from_zero),
            wavenumber: wavenumber.transpose()?.map(from_zero),
            speed: self.speed.map(from_zero),
            travelling: self.towards.map_or(Travelling::Anywhere, Into::into),
        };
        band.check()?;
        Ok(band)
    }

    /// That something passes, before it is written.
    pub fn check_passes(&self, found: &Filtered) -> Result<(), Error> {
        // What passes of a field's energy by rounding alone.
        const NOTHING: f64 = 1e-28;
        if found.energy_before == 0.0 || found.energy_after > NOTHING * found.energy_before {
            return Ok(());
        }
        let (time_unit, space_unit, missing) = units(&found.field);
        let stated = match missing {
            "" => String::new(),
            missing => format!("; state {missing} if it has units"),
        };
        let option = match (self.frequency, self.wavenumber, self.speed) {
            (Some(_), ..) => "frequency",
            (_, Some(_), _) => "wavenumber",
            (.., Some(_)) => "speed",
            _ => "towards",
        };
        let (time, space) = (&found.field.time, &found.field.space);
        let [f, k] = [0.5 / time.step, std::f64::consts::PI / space.step].map(number);
        let per_time = cycles_per(&time_unit);
        let expected = format!(
            "bands in which the field has energy, of frequencies up to {f} {per_time} and wavenumbers up to {k} rad/{space_unit}{stated}"
        );
        let found = "some in which nothing passes";
        Err(Error::request(option, expected, found))
    }

    /// That a band or a direction is stated, before any work.
    pub fn check(&self) -> Result<(), Error> {
        let is_band = self.frequency.is_some() || self.wavenumber.is_some();
        let is_stated = is_band || self.speed.is_some() || self.towards.is_some();
        let expected = "what passes: --frequency, --wavenumber, --speed, or --towards";
        Error::require(is_stated, "frequency", expected, "none of them")
    }
}

/// A lower end that is left out is 0, since bands are of magnitudes.
fn from_zero((from, to): (f64, f64)) -> (f64, f64) {
    match from {
        f64::NEG_INFINITY => (0.0, to),
        from => (from, to),
    }
}
