//! `cascade plan`: where, how long and how fast to measure.

use clap::builder::RangedU64ValueParser;
use wavecascade::chain::scene::Units;
use wavecascade::measure::{Frequency, Measure};
use wavecascade::plan::{Criterion, NoiseLevel, PlanRequest};

use crate::args::QuantityArg;
use crate::fit::InstrumentArgs;
use crate::prelude::*;
use crate::scene::source_of;

/// What `cascade plan` takes.
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// File with the scene of the chain; its values are where the information is taken.
    pub scene: PathBuf,

    /// A key of the scene to determine, as for `cascade fit`: young, striker_velocity, mass_cell[1], tangent=0..5us.
    /// Several with commas between, or repeat it.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "KEY[=LOW..HIGH]",
        required = true
    )]
    pub free: Vec<String>,

    /// Number of bodies, or of forces contacts, that are measured.
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=100_000))]
    pub sensors: usize,

    /// Standard deviation of the noise of a sample: a share of the root mean square of all records, or a value with its
    /// unit, as 5mm/s.
    #[arg(long, value_name = "NOISE", default_value = "1%", value_parser = NoiseLevel::parse)]
    pub noise: NoiseLevel,

    /// What is measured.
    #[arg(long, value_enum, default_value_t = QuantityArg::Velocity)]
    pub quantity: QuantityArg,

    /// Bodies, of forces contacts, that can be measured [default: all].
    #[arg(long, value_delimiter = ',', value_name = "BODY,..")]
    pub bodies: Option<Vec<usize>>,

    #[command(flatten)]
    pub instruments: InstrumentArgs,

    /// Samples in a unit of time, as 1MHz, that the noise is stated of [default: those of the scene].
    #[arg(long, value_name = "RATE", value_parser = parse::origin::<Frequency>)]
    pub rate: Option<Measure<Frequency>>,

    /// Which sensors are best.
    #[arg(long, value_enum, default_value_t = CriterionArg::Volume)]
    pub criterion: CriterionArg,

    #[command(flatten)]
    pub result: ResultArgs,
}

choice!(CriterionArg => Criterion {
    /// Those with the least volume of the confidence ellipsoid of all keys.
    Volume,
    /// Those with the least of the largest relative error of a key.
    Worst,
});

impl Describing for PlanArgs {
    fn about(&self) -> About<'_> {
        About::of("plan", &self.result.how, [&self.scene], "toml")
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let scene = source_of(given.scene, Some(&self.scene))?;
        let is_si = scene.setup().map_err(|error| scene.locate(error))?.units == Units::Si;
        let units = AxisUnits {
            time: is_si.then_some("s"),
            ..AxisUnits::default()
        };
        let request = PlanRequest {
            noise: self.noise.clone(),
            quantity: self.quantity.into(),
            bodies: self.bodies.clone(),
            instruments: self.instruments.stated(),
            rate: units.stated("rate", self.rate)?,
            criterion: self.criterion.into(),
            ..PlanRequest::of(&self.free, self.sensors)
        };
        Ok(Found::of(request.run(&scene, observer)?))
    }
}
