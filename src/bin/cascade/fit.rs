//! `cascade fit`: the chain that did what was measured.

use wavecascade::fit::{FitRequest, Instruments};

use crate::prelude::*;
use crate::scene::source_of;

/// The scene with the fitted values, in the directory of the results.
const SCENE: &str = "fitted.toml";

/// What instruments may add to records.
#[derive(Debug, Args)]
pub struct InstrumentArgs {
    /// The clock of the records may be off: fit by how much they start late or early, too.
    #[arg(long)]
    pub free_time_shift: bool,

    /// Fit a gain of each record, too.
    #[arg(long)]
    pub free_gains: bool,

    /// Relative standard error of the gains, as 0.02 or 2%; fits them, and holds them by it.
    #[arg(long, value_name = "SHARE", value_parser = parse::share)]
    pub gain_error: Option<f64>,
}

impl InstrumentArgs {
    pub fn stated(&self) -> Instruments {
        Instruments {
            time_shift: self.free_time_shift,
            gains: self.free_gains,
            gain_error: self.gain_error,
        }
    }
}

/// What `cascade fit` takes.
#[derive(Debug, Args)]
pub struct Fit {
    /// File with the measured records: velocities, displacements, accelerations or forces.
    #[arg(value_parser = records)]
    pub field: PathBuf,

    /// File with the scene of the chain; its values are where the first search starts.
    pub scene: Option<PathBuf>,

    /// A key of the scene to fit, with bounds if there are any: young=50GPa..90GPa, striker_velocity, mass_cell[1],
    /// defect[0].factor=1..3. Several with commas between, or repeat it.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "KEY[=LOW..HIGH]",
        required = true
    )]
    pub free: Vec<String>,

    /// The body of each site of the field, or of forces the contact [default: by the positions, else by the numbers of
    /// the sites].
    #[arg(long, value_delimiter = ',', value_name = "BODY,..")]
    pub bodies: Option<Vec<usize>>,

    #[command(flatten)]
    pub instruments: InstrumentArgs,

    /// Searches: the first from the scene's values, the others from random ones within the bounds, or a tenth up and
    /// down.
    #[arg(long, value_name = "N", default_value_t = FitRequest::default().starts,
          value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=1000))]
    pub starts: usize,

    /// Seed of the random starts.
    #[arg(long, value_name = "SEED", default_value_t = FitRequest::default().seed)]
    pub seed: u64,

    /// Save each search in this directory as soon as it has ended; after an interrupt, a kill or `--max-time`, the same
    /// command resumes.
    #[arg(long, value_name = "DIR")]
    pub resume: Option<PathBuf>,

    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub result: ResultArgs,
}

/// The file of the records, which is no scene.
fn records(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension().is_some_and(|ending| ending == "toml") {
        true => Err(
            "expected the records first, then the scene: `cascade fit FIELD SCENE --free KEY`"
                .into(),
        ),
        false => Ok(path),
    }
}

impl Describing for Fit {
    fn about(&self) -> About<'_> {
        About {
            reading: Some(Reading::of(&self.input, None)),
            ..About::of("fit", &self.result.how, [&self.field], "npy")
        }
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let is_known = given.scene.is_some() || self.scene.is_some();
        let expected = "the scene of the chain, `cascade fit FIELD SCENE`";
        Error::require(is_known, "scene", expected, "none")?;
        let scene = source_of(given.scene.clone(), self.scene.as_deref())?;
        let request = FitRequest {
            free: self.free.clone(),
            bodies: self.bodies.clone(),
            instruments: self.instruments.stated(),
            starts: self.starts,
            seed: self.seed,
            resume: self.resume.clone(),
        };
        let found = request.run(given.field()?, &scene, observer)?;
        let text = found.scene_text(&scene)?;
        Ok(Found::of(found).with_text(SCENE, text))
    }
}
