//! `cascade localize`: ratios that carry localized waves, one wave, and its travel along a chain.

use std::io::IsTerminal;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};
use wavecascade::Error;
use wavecascade::arrays::Precision;
use wavecascade::chain::contact::{Ellipse, Material};
use wavecascade::localized::{
    Alternation, Comparison, Cylinders, Family, Journey, LARGEST_ORDER, Orders, Profile, Wave,
};
use wavecascade::measure::{Length, Pressure};
use wavecascade::observer::Observer;
use wavecascade::report::{Archive, Provenance, ResultDirectory, localized_snippet, write_beside};
use wavecascade::sheet::Describe;

use crate::analyze::use_threads;
use crate::args::choice;
use crate::budget::command;
use crate::chain_args::How;
use crate::described::Described;
use crate::failure::Failure;
use crate::figure_args::FigureArgs;
use crate::parse;
use crate::progress::Progress;

/// What `cascade localize` takes.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("written").multiple(true).args(["out", "profile"]))]
#[command(mut_arg("open", |arg| arg.requires("written")), mut_arg("show", |arg| arg.requires("written")))]
pub struct Localize {
    /// Orders, both ends included, from 1, the homogeneous chain, to 60.
    #[arg(long, value_name = "N|FIRST..LAST", default_value = "1..8", value_parser = orders)]
    pub order: RangeInclusive<usize>,
    /// What alternates along the dimer.
    #[arg(long, value_enum, default_value_t = Of::Stiffness)]
    pub alternation: Of,
    /// p of the contact law `F = c delta^p`.
    #[arg(long, default_value_t = 1.5, value_parser = parse::finite, allow_negative_numbers = true)]
    pub exponent: f64,
    /// Strike chains too, and find where their pulses lose least, and most in between.
    #[arg(long)]
    pub direct: bool,
    /// Give the angles of cylinders crossed alternately at 90 degrees and at this angle, for
    /// each order and, as `--direct`, for the largest leak between two orders.
    #[arg(long)]
    pub angles: bool,
    /// By which form of the contact ellipse an angle follows from a stiffness ratio.
    #[arg(long, value_enum, default_value_t = Form::Approximate, requires = "angles")]
    pub ellipse: Form,
    #[command(flatten)]
    pub body: Body,
    /// Write the wave of this order and draw it.
    #[arg(long, value_name = "N", value_parser = one_order,
          conflicts_with_all = ["order", "direct", "angles", "cells", "launch"])]
    pub profile: Option<usize>,
    /// Start a chain with the wave of this order and see how it travels.
    #[arg(long, value_name = "N", value_parser = one_order,
          conflicts_with_all = ["order", "direct", "angles"])]
    pub launch: Option<usize>,
    /// Cells of chains that are struck [default: 200], or that a launched wave travels
    /// [default: 1000].
    #[arg(long)]
    pub cells: Option<usize>,
    /// Directory for the results: summary.json, the page and its picture, beside table.csv and the waves, or the arrays
    /// of the one wave. Without it nothing is written, but for `--profile` localized-N.
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace an existing result.
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub how: How,
    #[command(flatten)]
    pub figures: FigureArgs,
}

choice!(Of => Alternation {
    Stiffness => Self::Stiffness,
    Mass => Self::Mass,
});

choice!(Form => Ellipse {
    /// The published `b/a = (A/B)^(2/3)`.
    Approximate => Self::Approximate,
    /// From the transcendental equation.
    Exact => Self::Exact,
});

fn orders(text: &str) -> Result<RangeInclusive<usize>, String> {
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    let (first, last) = (one_order(first)?, one_order(last)?);
    if first > last {
        return Err(format!("expected the first order first, found {text}"));
    }
    Ok(first..=last)
}

fn one_order(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(order) if (1..=LARGEST_ORDER).contains(&order) => Ok(order),
        _ => Err(format!("expected orders from 1 to {LARGEST_ORDER}")),
    }
}

impl Localize {
    pub fn family(&self) -> Family {
        Family {
            alternation: self.alternation.into(),
            exponent: self.exponent,
        }
    }

    fn wave(&self, order: usize) -> Result<Wave, Error> {
        self.family().search(order)?.wave(order)
    }

    /// Computes the table, or the one wave that is requested.
    pub fn find(&self, observer: &dyn Observer) -> Result<Found, Error> {
        Ok(match (self.profile, self.launch) {
            (Some(order), _) => Found::Profile(Box::new(Profile::of(self.wave(order)?, HALF))),
            (None, Some(order)) => {
                let wave = self.wave(order)?;
                Found::Journey(wave.journey(self.cells.unwrap_or(TRAVELLED), observer)?)
            }
            (None, None) => {
                let comparison = self.comparison()?;
                let rows = comparison.run(observer)?;
                Found::Orders(Orders { comparison, rows })
            }
        })
    }

