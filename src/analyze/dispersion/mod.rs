//! Dispersion relations to hold `S(k, f)` against: of a lattice, of a formula, of a table.

mod table;

use std::f64::consts::{PI, TAU};
use std::path::Path;

use super::{Axes, Request};
use crate::chain::UnitCell;
use crate::error::{Error, Result};
use crate::field::Field;
pub use crate::formula::Constants;
use crate::formula::{self, Words};
use crate::sheet::Curve;
use table::Table;

/// Intervals of k on which curves are computed; a multiple of the bodies of common cells, so that
/// the ends of their zones are among the points.
const INTERVALS: usize = 960;

const WORDS: Words = Words {
    variable: "k",
    option: "dispersion",
};

/// A dispersion relation `omega(k)`, not yet on the axes of a field.
///
/// - Of a lattice: the branches of a [`UnitCell`] at the phase `q = k a` per body, in the extended
///   zone: a cell of p bodies gives p branches, each of period `2 pi / (p a)` in k.
/// - Of a formula: omega, in rad per unit of time, of k, in rad per unit of length.
/// - Of a table: columns of k and of omega or f, linear in between.
///
/// `f = omega / (2 pi)`. A field of real samples has a wave of negative omega at `(-k, -omega)`,
/// where it is drawn. Where omega is not finite, a curve has a gap.
#[derive(Debug, Clone, PartialEq)]
pub struct Dispersion {
    /// What figures call it.
    pub name: String,
    relation: Relation,
}

#[derive(Debug, Clone, PartialEq)]
enum Relation {
    Lattice {
        cell: UnitCell,
        /// Distance of bodies; `None`: that of the field's sites.
        spacing: Option<f64>,
    },
    Formula {
        text: String,
        constants: Constants,
    },
    Table(Table),
}

/// A dispersion relation on the axes of a field.
#[derive(Debug, Clone, PartialEq)]
pub struct DispersionCurve {
    pub name: String,
    /// Wavenumbers in rad per unit of length, ascending, from one Nyquist wavenumber to the other.
    pub wavenumber: Vec<f64>,
    /// Frequencies in cycles per unit of time, 0 or more, one row a branch; NaN in gaps.
    pub branches: Vec<Vec<f64>>,
}

impl DispersionCurve {
    /// Each branch as a curve over a map, the first with the name of its relation.
    pub(crate) fn curves(relations: &[DispersionCurve]) -> Vec<Curve> {
        let of_relation = |relation: &DispersionCurve| -> Vec<Curve> {
            let mut label = relation.name.clone();
            let branches = relation.branches.iter().map(|branch| Curve {
                label: std::mem::take(&mut label),
                points: std::iter::zip(relation.wavenumber.clone(), branch.clone()).collect(),
            });
            branches.collect()
        };
        relations.iter().flat_map(of_relation).collect()
    }
}

impl Dispersion {
    /// The branches of a lattice whose bodies are `spacing` apart; `None`: as the field's sites.
    pub fn lattice(name: impl Into<String>, cell: UnitCell, spacing: Option<f64>) -> Dispersion {
        Dispersion {
            name: name.into(),
            relation: Relation::Lattice { cell, spacing },
        }
    }

    /// Reads what is typed: `monatomic:c=1,m=1`, `diatomic:c1=1,c2=2,m1=1,m2=1`, both with `a` for
    /// a distance of bodies that is not that of the sites, or a formula such as
    /// `2*sqrt(c/m)*abs(sin(k*a/2)); c=1, m=1`.
    ///
    /// `known` are further constants of formulas, which those in the text override; `a` is the
    /// distance of the field's sites where neither gives it.
    ///
    /// # Errors
    /// [`Error::Request`] names the fault with its place, and what is known.
    pub fn parse(text: &str, known: &Constants) -> Result<Dispersion> {
        if let Some((kind @ ("monatomic" | "diatomic"), values)) = text.split_once(':') {
            return of_bodies(kind, text, &parse_constants(values)?);
        }
        let (formula, own) = text.split_once(';').unwrap_or((text, ""));
        let mut constants = known.clone();
        constants.extend(parse_constants(own)?);
        let name = formula.trim().to_owned();
        // The distance of sites is known with the field.
        at_sites(&name, &constants, 1.0)?;
        let text = name.clone();
        let relation = Relation::Formula { text, constants };
        Ok(Dispersion { name, relation })
    }

    /// Reads a table of comma-separated values: a column `k`, and columns `omega` or `f`, each
    /// with its unit in brackets if it is not that of the field (`k (rad/mm)`, `f (kHz)`).
    ///
    /// Several columns are several branches; so are the values of a column `curve`. k rises along
    /// a branch, and an empty cell is a gap. A table without negative k holds for both signs.
    ///
    /// # Errors
    /// [`Error::Read`]; [`Error::Unfit`] names the line or column at fault.
    pub fn read_csv(path: &Path) -> Result<Dispersion> {
        let name = path.file_name().unwrap_or_default();
        Ok(Dispersion {
            name: name.to_string_lossy().into(),
            relation: Relation::Table(Table::read(path)?),
        })
    }

