//! `cascade localize`: ratios that carry localized waves, one wave, and its travel along a chain.

use std::ops::RangeInclusive;

use clap::ArgGroup;
use wavecascade::arrays::Precision;
use wavecascade::chain::contact::{Ellipse, Material};
use wavecascade::localized::{
    Alternation, Comparison, Cylinders, Family, LARGEST_ORDER, Orders, Profile, Wave,
};
use wavecascade::measure::{Length, Pressure};
use wavecascade::report::{ArrayFormat, localized_snippet, write_beside};

use crate::prelude::*;

const OUT: &str = "Directory for the results: summary.json, the page and its picture, beside table.csv and the waves, or the \
    arrays of the one wave. Without it nothing is written, but for `--profile` localized-N";

/// What `cascade localize` takes.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("written").multiple(true).args(["out", "profile"]))]
#[command(mut_arg("out", |arg| arg.help(OUT)))]
#[command(mut_arg("open", |arg| arg.requires("written")), mut_arg("show", |arg| arg.requires("written")))]
pub struct Localize {
    /// Orders, both ends included, from 1, the homogeneous chain, to 60.
    #[arg(long, value_name = "N|FIRST..LAST", default_value = "1..8", value_parser = orders)]
    pub order: RangeInclusive<usize>,
    /// What alternates along the dimer.
    #[arg(long, value_enum, default_value_t = Of::Stiffness)]
    pub alternation: Of,
    /// p of the contact law `F = c delta^p`.
    #[arg(long, default_value_t = 1.5, value_parser = parse::finite)]
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
    #[command(flatten)]
    pub result: ResultArgs,
}

choice!(Of => Alternation { Stiffness, Mass });

choice!(Form => Ellipse {
    /// The published `b/a = (A/B)^(2/3)`.
    Approximate,
    /// From the transcendental equation.
    Exact,
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
    fn family(&self) -> Family {
        Family {
            alternation: self.alternation.into(),
            exponent: self.exponent,
        }
    }

    fn comparison(&self) -> Result<Comparison, Error> {
        let strikes = self.direct || self.angles;
        let body = self.body.radius.zip(self.body.material()?);
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

/// Writes the script, and each wave's arrays, of a table.
fn write_waves(waves: &[Wave], directory: &Path) -> Result<(), Error> {
    write_beside(directory, "plot.py", localized_snippet().as_bytes())?;
    waves.iter().try_for_each(|wave| {
        let name = format!("wave-{:02}", wave.order);
        let archive = ArrayFormat::Npz.create(directory, &name, Precision::F64)?;
        let profile = Profile::of(wave.clone(), HALF_OF_MANY);
        profile.describe().write_to(&*archive)?;
        archive.finish()
    })
}

impl Describing for Localize {
    fn about(&self) -> About<'_> {
        let order = self.profile.or(self.launch);
        About {
            out: self
                .profile
                .map(|order| format!("localized-{order}").into()),
            subject: order.map_or("dimer".into(), |order| format!("order {order}")),
            ..About::of("localize", &self.result.how, [], "")
        }
    }

    /// The table, or the one wave that is requested.
    fn find(&self, _: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let wave = |order: usize| self.family().search(order)?.wave(order);
        if let Some(order) = self.profile {
            return Ok(Found::of(Profile::of(wave(order)?, HALF)));
        }
        if let Some(order) = self.launch {
            let cells = self.cells.unwrap_or(TRAVELLED);
            return Ok(Found::of(wave(order)?.journey(cells, observer)?));
        }
        let comparison = self.comparison()?;
        let rows = comparison.run(observer)?;
        let waves: Vec<Wave> = rows.iter().filter_map(|row| row.wave.clone()).collect();
        let unresolved = rows.iter().filter(|row| row.exact.is_none()).count();
        Ok(Found {
            beside: Box::new(move |directory| write_waves(&waves, directory)),
            failed: (unresolved > 0).then(|| {
                format!("{unresolved} of the orders could not be resolved; the others stand")
            }),
            ..Found::of(Orders { comparison, rows })
        })
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
          requires = "radius")]
    pub young: Option<f64>,

    /// Poisson's ratio of both.
    #[arg(long, value_parser = parse::finite, requires = "young")]
    pub poisson: Option<f64>,

    /// Radius of both, such as 9mm.
    #[arg(long, value_parser = parse::measure::<Length>, requires = "angles")]
    pub radius: Option<f64>,
}

impl Body {
    /// The material that was named or given by its constants.
    fn material(&self) -> Result<Option<Material>, Error> {
        if let (Some(young), Some(poisson)) = (self.young, self.poisson) {
            return Ok(Some(Material {
                young,
                poisson,
                // No contact depends on it.
                density: 1.0,
            }));
        }
        let named = self.material.as_ref().map(|name| {
            let expected = "quartz, steel or ptfe";
            Material::named(name).ok_or_else(|| Error::request("material", expected, name))
        });
        named.transpose()
    }
}
