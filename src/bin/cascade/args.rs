//! What the user types.

use std::ops::Range;
use std::time::Duration;

use clap::{Parser, Subcommand, ValueEnum};
use wavecascade::field::{At, Resample, Selection};
use wavecascade::measure::{Frequency, Length, Measure, Speed, Time, Wavenumber};
use wavecascade::prepare::Window;

use crate::chain_args::{SceneCommand, Simulate, SweepCommand};
use crate::estimates::EstimateCommand;
use crate::figure_args::ColorArgs;
use crate::prelude::*;
use crate::scan_args::ScanArgs;
use crate::show_args::{Ends, ShowArgs, ends};

/// Where the energy of a velocity field v(t, x) goes: spectra, redistribution, direction.
#[derive(Debug, Parser)]
#[command(name = "cascade", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,

    /// End the command after this time, such as 90, 90s or 20min, as an interrupt does: what is known of
    /// several runs or fields is kept. Exit code 124.
    #[arg(long, global = true, value_name = "TIME", value_parser = parse::duration)]
    pub max_time: Option<Duration>,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Find where the energy of a field goes: from a file to a report.
    ///
    /// FIELD holds samples v(t, x): NumPy (`.npy`, `.npz`), a table of text (`.csv`, `.tsv`, `.txt`),
    /// HDF5, NetCDF, MATLAB, SEG-Y, UFF 58, TDMS, miniSEED or LAMMPS dumps; `cascade inspect` lists what a file
    /// holds. An array that does not say which axis is time needs `--layout`. Axes and
    /// units come from options,
    /// from a sidecar file, field.toml for field.npy (keys layout, dt, rate, dx, t0, x0, time_unit,
    /// space_unit, quantity, unit, dispersion), or from the file; an axis without a stated step counts samples
    /// or sites.
    #[command(after_help = "Example: cascade analyze scan.npy --dt 10us --dx 2mm --unit m/s")]
    #[command(alias = "analyse")]
    Analyze(Box<Analyze>),
    /// List what is in a file, and what would be taken for the field.
    ///
    /// Arrays with their dimensions, coordinates, types and units; how the field would be read with
    /// the options given, or what is missing; and the command that analyzes it.
    #[command(after_help = "Example: cascade inspect scan.h5")]
    Inspect(Box<crate::inspect::Inspect>),
    /// Filter a field by frequency, wavenumber, speed or direction.
    ///
    /// The field is transformed in time and space, multiplied by 1 or 0, and transformed back. The
    /// result is a field with the same axes. Adjacent bands sum to the field, to rounding.
    #[command(after_help = "Example: cascade filter scan.npz --frequency 1kHz:5kHz --out band.npz")]
    Filter(Box<crate::filter::Filter>),
    #[command(flatten)]
    Estimate(EstimateCommand),
    /// Find which wavenumbers of a run feed which, by triads.
    ///
    /// Where the force is quadratic (springs with alpha, precompressed contacts to second order), energy is exchanged in triads k = p + q, each of which keeps its energy. The result has what
    /// each k gained with each partner, the flux past k, and the share of it that triads of near wavenumbers carry.
    #[command(after_help = "Example: cascade triads fput.npz")]
    Triads(Box<crate::triads::Triads>),
    /// Convert a field to another format, with its axes and units.
    ///
    /// IN is anything that `cascade analyze` reads, with the same options: one file, or with
    /// `--position-from` all files of a scan. The extension of OUT chooses
    /// the format: NetCDF (.nc), which xarray opens, NumPy (.npz, or .npy with a sidecar), or a table
    /// (.csv with a sidecar). Samples in single precision stay so; a field larger than memory passes in
    /// blocks.
    #[command(after_help = "Example: cascade convert scan.h5 scan.nc --dx 2mm")]
    Convert(Box<crate::convert::Convert>),
    /// Follow the energy of a simulated chain: balances that close.
    ///
    /// RUN is a run file of `cascade simulate` with displacements. Four budgets: site by site in real
    /// space, from low to high wavenumber in time, by frequency through each contact, and out of the
    /// scales larger than l. Each states by how much its balance over time fails to close.
    #[command(after_help = "Example: cascade budget dimer.npz")]
    Budget(Box<crate::budget::Budget>),
    /// Compare a measured field with a run, or the budgets of two runs.
    ///
    /// Of a field and a run, or its scene: arrivals, largest values, energies, correlation and what is left by body and by
    /// frequency, attenuation, what moved; where they agree, and where they part, told from the noise. Of two runs: their
    /// budgets on one page.
    #[command(after_help = "Example: cascade compare records.csv run.npz --bodies 2,4,6")]
    Compare(Box<crate::compare::Compare>),
    /// Simulate a chain: from a scene to a run file.
    ///
    /// SCENE is a text file (TOML) that `cascade scene` explains. Every key is an option too, which
    /// overrides the file: `stiffness_ratio = 4.9` and `--stiffness-ratio 4.9`. The run file
    /// (`.npz`) holds time, velocity, displacement, force, energy passed, masses, coefficients and
    /// the scene; `cascade analyze` reads it with all axes known. With `--out run.nc` it is a NetCDF file of the
    /// same arrays, which xarray opens, too.
    #[command(
        after_help = "Example: cascade simulate dimer.toml --stiffness-ratio 2.398 --out dispersive.npz"
    )]
    Simulate(Box<Simulate>),
    /// Run chains that differ in a few keys of a scene, to one table.
    ///
    /// The members are all combinations of the varied values. Each result is saved in the directory
    /// at once; after an interrupt or kill, the same command resumes. The table (`table.csv`) is
    /// written when all members are done, one row for each: largest forces (located between
    /// samples), energies, estimated errors.
    #[command(after_help = "Example: cascade sweep dimer.toml --vary stiffness_ratio=1:8:64")]
    Sweep(Box<SweepCommand>),
    /// Print a commented scene to start from, or describe a scene.
    Scene(SceneCommand),
    /// Compute the ratios at which a dimer carries localized waves.
    ///
    /// A table of orders: the exact ratio with its error, the asymptotic estimate on the exact and
    /// on the fitted slow wave, the published numbers; with `--direct` the ratios at which the
    /// pulses of struck chains lose least and most. The row of an order that cannot be resolved
    /// gives the reason, and the exit code is 1. `--profile` and `--launch` work on one wave.
    #[command(after_help = "Example: cascade localize --order 1..5")]
    Localize(Box<crate::localize::Localize>),
    /// Find how long a struck chain must be to attenuate its pulse.
    ///
    /// SCENES, `--angles` or `--ratios` name the chains that are compared, each with the homogeneous chain beside it:
    /// largest force and velocity, energy passed and left behind, share of the high band, width, arrival. With
    /// `--against KEY` the pulse is followed to the wall against any key of one scene: force, time of flight, mean speed;
    /// the extremes of the force are located by further runs, and values that carry localized waves are marked. Values
    /// are located inside the steps of the simulation, so they depend on no sampling, and have error estimates. With
    /// `--out`, results are saved at once, and the same command resumes after an interrupt.
    #[command(
        after_help = "Example: cascade attenuate dimer.toml --against stiffness_ratio=1:8:32"
    )]
    Attenuate(Box<crate::attenuate::Attenuate>),
    /// Choose where, how long and how fast to measure a chain.
    ///
    /// The N bodies whose records determine keys of SCENE best, with stated noise: by the Fisher information of runs, at the
    /// values of the scene. Errors of the keys are compared with those of as many evenly spaced bodies and of all. The
    /// shortest duration and the slowest sampling that tell as much are said, and what stays undetermined.
    #[command(
        after_help = "Example: cascade plan dimer.toml --free stiffness_ratio,striker_velocity --sensors 3 --noise 2%"
    )]
    Plan(Box<crate::plan::PlanArgs>),
    /// Find the chain that did what was measured, with intervals.
    ///
    /// Keys of SCENE are found by least squares of the records of FIELD less those of its run, from several starts.
    /// Intervals count the samples by the correlation of what is left. Whether noise explains what is left is tested, and
    /// said first. With the results comes fitted.toml, the scene with the fitted values.
    #[command(after_help = "Example: cascade fit records.csv chain.toml --free young=50GPa..90GPa")]
    Fit(Box<crate::fit::Fit>),
    /// Find the chain that does most of what is wanted, or least.
    ///
    /// Keys of SCENE are searched within bounds, or among values, for the least or largest measure of its run, under limits
    /// and with the tolerances of their making. As many random designs are run beside the search, and told if they win.
    /// With the results comes design.toml, the scene found.
    #[command(
        after_help = "Example: cascade design quartz_cylinders.toml --free angle=2..90 --minimize peak_force_last"
    )]
    Design(Box<crate::design::DesignArgs>),
    /// List fields and scenes to try the program on, or write one here.
    Examples(crate::examples::Examples),
    /// Print completions for a shell.
    Completions { shell: clap_complete::Shell },
    /// Print the manual page of the program, or of a command.
    Man {
        /// Name of a command.
        page: Option<String>,
    },
}

