//! What the user types for chains: `simulate`, `sweep`, `scene`.

use clap::builder::{PossibleValuesParser, RangedU64ValueParser};
use wavecascade::chain::Run;
use wavecascade::chain::scene::{PRESETS, SceneSource, Setup};
use wavecascade::fit::gradient;
use wavecascade::sweep::Part;

use crate::prelude::*;
use crate::scene_keys::SceneKeys;

/// What `cascade simulate` takes.
#[derive(Debug, Args)]
pub struct Simulate {
    /// File with the scene; without one, the options state all keys.
    pub scene: Option<PathBuf>,

    /// File for the run: an archive (.npz), or NetCDF (.nc) for xarray; by default the scene's name with
    /// `.npz`, here, or run.npz.
    #[arg(long, short, value_name = "FILE")]
    pub out: Option<PathBuf>,

    /// Replace an existing run.
    #[arg(long)]
    pub force: bool,

    /// Keys of the scene with respect to which the run's derivatives are recorded, too: `young,angle`, an entry of a list
    /// (`mass_cell[1]`), a number of a table (`defect[0].factor`).
    #[arg(long, value_name = "KEY,KEY", value_delimiter = ',')]
    pub gradient: Vec<String>,

    /// Find the largest Lyapunov exponent of the run, too: the rate at which small differences grow.
    #[arg(long)]
    pub lyapunov: bool,

    /// Print what the scene describes and the memory of its run, and stop.
    #[arg(long)]
    pub plan: bool,

    /// Print the summary, or the plan, as JSON on standard output.
    #[arg(long)]
    pub json: bool,

    /// Print errors only.
    #[arg(long, short)]
    pub quiet: bool,

    #[command(flatten)]
    pub keys: SceneKeys,
}

impl Simulate {
    /// The run of a scene, with its gradient where one is requested.
    pub fn compute(
        &self,
        source: &SceneSource,
        setup: &Setup,
        observer: &dyn Observer,
    ) -> wavecascade::Result<Run> {
        let run = setup.simulation.run(observer);
        let mut run = run.map_err(|error| source.locate(error))?;
        if !self.gradient.is_empty() {
            let times = run.time.to_vec();
            run.gradient = Some(gradient(source, &self.gradient, &times, observer)?);
        }
        if self.lyapunov {
            let end = run.time[run.time.len() - 1];
            run.report.lyapunov = Some(setup.simulation.lyapunov(end, observer)?);
        }
        Ok(run)
    }
}

/// What `cascade sweep` takes.
#[derive(Debug, Args)]
pub struct SweepCommand {
    /// File with the scene; without one, the options state all keys.
    #[arg(conflicts_with = "merge")]
    pub scene: Option<PathBuf>,

    /// A key of the scene and its values: `stiffness_ratio=1:120:400log` (400 values, equal ratios),
    /// `1:10:19` (equal steps), `seed=1:100` (whole numbers), `ends=wall,free`. Repeat it for all
    /// combinations, the last one fastest.
    #[arg(
        long,
        value_name = "KEY=VALUES",
        required_unless_present_any = ["merge", "members"],
        conflicts_with = "merge"
    )]
    pub vary: Vec<String>,

    /// An ensemble of N members with the seeds 0 to N - 1, or from that of `--seed` on, at each combination:
    /// medians, 5 to 95 % bands and spreads of all columns.
    #[arg(long, value_name = "N", conflicts_with = "merge",
          value_parser = clap::value_parser!(u32).range(2..=10_000_000))]
    pub members: Option<u32>,

    /// Directory of the sweep; by default the scene's name with `-sweep`, here.
    #[arg(long, short, value_name = "DIR", required_unless_present_any = ["scene", "vary", "members"])]
    pub out: Option<PathBuf>,

    /// Compute only the K-th of N parts, to be merged later.
    #[arg(long, value_name = "K/N", value_parser = parse::part, conflicts_with = "merge")]
    pub part: Option<Part>,

    /// Put together what these directories hold of one sweep.
    #[arg(long, value_name = "DIR", num_args = 1..)]
    pub merge: Vec<PathBuf>,

    /// Open the page of the table in the browser, once all members are done.
    #[arg(long)]
    pub open: bool,

    #[command(flatten)]
    pub how: How,

    #[command(flatten)]
    pub keys: SceneKeys,
}

impl SweepCommand {
    /// The varied keys, with the seeds of an ensemble.
    pub fn varied(&self) -> Vec<String> {
        let mut all = self.vary.clone();
        if let Some(members) = self.members {
            let settings = self.keys.settings.iter().rev();
            let seed = settings.filter(|setting| setting.key == "seed");
            let mut stated = seed.filter_map(|setting| setting.text.trim().parse().ok());
            let first: u64 = stated.next().unwrap_or(0);
            let last = first.saturating_add(u64::from(members) - 1);
            all.push(format!("seed={first}:{last}"));
        }
        all
    }
}

/// Options of a command of many runs: threads, memory, output.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Output")]
pub struct How {
    /// Worker threads [default: one a core]. The results do not depend on it.
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    pub threads: Option<usize>,

    /// Print the results as JSON on standard output.
    #[arg(long)]
    pub json: bool,

    /// Print errors only.
    #[arg(long, short)]
    pub quiet: bool,

    /// Print all details and all warnings; by default the answer and the facts that fit a dozen lines.
    #[arg(long, short, conflicts_with_all = ["json", "quiet"])]
    pub verbose: bool,
}

/// What `cascade scene` takes.
#[derive(Debug, Args)]
pub struct SceneCommand {
    /// Print the JSON schema of scene files instead.
    #[arg(long, conflicts_with = "check")]
    pub schema: bool,

    /// List the scenes that come with the program, most of which reproduce a published result.
    #[arg(long, conflicts_with_all = ["check", "schema"])]
    pub presets: bool,

    /// Print the scene of this name from that list, to be saved and changed.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["check", "schema", "presets"],
          hide_possible_values = true,
          value_parser = PossibleValuesParser::new(PRESETS.iter().map(|preset| preset.name)))]
    pub preset: Option<String>,

    /// Describe the scene in this file, without running it.
    #[arg(long, value_name = "FILE")]
    pub check: Option<PathBuf>,

    /// With `--check`, as JSON.
    #[arg(long, requires = "check")]
    pub json: bool,
}
