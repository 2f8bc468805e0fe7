//! What all commands on estimates share: one or several fields, one library call, a directory of results.

pub mod averages;
pub mod bicoherence;
pub mod coherence;
pub mod increments;
pub mod modes;
pub mod parts;
pub mod ridges;
pub mod slope;
pub mod spacetime;
pub mod spectrum;
pub mod transfer;

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use wavecascade::field::{FileState, OpenOptions};
use wavecascade::observer::Observer;
use wavecascade::prepare::{Examined, channel_findings};
use wavecascade::report::{Provenance, ResultDirectory};
use wavecascade::sheet::Describe;
use wavecascade::{Error, Field};

use crate::analyze::{named_after, open_options, print_notes, use_threads};
use crate::args::Input;
use crate::budget::command;
use crate::chain_args::How;
use crate::described::Described;
use crate::failure::Failure;
use crate::fields::expanded;
use crate::figure_args::{Drawing, FigureArgs};
use crate::parse;
use crate::progress::Progress;

/// The commands on estimates of fields.
#[derive(Debug, Subcommand)]
pub enum EstimateCommand {
    /// Compare all sites with a reference: coherence, delay, velocity.
    ///
    /// Averaged over segments of the record, over orthogonal tapers, or over repeated records (several
    /// files). Each number has its level of significance or its error; the segments of one transient are not
    /// independent, and then none is stated.
    #[command(after_help = "Example: cascade coherence scan.npz --reference 0 --segment 512")]
    Coherence(Box<coherence::Coherence>),
    /// Read dispersion off S(k, f): branches, velocities, fitted laws.
    ///
    /// Peaks along k at each frequency, or along f at each wavenumber, that stand above the noise are joined to
    /// branches and located between bins. Each place and each velocity has its error.
    #[command(after_help = "Example: cascade ridges scan.npz")]
    Ridges(Box<ridges::Ridges>),
    /// Find motions that are coherent along x at a frequency (SPOD).
    ///
    /// Spectral proper orthogonal decomposition, averaged over segments of the record, over orthogonal tapers, or
    /// over repeated records (several files). Each eigenvalue has its interval, and each mode that is a wave its
    /// wavenumber.
    #[command(after_help = "Example: cascade modes scan.npz --segment 512")]
    Modes(Box<modes::Modes>),
    /// Measure how differences grow with scale: structure functions.
    ///
    /// Increments over separations along x and lags in time, orders 1 to 6, the third with its sign, exponents
    /// over a stated band, histograms. Intervals are over shots, or over parts of a stationary record; missing
    /// samples are left out.
    #[command(after_help = "Example: cascade increments scan.npz")]
    Increments(Box<increments::Increments>),
    /// Fit the slope of a spectrum over a band, and find its breaks.
    ///
    /// Least squares in double logarithmic scales over wavenumbers or frequencies; the interval is that of the
    /// regression, or over shots if there are several. Along x, the slope of each frame of the times, and the time
    /// at which a steepening field forms a shock.
    #[command(after_help = "Example: cascade slope scan.npz --band 100Hz:2kHz")]
    Slope(Box<slope::Slope>),
    /// Find frequencies that are coupled with their sum.
    ///
    /// Averaged over segments of the record or over repeated records (several files), with levels of
    /// significance for one triple of frequencies and for all of them. Bicoherence shows coupling, not which
    /// frequency feeds which; `--transfer` fits what each gains between two sites, linearly and from pairs of others.
    #[command(after_help = "Example: cascade bicoherence scan.npz --site 12 --segment 256")]
    Bicoherence(Box<bicoherence::BicoherenceArgs>),
    /// Estimate power spectral densities, and find lines.
    ///
    /// Averaged over segments, over orthogonal tapers (Thomson's method, with adaptive weights), or over
    /// repeated records (several files). Each value has its degrees of freedom and two intervals, by the chi-square
    /// distribution and by a jackknife; tapers give a test for lines. A single transient has no interval.
    #[command(after_help = "Example: cascade spectrum scan.npz --segment 512")]
    Spectrum(Box<spectrum::Spectrum>),
}

/// What is done with the arguments of an estimate, whatever their type.
pub trait OnEstimate {
    type Done;

    fn of<T: Typed + Sync>(self, typed: T) -> Self::Done
    where
        T::Found: Send + Sync + 'static;
}

impl EstimateCommand {
    /// The one place that lists the types of arguments.
    pub fn with<V: OnEstimate>(self, visitor: V) -> V::Done {
        match self {
            EstimateCommand::Bicoherence(typed) => visitor.of(*typed),
            EstimateCommand::Coherence(typed) => visitor.of(*typed),
            EstimateCommand::Increments(typed) => visitor.of(*typed),
            EstimateCommand::Modes(typed) => visitor.of(*typed),
            EstimateCommand::Ridges(typed) => visitor.of(*typed),
            EstimateCommand::Slope(typed) => visitor.of(*typed),
            EstimateCommand::Spectrum(typed) if typed.is_both() => {
                visitor.of(spacetime::SpaceTime(*typed))
            }
            EstimateCommand::Spectrum(typed) => visitor.of(*typed),
        }
    }

    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        struct Run;
        impl OnEstimate for Run {
            type Done = Result<(), Failure>;

            fn of<T: Typed>(self, typed: T) -> Self::Done {
                typed.run()
            }
        }
        self.with(Run)
    }
}

/// Where the result goes, and how it is made.
#[derive(Debug, Args)]
pub struct EstimateArgs {
    /// File with the field; several, or patterns such as `'shot*.npy'`, are repeated records (shots) of the
    /// same sites, which are averaged.
    #[arg(required = true, value_name = "FIELD")]
    pub fields: Vec<PathBuf>,

