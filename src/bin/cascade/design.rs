//! `cascade design`: the chain that does what is wanted.

use clap::ArgGroup;
use clap::builder::RangedU64ValueParser;
use wavecascade::design::{Aim, DesignRequest, Judge, Limit};

use crate::prelude::*;
use crate::scene::source_of;

/// The scene with the values found, in the directory of the results.
const SCENE: &str = "design.toml";

/// What `cascade design` takes.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("wanted").required(true).args(["minimize", "maximize"])))]
pub struct DesignArgs {
    /// File with the scene of the chain; its values are where the search starts.
    pub scene: PathBuf,

    /// A key of the scene to vary, with its bounds or values: angle=2..90, radius=5mm|10mm, coefficients[3]=0.2..5, all
    /// entries of a list by coefficients[]=0.2..5. Several with commas between, or repeat it.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "KEY=LOW..HIGH",
        required = true
    )]
    pub free: Vec<String>,

    /// Make this measure of the run least: peak_force_last, peak_force_first, impulse_last, energy_passed_last,
    /// energy_passed_share, energy_lost, force_above:2kHz (the share of the last contact's force above a frequency),
    /// peak_force_last_time, total_mass.
    #[arg(long, value_name = "MEASURE", value_parser = Aim::parse)]
    pub minimize: Option<Aim>,

    /// Make it largest.
    #[arg(long, value_name = "MEASURE", value_parser = Aim::parse)]
    pub maximize: Option<Aim>,

    /// A limit of a measure, in the units of the scene, such as total_mass=0.5. May be repeated.
    #[arg(long, value_name = "MEASURE=VALUE")]
    pub at_most: Vec<String>,

    /// How far a free key may be off when it is made: angle=2deg, coefficients=10%. The design is judged by random ones
    /// that are off by up to this. May be repeated.
    #[arg(long, value_name = "KEY=SPREAD")]
    pub tolerance: Vec<String>,

    /// By which of these designs it is judged.
    #[arg(long, value_enum, default_value_t = JudgeArg::Worst, requires = "tolerance")]
    pub judge: JudgeArg,

    /// Number of these designs.
    #[arg(long, value_name = "N", default_value_t = 20, requires = "tolerance",
          value_parser = RangedU64ValueParser::<usize>::new().range(1..=1000))]
    pub members: usize,

    /// Designs that are tried, and as many random ones beside them [default: 60, or 100 and 60 for each of several keys].
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(10..=1_000_000))]
    pub tries: Option<usize>,

    /// Seed of the search.
    #[arg(long, value_name = "SEED", default_value_t = 0)]
    pub seed: u64,

    #[command(flatten)]
    pub result: ResultArgs,
}

choice!(JudgeArg => Judge { Worst, Mean });

impl Describing for DesignArgs {
    fn about(&self) -> About<'_> {
        About::of("design", &self.result.how, [&self.scene], "toml")
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let scene = source_of(given.scene, Some(&self.scene))?;
        let limits = self.at_most.iter().map(|text| Limit::parse(text));
        let aim = self.minimize.or(self.maximize);
        let request = DesignRequest {
            is_most: self.maximize.is_some(),
            limits: limits.collect::<Result<_, _>>()?,
            tolerances: self.tolerance.clone(),
            judge: self.judge.into(),
            members: self.members,
            tries: self.tries,
            seed: self.seed,
            ..DesignRequest::least(aim.unwrap_or(Aim::PeakForceLast), self.free.clone())
        };
        let found = request.run(&scene, observer)?;
        let text = found.scene.clone();
        Ok(Found::of(found).with_text(SCENE, text))
    }
}
