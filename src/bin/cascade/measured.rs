//! `cascade budget FIELD --scene CHAIN`: budgets of a measured field with a stated chain.

use wavecascade::Result;
use wavecascade::budget::measured::{
    Drift, MeasuredMotion, MeasuredOptions, Noise, Uncertainty, from_field,
};
use wavecascade::budget::{BudgetRequest, BudgetUnits, Integration};
use wavecascade::chain::scene::{Setup, Units};
use wavecascade::field::Axis;
use wavecascade::measure::{self, Dimension, Length, Measure, Speed, Time};

use crate::prelude::*;
use crate::view_args::{ViewArgs, request_of};

/// How a measurement is read.
#[derive(Debug, Args)]
#[command(next_help_heading = "A measured field")]
pub struct MeasuredArgs {
    /// Scene of the chain that FIELD is a record of: its masses, contacts, law and ends.
    #[arg(long, value_name = "SCENE")]
    pub scene: Option<PathBuf>,
    /// Sample at which all contacts just touch; earlier samples only serve to estimate the noise.
    #[arg(long, value_name = "SAMPLE", default_value_t = 0, requires = "scene")]
    pub start: usize,
    /// Sites whose channels are dead, beside those of nothing but zeros or gaps.
    #[arg(long, value_delimiter = ',', value_name = "SITE", requires = "scene")]
    pub missing: Vec<usize>,
    /// Standard deviation of the noise, such as 1mm/s [default: that of the quiet part before the wave arrives].
    #[arg(long, value_name = "SPEED", value_parser = parse::origin::<Speed>, requires = "scene")]
    pub noise: Option<Measure<Speed>>,
    /// Standard deviation of a constant offset of the channels, beside `--noise` [default: 0].
    #[arg(long, value_name = "SPEED", value_parser = parse::origin::<Speed>, requires = "noise")]
    pub offset: Option<Measure<Speed>>,
    /// Relative standard error of the gain of the channels, as 0.01 or 1%: one for all, each by
    /// itself, or one a site [default: 0].
    #[arg(long, value_delimiter = ',', value_name = "SHARE", value_parser = parse::share,
          requires = "scene")]
    pub gain_error: Vec<f64>,
    /// Relative standard error of the contact coefficients, likewise, a wall's before site 0 first
    /// [default: 0].
    #[arg(long, value_delimiter = ',', value_name = "SHARE", value_parser = parse::share,
          requires = "scene")]
    pub coefficient_error: Vec<f64>,
    /// Relative standard error of the masses, likewise [default: 0].
    #[arg(long, value_delimiter = ',', value_name = "SHARE", value_parser = parse::share,
          requires = "scene")]
    pub mass_error: Vec<f64>,
    /// Repetitions of the measurement that errors are found from; N of them leave an error
    /// uncertain by 1 / sqrt(2 N).
    #[arg(long, value_name = "N", default_value_t = 48, requires = "scene")]
    pub repetitions: usize,
    /// What the channels may drift by.
    #[arg(long, value_enum, default_value_t = DriftArg::Linear, requires = "scene")]
    pub drift: DriftArg,
    #[command(flatten)]
    pub input: Input,
}

choice!(DriftArg => Drift {
    None,
    /// An offset each.
    Constant,
    /// An offset and a slope each.
    Linear,
});

/// A field, which messages call `path`, as the record of a chain, and the request for its budgets.
pub fn of_field(
    mut field: Field,
    path: &Path,
    setup: &Setup,
    typed: &MeasuredArgs,
    views: &ViewArgs,
) -> Result<(MeasuredMotion, BudgetRequest)> {
    let is_free = setup.simulation.drive.is_none();
    let expected = "a chain that nothing drives: what a drive does is not measured";
    Error::require(is_free, "scene", expected, "a driven one")?;
    if setup.units == Units::Si {
        to_si(&mut field, path)?;
    }
    let is_stated = typed.input.dt.is_some() || typed.input.rate.is_some();
    let is_known = is_stated || field.time.unit.is_some() || field.time.step != 1.0;
    let expected = "the time step, in the units of the scene";
    let found = "none stated, and none known from the file";
    Error::require(is_known, "dt", expected, found)?;
    let units = AxisUnits {
        samples: (setup.units == Units::Si).then_some("m/s"),
        ..AxisUnits::default()
    };
    let options = MeasuredOptions {
        start: typed.start,
        noise: match units.stated("noise", typed.noise)? {
            None => Noise::Quiet,
            Some(deviation) => Noise::Stated {
                deviation,
                offset: units.stated("offset", typed.offset)?.unwrap_or(0.0),
            },
        },
        drift: typed.drift.into(),
        uncertainty: Uncertainty {
            gain: typed.gain_error.clone(),
            coefficient: typed.coefficient_error.clone(),
            mass: typed.mass_error.clone(),
        },
        missing: typed.missing.clone(),
        repetitions: typed.repetitions,
        ..MeasuredOptions::default()
    };
    let motion = from_field(&field, &setup.simulation.chain, &options)?;
    let units = match setup.units {
        Units::Si => BudgetUnits::si(),
        Units::None => BudgetUnits {
            time: field.time.unit.clone(),
            length: field.space.unit.clone(),
            energy: None,
        },
    };
    let stated = field.space.unit.is_some() || typed.input.dx.is_some();
    let base = request_of(setup);
    let request = BudgetRequest {
        pitch: if stated { field.space.step } else { base.pitch },
        units,
        integration: Integration::Samples,
        ..views.choices(motion.time.len(), setup.simulation.chain.n_sites(), base)?
    };
    Ok((motion, request))
}

/// Puts the axes of a field that state units into seconds and metres, which an SI scene is in.
fn to_si(field: &mut Field, path: &Path) -> Result<()> {
    axis_to_si::<Time>(&mut field.time, path, "times")?;
    axis_to_si::<Length>(&mut field.space, path, "positions")?;
    let size = field.unit.as_deref().and_then(measure::size::<Speed>);
    match (&field.unit, size) {
        (Some(unit), Some(size)) if size != 1.0 => {
            Err(unfit(path, "velocities in m/s beside a scene in SI", unit))
        }
        _ => Ok(()),
    }
}

fn axis_to_si<D: Dimension>(axis: &mut Axis, path: &Path, what: &str) -> Result<()> {
    let Some(unit) = axis.unit.clone() else {
        return Ok(());
    };
    let convert = |value: f64| Measure::<D>::parse(&format!("{value:e} {unit}"));
    let (Some(origin), Some(step)) = (convert(axis.origin), convert(axis.step)) else {
        let known = measure::units::<D>();
        let expected = format!("{what} in one of {known} beside a scene in SI");
        return Err(unfit(path, expected, unit));
    };
    *axis = Axis {
        origin: origin.value,
        step: step.value,
        unit: Some(D::UNITS[0].0.to_owned()),
    };
    Ok(())
}
