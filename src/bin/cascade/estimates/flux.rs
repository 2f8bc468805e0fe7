//! `cascade flux`: flux of energy, and its loss.

use clap::Args;
use wavecascade::analyze::{Constants, Dispersion};
use wavecascade::chain::{NoBranches, UnitCell};
use wavecascade::field::is_run_file;
use wavecascade::flux::{FluxRequest, GroupVelocity, flux};
use wavecascade::measure::{Frequency, Length, LinearDensity, Measure, Speed, Time, size};
use wavecascade::observer::Observer;
use wavecascade::prepare::Window;
use wavecascade::report::RunFile;
use wavecascade::transform::Travelling;
use wavecascade::{Error, Field};

use crate::args::{GapsArg, choice};
use crate::described::Found;
use crate::dispersion::read;
use crate::estimates::{Estimate, EstimateArgs};
use crate::parse;
use crate::show_args::{AxisUnits, Ends, ends};

/// What `cascade flux` takes.
#[derive(Debug, Args)]
pub struct Flux {
    /// Mass of a unit of length, such as 0.3kg/m; in kg/m without a unit, where the field has units [default: the flux of one
    /// unit of mass per length].
    #[arg(long, value_name = "MASS", value_parser = parse::step::<LinearDensity>)]
    pub mass_per_length: Option<Measure<LinearDensity>>,
    /// Group velocity at all frequencies, such as 3km/s, or in units of length over units of time [default: the slope of the
    /// wavenumbers that are found].
    #[arg(long, value_name = "SPEED", value_parser = parse::step::<Speed>, conflicts_with = "dispersion")]
    pub group_velocity: Option<Measure<Speed>>,
    /// Relation that wavenumbers and group velocities follow: monatomic:..., diatomic:..., a formula of k such as
    /// `c*k^2; c=0.5`, or a table (.csv), as `analyze` takes them.
    #[arg(long, value_name = "RELATION", alias = "law")]
    pub dispersion: Option<String>,
    /// Waves that there are.
    #[arg(long, value_enum, default_value_t = WayArg::Both)]
    pub towards: WayArg,
    /// Frequencies [default: those at which waves are found].
    #[arg(long, value_name = "FROM:TO", value_parser = ends::<Frequency>)]
    pub band: Option<Ends<Frequency>>,
    /// Parts of the band with a number each, at most.
    #[arg(long, value_name = "N", default_value_t = FluxRequest::default().bands)]
    pub bands: usize,
    /// Taper of the whole records [default: none for transients, hann for steady records].
    #[arg(long, value_name = "WINDOW")]
    pub window: Option<Window>,
    /// What to do with samples that are not finite.
    #[arg(long, value_enum, default_value_t = GapsArg::Refuse)]
    pub gaps: GapsArg,
    /// Intervals hold with a probability of 1 less this.
    #[arg(long, value_name = "SHARE", default_value_t = FluxRequest::default().alpha, value_parser = parse::share)]
    pub significance: f64,

    #[command(flatten)]
    pub estimate: EstimateArgs,
}

choice!(
    /// `--towards`.
    WayArg => Travelling {
        /// Both ways.
        Both => Travelling::Anywhere,
        /// Towards +x alone.
        PlusX => Travelling::TowardPlusX,
        /// Towards -x alone.
        MinusX => Travelling::TowardMinusX,
    }
);

impl Flux {
    fn relation(&self) -> Result<Option<Dispersion>, Error> {
        let relation = self.dispersion.as_ref();
        relation
            .map(|text| read(text, &Constants::new()))
            .transpose()
    }

    /// Refuses runs in which any amplitude changes the speed of waves.
    fn check_linear(&self) -> Result<(), Error> {
        for path in self.estimate.fields.iter().filter(|path| path.is_file()) {
            if is_run_file(path)? {
                let (setup, _) = RunFile::read_scene(path)?;
                let cell = UnitCell::of(&setup.simulation.chain);
                if let Err(none @ NoBranches::NoLinearLimit) = cell {
                    let expected = "waves whose speed does not depend on their amplitude";
                    return Err(Error::request("field", expected, none));
                }
            }
        }
        Ok(())
    }

    fn velocity(&self, field: &Field) -> Result<GroupVelocity, Error> {
        let Some(velocity) = self.group_velocity else {
            return Ok(self
                .relation()?
                .map_or(GroupVelocity::Measured, GroupVelocity::Of));
        };
        let sizes = || {
            let length = size::<Length>(field.space.unit.as_deref()?)?;
            Some(length / size::<Time>(field.time.unit.as_deref()?)?)
        };
        let factor = if velocity.has_unit {
            sizes()
        } else {
            Some(1.0)
        };
        let expected = "a number: times or positions have no unit that is known";
        let found = || format!("{velocity:?}");
        let factor = factor.ok_or_else(|| Error::request("group-velocity", expected, found()))?;
        Ok(GroupVelocity::Stated(velocity.value / factor))
    }
}

impl Estimate for Flux {
    fn name(&self) -> &'static str {
        "flux"
    }

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    fn check(&self) -> Result<(), Error> {
        self.relation().map(|_| ())
    }

    fn find(&self, fields: &[&Field], observer: &dyn Observer) -> Result<Found, Error> {
        let first = fields.first().copied();
        let first = first.ok_or_else(|| Error::request("field", "one", "none"))?;
        self.check_linear()?;
        let band = self
            .band
            .map(|band| AxisUnits::of(first).ends("band", band));
        let request = FluxRequest {
            mass_per_length: self.mass_per_length,
            group_velocity: self.velocity(first)?,
            towards: self.towards.into(),
            band: band.transpose()?,
            bands: self.bands,
            window: self.window,
            gaps: self.gaps.into(),
            alpha: self.significance,
            threads: self.estimate.threads(),
            memory: self.estimate.memory,
        };
        Ok(Found::of(flux(fields, &request, observer)?))
    }
}