impl Command {
    /// Of a command whose result is described, how it is made and where it goes.
    pub fn described(&self) -> Option<(&dyn Describing, &ResultArgs)> {
        Some(match self {
            Command::Analyze(typed) => (&**typed, &typed.result),
            Command::Attenuate(typed) => (&**typed, &typed.result),
            Command::Budget(typed) => (&**typed, &typed.result),
            Command::Compare(typed) => (&**typed, &typed.result),
            Command::Design(typed) => (&**typed, &typed.result),
            Command::Estimate(typed) => (typed, &typed.typed().2.result),
            Command::Fit(typed) => (&**typed, &typed.result),
            Command::Localize(typed) => (&**typed, &typed.result),
            Command::Plan(typed) => (&**typed, &typed.result),
            Command::Triads(typed) => (&**typed, &typed.result),
            _ => return None,
        })
    }
}

/// What `cascade analyze` takes.
#[derive(Debug, Args)]
#[command(mut_arg("out", |arg| arg.help(OUT)))]
pub struct Analyze {
    /// File with the field; several, or patterns such as `'*.npy'`, are analyzed one after the
    /// other, or with `--position-from` as one field.
    #[arg(required = true, value_name = "FIELD")]
    pub fields: Vec<PathBuf>,

    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub scan: ScanArgs,
    #[command(flatten)]
    pub preparation: Preparation,
    #[command(flatten)]
    pub spectra: SpectraArgs,
    #[command(flatten)]
    pub bands: Bands,
    #[command(flatten)]
    pub short_time: ShortTimeArgs,
    #[command(flatten)]
    pub dispersion: DispersionArgs,
    #[command(flatten)]
    pub work: WorkArgs,
    #[command(flatten)]
    pub show: ShowArgs,
    /// File of the arrays: spectra.npz for NumPy, or spectra.nc for `xarray.open_dataset`, with named
    /// dimensions, coordinates and units.
    #[arg(long, value_enum, default_value_t = FormatArg::Npz, help_heading = "Output")]
    pub format: FormatArg,
    #[command(flatten)]
    pub result: ResultArgs,
    #[command(flatten)]
    pub colors: ColorArgs,
}