    fn comparison(&self) -> Result<Comparison, Error> {
        let strikes = self.direct || self.angles;
        let body = match self.body.material()? {
            Some(material) => self.body.radius.map(|radius| (radius, material)),
            None => None,
        };
        Ok(Comparison {
            family: self.family(),
            orders: self.order.clone(),
            cells: strikes.then(|| self.cells.unwrap_or(STRUCK)),
            cylinders: self.angles.then(|| Cylinders {
                ellipse: self.ellipse.into(),
                body,
            }),
        })
    }
}

/// Default number of cells of struck chains.
const STRUCK: usize = 200;
/// Default number of cells that a wave travels.
const TRAVELLED: usize = 1000;
/// Times on each side of the centre of a wave, and of those beside a table.
const HALF: usize = 2000;
const HALF_OF_MANY: usize = 1000;

/// What was requested.
pub enum Found {
    Orders(Orders),
    Profile(Box<Profile>),
    Journey(Journey),
}

impl Found {
    pub fn as_described(&self) -> &dyn Describe {
        match self {
            Found::Orders(found) => found,
            Found::Profile(found) => &**found,
            Found::Journey(found) => found,
        }
    }

    /// The script, and each wave's arrays, of a table.
    fn write_beside(&self, directory: &Path) -> Result<(), Error> {
        let Found::Orders(found) = self else {
            return Ok(());
        };
        write_beside(directory, "plot.py", localized_snippet().as_bytes())?;
        let waves = found.rows.iter().filter_map(|row| row.wave.as_ref());
        waves.into_iter().try_for_each(|wave| {
            let path = directory.join(format!("wave-{:02}.npz", wave.order));
            let archive = Archive::create(&path, Precision::F64)?;
            let profile = Profile::of(wave.clone(), HALF_OF_MANY);
            profile.describe().write_to(&archive)?;
            archive.finish()
        })
    }
}

/// Runs the command.
pub fn run(typed: Localize) -> Result<(), Failure> {
    let default = typed
        .profile
        .map(|order| PathBuf::from(format!("localized-{order}")));
    let out = typed.out.clone().or(default);
    let drawing = typed.figures.drawing()?;
    use_threads(typed.how.threads.map(usize::from))?;
    let progress = Progress::new(!typed.how.quiet && std::io::stderr().is_terminal());
    progress.begin_writing();
    // Before any work: could the result be written?
    let directory = out.map(|out| ResultDirectory::create(&out, typed.force));
    let directory = directory.transpose()?;
    if typed.profile.or(typed.launch).is_some() {
        progress.wait("solving");
    }
    let found = typed.find(&progress)?;
    progress.check()?;
    let subject = match typed.profile.or(typed.launch) {
        Some(order) => format!("order {order}"),
        None => "dimer".into(),
    };
    let sheet = found.as_described().describe();
    let provenance = Provenance::new(command(), None, None);
    let described = Described {
        found: found.as_described(),
        sheet: &sheet,
        name: "dimer",
        provenance: &provenance,
    };
    let main = directory.map(|directory| {
        let file = (directory, sheet.name);
        described.publish(file, &drawing, &progress, |path| found.write_beside(path))
    });
    let main = main.transpose()?;
    progress.clear();
    described.tell(&subject, &typed.how, main.as_deref())?;
    if let Some(main) = &main {
        drawing.present(main)?;
    }
    let Found::Orders(orders) = &found else {
        return Ok(());
    };
    match orders.rows.iter().filter(|row| row.exact.is_none()).count() {
        0 => Ok(()),
        unresolved => Err(Failure::Orders(unresolved)),
    }
}

/// A material and a radius.
#[derive(Debug, Args)]
pub struct Body {
    /// Material of both: quartz, steel or ptfe.
    #[arg(long, requires = "radius", conflicts_with_all = ["young", "poisson"])]
    pub material: Option<String>,

    /// Young's modulus of both, such as 72GPa.
    #[arg(long, value_parser = parse::measure::<Pressure>, requires = "poisson",
          requires = "radius", allow_negative_numbers = true)]
    pub young: Option<f64>,

    /// Poisson's ratio of both.
    #[arg(long, value_parser = parse::finite, requires = "young", allow_negative_numbers = true)]
    pub poisson: Option<f64>,

    /// Radius of both, such as 9mm.
    #[arg(long, value_parser = parse::measure::<Length>, requires = "angles", allow_negative_numbers = true)]
    pub radius: Option<f64>,
}

impl Body {
    /// The material that was named or given by its constants.
    pub fn material(&self) -> Result<Option<Material>, Error> {
        if let (Some(young), Some(poisson)) = (self.young, self.poisson) {
            return Ok(Some(Material {
                young,
                poisson,
                // No contact depends on it.
                density: 1.0,
            }));
        }
        let Some(name) = &self.material else {
            return Ok(None);
        };
        let known = Material::named(name).ok_or_else(|| Error::Request {
            option: "material",
            expected: "quartz, steel or ptfe".into(),
            found: name.clone(),
        });
        known.map(Some)
    }
}