    /// On the axes of a field.
    ///
    /// # Errors
    /// [`Error::Unfit`] for units of a table that do not fit those of the axes.
    pub(crate) fn on(&self, axes: &Axes) -> Result<DispersionCurve> {
        let site = axes.space.step;
        let nyquist = PI / site;
        let points = (0..=INTERVALS).map(|n| 2.0 * n as f64 / INTERVALS as f64 - 1.0);
        let wavenumber: Vec<f64> = points.map(|part| nyquist * part).collect();
        let omega = match &self.relation {
            Relation::Lattice { cell, spacing } => {
                let a = spacing.unwrap_or(site);
                let at: Vec<_> = wavenumber.iter().map(|k| cell.frequencies(k * a)).collect();
                let branch = |n: usize| at.iter().map(|omega| omega[n]).collect();
                (0..cell.branches()).map(branch).collect()
            }
            Relation::Formula { text, constants } => {
                let node = at_sites(text, constants, site)?;
                vec![wavenumber.iter().map(|&k| node.at(k)).collect()]
            }
            Relation::Table(table) => table.branches(axes, &wavenumber)?,
        };
        let branches = omega.into_iter().flat_map(both_directions);
        Ok(DispersionCurve {
            name: self.name.clone(),
            wavenumber,
            branches: branches.collect(),
        })
    }
}

/// A formula where sites are `spacing` apart, unless it states so.
fn at_sites(text: &str, constants: &Constants, spacing: f64) -> Result<formula::Node> {
    let mut constants = constants.clone();
    constants.entry("a".into()).or_insert(spacing);
    formula::parse(text, &constants, WORDS)
}

/// The values of a formula, such as [`Dispersion::parse`] reads, at each k.
///
/// # Errors
/// [`Error::Request`] names the fault with its place.
pub(crate) fn formula_values(text: &str, constants: &Constants, k: &[f64]) -> Result<Vec<f64>> {
    let node = formula::parse(text, constants, WORDS)?;
    Ok(k.iter().map(|k| node.at(*k)).collect())
}

/// The curves that a request, else the field, states for `S(k, f)`.
pub(super) fn curves(
    field: &Field,
    request: &Request,
    axes: &Axes,
) -> Result<Vec<DispersionCurve>> {
    if !request.results.spacetime {
        return Ok(Vec::new());
    }
    let stated = match (&request.dispersion, &field.dispersion) {
        (Some(requested), _) => requested.clone(),
        (None, Some(text)) => vec![Dispersion::parse(text, &Constants::new())?],
        (None, None) => Vec::new(),
    };
    stated.iter().map(|of| of.on(axes)).collect()
}

/// Reads `c=1, m=2.5`.
///
/// # Errors
/// [`Error::Request`] for a name that a formula knows otherwise, or a value that is no number.
pub fn parse_constants(text: &str) -> Result<Constants> {
    formula::parse_constants(text, WORDS)
}

/// A lattice of one or of two bodies a cell, from its constants.
fn of_bodies(kind: &str, text: &str, constants: &Constants) -> Result<Dispersion> {
    let [stiff, heavy]: [&[&str]; 2] = match kind {
        "diatomic" => [&["c1", "c2"], &["m1", "m2"]],
        _ => [&["c"], &["m"]],
    };
    let needed = [stiff, heavy].concat();
    // In the order of the alphabet, too.
    let others = constants.keys().filter(|name| *name != "a");
    if !others.eq(&needed) || constants.values().any(|value| *value <= 0.0) {
        let needed = needed.join(", ");
        let expected = format!(
            "`{kind}:` with {needed} and, where it is not the distance of the sites, a, all above 0"
        );
        return Err(Error::request("dispersion", expected, format!("`{text}`")));
    }
    let values = |names: &[&str]| names.iter().map(|name| constants[*name]).collect();
    let cell = UnitCell::new(values(heavy), values(stiff))?;
    Ok(Dispersion::lattice(text, cell, constants.get("a").copied()))
}

/// The parts of a branch, in cycles, at positive and at negative omega, the latter at `(-k, -omega)`; one
/// where both are the same.
fn both_directions(omega: Vec<f64>) -> Vec<Vec<f64>> {
    let cycles = |w: f64| Some(w / TAU).filter(|f| *f >= 0.0 && f.is_finite());
    let or_gap = |f: Option<f64>| f.unwrap_or(f64::NAN);
    let forward: Vec<f64> = omega.iter().map(|w| or_gap(cycles(*w))).collect();
    // Zero belongs to the former.
    let backward = omega.iter().rev().map(|w| cycles(-w).filter(|_| *w < 0.0));
    let backward: Vec<f64> = backward.map(or_gap).collect();
    let are_alike = |f: &f64, b: &f64| (f - b).abs() <= 1e-9 * b;
    let mut both = forward.iter().zip(&backward);
    match both.any(|(f, b)| b.is_finite() && !are_alike(f, b)) {
        true => vec![forward, backward],
        false => vec![forward],
    }
}