const OUT: &str = "Directory for the results; by default the field's name with `-cascade`, here (field-cascade for \
    field.npy, field.npz-cascade for field.npz). Of several fields each has a directory of its own in it, beside \
    index.html and headlines.csv; by default fields-cascade";

#[derive(Debug, Default, PartialEq, Args)]
#[command(next_help_heading = "The field and its axes")]
pub struct Input {
    /// Order of the axes in the file [default: as the lengths of coordinates have it, else
    /// time-site].
    #[arg(long, value_enum)]
    pub layout: Option<LayoutArg>,
    /// Time step, such as 1e-5 in the unit of time, or 10us.
    #[arg(long, value_name = "STEP", value_parser = parse::step::<Time>)]
    pub dt: Option<Measure<Time>>,
    /// Sampling rate in place of the time step, such as 1e5 per unit of time, or 100kHz.
    #[arg(long, visible_alias = "fs", value_name = "RATE", value_parser = parse::step::<Frequency>, conflicts_with = "dt")]
    pub rate: Option<Measure<Frequency>>,
    /// Distance between neighbouring sites, such as 0.002 in the unit of length, or 2mm.
    #[arg(long, value_name = "STEP", value_parser = parse::step::<Length>)]
    pub dx: Option<Measure<Length>>,
    /// Time of the first sample, as for `--dt`.
    #[arg(long, value_name = "TIME", value_parser = parse::origin::<Time>)]
    pub t0: Option<Measure<Time>>,
    /// Position of the first site, as for `--dx`.
    #[arg(long, value_name = "PLACE", value_parser = parse::origin::<Length>)]
    pub x0: Option<Measure<Length>>,
    /// Unit of time, such as s or ms [default: s where a step states a unit].
    #[arg(long, value_name = "UNIT")]
    pub time_unit: Option<String>,
    /// Unit of length, such as m or mm [default: m where a step states a unit].
    #[arg(long, value_name = "UNIT")]
    pub space_unit: Option<String>,
    /// Unit of the samples, such as m/s.
    #[arg(long)]
    pub unit: Option<String>,
    /// What the samples measure [default: velocity].
    #[arg(long, value_enum)]
    pub quantity: Option<QuantityArg>,
    /// Array of a file that holds several, by its path or its name [default: velocity, v, or the
    /// only one of two dimensions]. `cascade inspect` lists them.
    #[arg(long, alias = "member", value_name = "PATH")]
    pub variable: Option<String>,
    /// Dimension of that array with the times: its name, or its number from 0 [default: by names and
    /// units].
    #[arg(long, value_name = "NAME")]
    pub time_dim: Option<String>,
    /// Dimension with the sites, likewise.
    #[arg(long, value_name = "NAME")]
    pub space_dim: Option<String>,
    /// Where a further dimension is taken, such as y=0.3, y=3mm, or y=#2 for its third value. May be
    /// repeated.
    #[arg(long, value_name = "NAME=VALUE", value_parser = parse::at)]
    pub at: Vec<At>,
    /// Part of an axis that is read, both ends included, such as time=0.1:0.4 or x=20mm:; one end may
    /// be left out. May be repeated.
    #[arg(long, value_name = "AXIS=FROM:TO", value_parser = parse::selection)]
    pub select: Vec<Selection>,
    /// Share of a step by which listed coordinates may deviate from even ones; more is an error
    /// [default: 1%].
    #[arg(long, value_name = "SHARE", value_parser = parse::share)]
    pub jitter: Option<f64>,
    /// How samples at coordinates that deviate more are brought to even ones: nearest, linear or cubic (a
    /// spline), of one axis as in time=cubic,space=linear [default: none, which refuses them].
    #[arg(long, value_name = "METHOD", value_parser = parse::resample)]
    pub resample: Option<Resample>,
    /// What becomes of traces of one file that begin at different times [default: refuse].
    #[arg(long, value_enum)]
    pub delays: Option<DelaysArg>,
    /// Whether the first line of a table names its columns [default: detect].
    #[arg(long, value_enum)]
    pub header: Option<HeaderArg>,
    /// Column of a table with the times: its number from 0, its name, or `none` if all columns hold
    /// samples [default: the one that a header names, else the first if it rises evenly].
    #[arg(long, value_name = "COLUMN")]
    pub time_column: Option<String>,
    /// How the file is read: mapped while it is analyzed, or copied to memory first, which a file
    /// that other programs may change needs [default: map].
    #[arg(long, value_enum)]
    pub read: Option<ReadArg>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Preparation, once, before all transforms")]
pub struct Preparation {
    /// Sites to analyze, by index, the end excluded [default: all].
    #[arg(long, value_name = "FIRST:END", value_parser = parse::site_range)]
    pub sites: Option<Range<usize>>,
    /// Sites to leave out, by index: their spectra are undefined, and spectra along space are not computed.
    #[arg(long, value_name = "SITE,..", value_delimiter = ',')]
    pub without_sites: Vec<usize>,
    /// Times to analyze, in units of time or with their own (1ms:20ms), both ends included; one may be left out [default: all].
    #[arg(long, value_name = "FROM:TO", value_parser = ends::<Time>, conflicts_with = "until_arrival")]
    pub times: Option<Ends<Time>>,
    /// End the record before the first arrival at the last site, so that reflections stay out.
    #[arg(long)]
    pub until_arrival: bool,
    /// What counts as an arrival, as a share of the field's largest amplitude.
    #[arg(
        long,
        value_name = "SHARE",
        default_value_t = 0.01,
        requires = "until_arrival"
    )]
    pub arrival_threshold: f64,
    /// What to do with samples that are not finite.
    #[arg(long, value_enum, default_value_t = GapsArg::Refuse)]
    pub gaps: GapsArg,
    /// Remove the mean of all samples.
    #[arg(long, value_enum, default_value_t = FieldDetrendArg::None, value_name = "WHAT")]
    pub detrend_field: FieldDetrendArg,
    /// Remove from each instant's profile; the mean is the common mode.
    #[arg(long, value_enum, default_value_t = DetrendArg::None, value_name = "WHAT")]
    pub detrend_space: DetrendArg,
    /// Remove from each site's record, and from each segment of Welch's method.
    #[arg(long, value_enum, default_value_t = DetrendArg::None, value_name = "WHAT")]
    pub detrend_time: DetrendArg,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Spectra")]