    /// Directory for the results; by default the field's name with the command's, here.
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Replace an existing result.
    #[arg(long)]
    pub force: bool,

    /// Working memory, such as 500MB or 2GiB [default: half of the free memory].
    #[arg(long, value_name = "SIZE", value_parser = parse::bytes)]
    pub memory: Option<u64>,

    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub figures: FigureArgs,
    #[command(flatten)]
    pub how: How,
}

impl EstimateArgs {
    /// Worker threads; `None`: one a core.
    pub fn threads(&self) -> Option<usize> {
        self.how.threads.map(usize::from)
    }
}

/// What is typed of a command on an estimate: for the program, and for functions on arrays.
pub trait Typed {
    type Found: Describe;

    /// Name of the command: that of the file of arrays, and the end of the default directory.
    const COMMAND: &'static str;

    fn shared(&self) -> &EstimateArgs;

    /// What makes the estimate of the opened fields.
    ///
    /// # Errors
    /// For what is missing, or contradicts itself, whatever the fields are.
    fn computation(&self) -> Result<impl Computation<Self::Found>, Error>;

    /// Runs the command.
    fn run(&self) -> Result<(), Failure>
    where
        Self: Sized,
    {
        run(self)
    }

    /// Writes what stands beside the arrays to new files of `directory`.
    fn write_beside(&self, _found: &Self::Found, _directory: &Path) -> Result<(), Error> {
        Ok(())
    }
}

/// Makes an estimate of opened fields.
pub trait Computation<E>: FnOnce(&[&Field], &dyn Observer) -> Result<E, Error> {}

impl<E, F: FnOnce(&[&Field], &dyn Observer) -> Result<E, Error>> Computation<E> for F {}

/// Where a result goes, and what it is called.
pub struct Target<'a> {
    pub out: &'a Path,
    /// In titles.
    pub name: &'a str,
    /// Of the sentence that answers: the file.
    pub subject: &'a str,
    pub provenance: &'a Provenance,
}

/// The name of the first file, and how many there are beside it.
pub fn subject_of(paths: &[PathBuf]) -> String {
    let Some((first, others)) = paths.split_first() else {
        return "field".into();
    };
    let name = first.file_name().unwrap_or(first.as_os_str());
    let name = name.to_string_lossy().into_owned();
    match others.len() {
        0 => name,
        others => format!("{name} and {others} more"),
    }
}

/// Opens the fields, makes the estimate, and publishes it.
pub fn run<T: Typed>(command_typed: &T) -> Result<(), Failure> {
    let compute = command_typed.computation()?;
    let typed = command_typed.shared();
    let drawing = typed.figures.drawing()?;
    let ending = format!("-{}", T::COMMAND);
    let default = |first: &Path| named_after(first, "npy", &ending);
    let (paths, out) = begin(typed, default)?;
    let progress = Progress::new(!typed.how.quiet && std::io::stderr().is_terminal());
    let fields = open(&paths, typed, true)?;
    let all: Vec<&Field> = fields.iter().collect();
    let found = compute(&all, &progress).map_err(|error| error.of_file(&paths[0]))?;
    let found = Examined {
        found,
        channels: channel_findings(all[0], &progress)?,
    };
    let opened: Vec<FileState> = fields.iter().filter_map(Field::file_state).collect();
    let hash = fields[0].content_hash.clone();
    drop(fields);
    progress.begin_writing();
    opened.iter().try_for_each(FileState::check)?;
    let input = paths[0].display().to_string();
    let provenance = Provenance::new(command(), Some(input), hash);
    let name = paths[0].file_stem().unwrap_or_default().to_string_lossy();
    let target = Target {
        out: &out,
        name: &name,
        subject: &subject_of(&paths),
        provenance: &provenance,
    };
    publish(command_typed, &found, &target, &drawing, &progress)
}

/// The files of the fields, and the directory of the result, which is checked before any work.
pub fn begin(
    typed: &EstimateArgs,
    default: impl FnOnce(&Path) -> PathBuf,
) -> Result<(Vec<PathBuf>, PathBuf), Failure> {
    let paths = expanded(&typed.fields)?;
    use_threads(typed.threads())?;
    let out = typed.out.clone().unwrap_or_else(|| default(&paths[0]));
    drop(ResultDirectory::create(&out, typed.force)?);
    Ok((paths, out))
}

/// The fields, hashed if so.
pub fn open(paths: &[PathBuf], typed: &EstimateArgs, hash: bool) -> Result<Vec<Field>, Failure> {
    let options = OpenOptions {
        hash,
        ..open_options(&typed.input, typed.memory)
    };
    let mut fields = Vec::new();
    for path in paths {
        let field = Field::open(path, &options)?;
        print_notes(&field, typed.how.quiet);
        fields.push(field);
    }
    Ok(fields)
}

/// Writes what was found to the directory of the target, and prints it.
pub fn publish<T: Typed>(
    command_typed: &T,
    found: &Examined<T::Found>,
    target: &Target<'_>,
    drawing: &Drawing,
    progress: &Progress,
) -> Result<(), Failure> {
    let typed = command_typed.shared();
    let sheet = found.describe();
    let described = Described {
        found,
        sheet: &sheet,
        name: target.name,
        provenance: target.provenance,
    };
    let directory = ResultDirectory::create(target.out, typed.force)?;
    let main = described.publish((directory, T::COMMAND), drawing, progress, |directory| {
        command_typed.write_beside(&found.found, directory)
    })?;
    described.tell(target.subject, &typed.how, Some(&main))?;
    drawing.present(&main)
}
