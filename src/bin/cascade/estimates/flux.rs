//! `cascade flux`: flux of energy, and its loss.

use wavecascade::analyze::Constants;
use wavecascade::chain::{NoBranches, UnitCell};
use wavecascade::field::is_run_file;
use wavecascade::flux::{FluxRequest, flux};
use wavecascade::measure::{Length, LinearDensity, Measure, Speed, Time, size};
use wavecascade::report::RunFile;
use wavecascade::transform::Travelling;

use super::*;
use crate::dispersion::read;

/// What `cascade flux` takes.
#[derive(Debug, Args)]
pub struct Flux {
    /// Mass of a unit of length, such as 0.3kg/m; in kg/m without a unit, where the field has units; of unit cells of several
    /// sites each site's, such as 1,0.3 of a dimer [default: the flux of one unit of mass per length].
    #[arg(long, value_name = "MASS", value_delimiter = ',', value_parser = parse::step::<LinearDensity>)]
    pub mass_per_length: Vec<Measure<LinearDensity>>,
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
    /// Parts with a number each of the frequencies at which waves are found, at most.
    #[arg(long, value_name = "N", default_value_t = FluxRequest::default().bands)]
    pub bands: usize,
    /// What to do with samples that are not finite.
    #[arg(long, value_enum, default_value_t = GapsArg::Refuse)]
    pub gaps: GapsArg,
    /// Intervals hold with a probability of 1 less this.
    #[arg(long, value_name = "SHARE", default_value_t = FluxRequest::default().alpha, value_parser = parse::share)]
    pub significance: f64,

    #[command(flatten)]
    pub estimate: EstimateArgs,
}

choice!(WayArg => Travelling {
    /// Both ways.
    Both => Travelling::Anywhere,
    /// Towards +x alone.
    PlusX => Travelling::TowardPlusX,
    /// Towards -x alone.
    MinusX => Travelling::TowardMinusX,
});

impl Estimate for Flux {
    /// Runs in which any amplitude changes the speed of waves are refused.
    fn check(&self) -> Result<(), Error> {
        for path in self.estimate.fields.iter().filter(|path| path.is_file()) {
            if is_run_file(path)? {
                let (setup, _) = RunFile::read_scene(path)?;
                if let Err(none @ NoBranches::NoLinearLimit) = UnitCell::of(&setup.simulation.chain)
                {
                    let expected = "waves whose speed does not depend on their amplitude";
                    return Err(Error::request("field", expected, none));
                }
            }
        }
        Ok(())
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let unit = |field: &&Field| {
            let length = size::<Length>(field.space.unit.as_deref()?)?;
            Some(length / size::<Time>(field.time.unit.as_deref()?)?)
        };
        let unit = given.fields.first().and_then(unit);
        let expected = "a number: times or positions have no unit that is known";
        let in_units = |speed: Measure<Speed>| match (speed.has_unit, unit) {
            (false, _) => Ok(speed.value),
            (true, Some(unit)) => Ok(speed.value / unit),
            (true, None) => Err(Error::request(
                "group-velocity",
                expected,
                format!("{speed:?}"),
            )),
        };
        let relation = self.dispersion.as_ref();
        let request = FluxRequest {
            mass_per_length: self.mass_per_length.clone(),
            group_velocity: self.group_velocity.map(in_units).transpose()?,
            dispersion: relation
                .map(|text| read(text, &Constants::new()))
                .transpose()?,
            towards: self.towards.into(),
            bands: self.bands,
            gaps: self.gaps.into(),
            alpha: self.significance,
            threads: self.estimate.threads(),
            memory: self.estimate.memory,
        };
        Ok(Found::of(flux(given.fields, &request, observer)?))
    }
}