pub struct SpectraArgs {
    /// Taper along time: none, hann, hamming, blackman-harris, flat-top, tukey[:TAPER],
    /// kaiser[:BETA], dpss[:NW].
    #[arg(long, value_name = "WINDOW", default_value_t = Window::None)]
    pub window_time: Window,
    /// Taper along space; the same choice.
    #[arg(long, value_name = "WINDOW", default_value_t = Window::None)]
    pub window_space: Window,
    /// Energy spectral density, power spectral density, or power spectrum.
    #[arg(long, value_enum, default_value_t = ScalingArg::Energy)]
    pub scaling: ScalingArg,
    /// Welch's method: average over segments of this many samples [default: one segment, the whole
    /// record].
    #[arg(long, value_name = "SAMPLES")]
    pub segment: Option<usize>,
    /// Overlap of segments, in samples or as a share [default: 50%].
    #[arg(long, value_name = "SAMPLES|SHARE", value_parser = parse::overlap, requires = "segment")]
    pub overlap: Option<parse::Overlap>,
    /// Pad records (or segments) with zeros to this many samples [default: no padding].
    #[arg(long, value_name = "SAMPLES")]
    pub pad_time: Option<usize>,
    /// Pad profiles with zeros to this many sites [default: no padding].
    #[arg(long, value_name = "SITES")]
    pub pad_space: Option<usize>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Low and high band, directions")]
pub struct Bands {
    /// Site, by index, whose 90 % energy frequency is the upper edge of the low band [default: for a run, the
    /// first body behind the struck or driven one; for a field, the first site with a tenth of the
    /// largest energy].
    #[arg(long, value_name = "SITE", conflicts_with = "band_edge_frequency")]
    pub reference_site: Option<usize>,
    /// Time, in units of time, whose 90 % energy wavenumber is the upper edge of the low band [default: for a run,
    /// when the front has passed ten bodies, or a quarter of the chain; for a field, the first time
    /// with a tenth of the largest energy].
    #[arg(long, value_name = "TIME", value_parser = parse::origin::<Time>, conflicts_with = "band_edge_wavenumber")]
    pub reference_time: Option<Measure<Time>>,
    /// Upper edge of the low band, in cycles per unit of time, or with its unit (2kHz).
    #[arg(long, value_name = "FREQUENCY", value_parser = parse::origin::<Frequency>)]
    pub band_edge_frequency: Option<Measure<Frequency>>,
    /// Upper edge of the low band, in rad per unit of length, or with its unit (50rad/m).
    #[arg(long, value_name = "WAVENUMBER", value_parser = parse::origin::<Wavenumber>)]
    pub band_edge_wavenumber: Option<Measure<Wavenumber>>,
    /// Length, in units of time, of the windows from each site's arrival on, over which what moved along x is found
    /// [default: ten widths of the pulse's envelope].
    #[arg(long, value_name = "TIME", value_parser = parse::step::<Time>)]
    pub front_window: Option<Measure<Time>>,
    /// Moved shares of the energy below this count as none [default: 0.05].
    #[arg(long, value_name = "SHARE", value_parser = parse::positive)]
    pub least_move: Option<f64>,
    /// The sites are those of a periodic box: the last one is beside the first, and all of the motion is inside. What
    /// moves is then told of wavenumbers alone.
    #[arg(long, conflicts_with_all = ["sites", "without_sites"])]
    pub periodic: bool,
    /// Root mean square of the noise in the samples, in their unit, or of a velocity with its own (1mm/s), where it is
    /// known: sites and times whose energy is less than twice the noise's are undefined [default: not known].
    #[arg(long, value_name = "RMS", value_parser = parse::step::<Speed>)]
    pub noise: Option<Measure<Speed>>,
    /// Subtract the noise of each site, found before the motion arrives or where the spectrum is flat, from spectra
    /// along time; spectra along both axes are not computed.
    #[arg(long, conflicts_with = "noise")]
    pub subtract_noise: bool,
    /// Frequencies, in cycles per unit of time, over which the shares of each direction are taken
    /// [default: all].
    #[arg(long, value_name = "FROM:TO", value_parser = ends::<Frequency>)]
    pub direction_band: Option<Ends<Frequency>>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Short-time spectra")]
pub struct ShortTimeArgs {
    /// Sites to follow in time, by index [default: the first, the middle and the last].
    #[arg(long, value_name = "SITE", value_delimiter = ',')]
    pub short_time_sites: Vec<usize>,
    /// Times to follow along x, in units of time, or with their own (10ms) [default: none].
    #[arg(long, value_name = "TIME", value_delimiter = ',', value_parser = parse::origin::<Time>)]
    pub short_time_times: Vec<Measure<Time>>,
    /// Samples a segment along time [default: a power of two near an eighth of the record].
    #[arg(long, value_name = "SAMPLES")]
    pub short_time_segment: Option<usize>,
    /// Samples from one segment to the next [default: a quarter of the segment].
    #[arg(long, value_name = "SAMPLES")]
    pub short_time_hop: Option<usize>,
    /// Sites a segment along x [default: a power of two near an eighth of the sites].
    #[arg(long, value_name = "SITES", requires = "short_time_times")]
    pub short_space_segment: Option<usize>,
    /// Sites from one segment along x to the next [default: a quarter of the segment].
    #[arg(long, value_name = "SITES", requires = "short_time_times")]
    pub short_space_hop: Option<usize>,
    /// Taper of the segments.
    #[arg(long, value_name = "WINDOW", default_value_t = Window::USUAL)]
    pub short_time_window: Window,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Dispersion relations drawn over S(k, f)")]
pub struct DispersionArgs {
    /// `auto`, `none`, `monatomic:c=1,m=1`, `diatomic:c1=1,c2=2,m1=1,m2=1`, a table
    /// (`curve.csv`, columns k and omega or f), or a formula for omega, in rad per unit of time,
    /// of k, in rad per unit of length: `2*sqrt(c/m)*abs(sin(k*a/2)); c=1, m=1`. May be repeated
    /// [default: auto, which is the branches of a run's lattice about its static state, or what
    /// the field's sidecar states].
    #[arg(long, value_name = "RELATION", allow_hyphen_values = true)]
    pub dispersion: Vec<String>,
    /// Constants of the formulas; a is the distance of the sites, and c and m of a run of equal
    /// bodies are its own, unless they are given.
    #[arg(long, value_name = "NAME=NUMBER,...", requires = "dispersion")]
    pub dispersion_constants: Option<String>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "The work")]
pub struct WorkArgs {
    /// Compute these results alone [default: all].
    #[arg(long, value_enum, value_delimiter = ',', value_name = "RESULT")]
    pub only: Vec<ResultArg>,
    /// Print what would be computed, its memory and its transforms, and stop.
    #[arg(long)]
    pub plan: bool,
    /// Working memory, such as 500MB or 2GiB; a larger field streams through in blocks [default:
    /// half of the available memory].
    #[arg(long, value_name = "SIZE", value_parser = parse::bytes)]
    pub memory: Option<u64>,
    /// Number type of transforms and arrays.
    #[arg(long, value_enum, default_value_t = PrecisionArg::F64)]
    pub precision: PrecisionArg,
}

/// A choice of the library under the name that is typed; of the same name there where nothing else is said.
macro_rules! choice {
    ($name:ident => $target:ty { $($(#[$doc:meta])* $variant:ident $(=> $value:expr)?),+ $(,)? }) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
        pub enum $name { $($(#[$doc])* $variant),+ }

        impl From<$name> for $target {
            fn from(typed: $name) -> Self {
                match typed { $($name::$variant => $crate::args::choice!(@ $variant $($value)?)),+ }
            }
        }
    };
    (@ $variant:ident) => { Self::$variant };
    (@ $variant:ident $value:expr) => { $value };
}

pub(crate) use choice;

choice!(LayoutArg => wavecascade::field::Layout {
    /// The first index counts times.
    TimeSite,
    /// The first index counts sites.
    SiteTime,
});
choice!(QuantityArg => wavecascade::field::Quantity {
    Velocity, Displacement, Acceleration, StrainRate, Force
});
choice!(HeaderArg => wavecascade::field::Header { Detect, Present, Absent });
choice!(DelaysArg => wavecascade::field::Delays {
    /// They are an error.
    Refuse,
    /// The times that all have in common are taken.
    Align,
    /// All are read as if they began at one time.
    Ignore,
});
choice!(ReadArg => wavecascade::field::ReadMode {
    /// Read from the file whenever samples are needed.
    Map,
    /// Read once, into memory.
    Copy,
});
choice!(GapsArg => wavecascade::prepare::Gaps {
    /// Stop, and report their number and positions.
    Refuse,
    /// Fill along time from the neighbours.
    Interpolate,
    /// Count them as zeros, once trends are removed that were fitted without them.
    Mask,
    /// Leave the segments that hold them out of averages.
    LeaveOut,
});
choice!(DetrendArg => wavecascade::prepare::Detrend {
    None,
    Mean,
    /// The least-squares line.
    Linear,
});
choice!(FieldDetrendArg => bool { None => false, Mean => true });
choice!(ScalingArg => wavecascade::analyze::Scaling {
    /// Its integral is the sum of v^2 dt.
    Energy,
    /// Its integral is the mean square.
    Density,
    /// A sine of amplitude A peaks at A^2 / 2.
    Spectrum,
});
choice!(FormatArg => wavecascade::report::ArrayFormat {
    /// NumPy's archive.
    Npz,
    /// NetCDF, classic model.
    Netcdf => Self::NetCdf,
});
choice!(PrecisionArg => wavecascade::arrays::Precision { F64, F32 });

/// Results that can be selected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ResultArg {
    /// S(f, x) and the frequency content along x.
    Temporal,
    /// S(k, t) and the wavenumber content along t.
    Spatial,
    /// S(k, f) and the directions.
    Spacetime,
    /// The kinetic flux surrogate.
    Flux,
    /// Short-time spectra.
    ShortTime,
}
