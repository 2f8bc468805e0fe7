//! `cascade localize`: ratios that carry localized waves, one wave, and its travel along a chain.

pub mod launch;
pub mod profile;
pub mod table;

use std::io::IsTerminal;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use wavecascade::Error;
use wavecascade::chain::contact::{Ellipse, Material};
use wavecascade::localized::{Alternation, Family, LARGEST_ORDER, Wave};
use wavecascade::measure::{Length, Pressure};
use wavecascade::report::{Contents, ResultDirectory};

use crate::analyze::use_threads;
use crate::args::DetailArgs;
use crate::failure::Failure;
use crate::figure_args::FigureArgs;
use crate::parse;
use crate::progress::Progress;

/// What `cascade localize` takes.
#[derive(Debug, Args)]
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
    /// Directory for the results: localized.json beside table.csv and the waves, or the wave and
    /// its picture. Without it nothing is written, but for `--profile` localized-N.
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub figures: FigureArgs,
    /// Replace an existing result.
    #[arg(long)]
    pub force: bool,
    /// Number of worker threads [default: all cores].
    #[arg(long, value_name = "N")]
    pub threads: Option<std::num::NonZeroUsize>,
    /// Print all that was found as JSON.
    #[arg(long)]
    pub json: bool,
    /// Print errors only.
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub detail: DetailArgs,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Of {
    Stiffness,
    Mass,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Form {
    /// The published `b/a = (A/B)^(2/3)`.
    Approximate,
    /// From the transcendental equation.
    Exact,
}

impl From<Form> for Ellipse {
    fn from(form: Form) -> Ellipse {
        match form {
            Form::Approximate => Ellipse::Approximate,
            Form::Exact => Ellipse::Exact,
        }
    }
}

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
            alternation: match self.alternation {
                Of::Stiffness => Alternation::Stiffness,
                Of::Mass => Alternation::Mass,
            },
            exponent: self.exponent,
        }
    }

    fn progress(&self) -> Progress {
        Progress::new(!self.quiet && std::io::stderr().is_terminal())
    }

    fn directory(&self, out: &Path) -> Result<ResultDirectory, Error> {
        ResultDirectory::create_for(Contents::Localized, out, self.force)
    }

    pub fn wave(&self, order: usize) -> Result<Wave, Error> {
        self.family().search(order)?.wave(order)
    }
}

/// Runs the command.
pub fn run(typed: Localize) -> Result<(), Failure> {
    let is_launched = typed.launch.is_some() && typed.out.is_some();
    let draws = typed.profile.is_some() || is_launched;
    let needed = "`--profile`, or `--launch` and `--out`,";
    typed.figures.refuse_without(draws, needed)?;
    use_threads(typed.threads.map(usize::from))?;
    match (typed.profile, typed.launch) {
        (Some(order), _) => profile::run(&typed, order),
        (None, Some(order)) => launch::run(&typed, order),
        (None, None) => table::run(&typed),
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
    #[arg(long, value_parser = parse::measure::<Length>, allow_negative_numbers = true)]
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
