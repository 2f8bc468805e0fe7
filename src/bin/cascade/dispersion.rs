//! `--dispersion`: what is typed to relations of the library, with what a run says of its lattice.

use std::path::Path;

use wavecascade::analyze::{Constants, Dispersion, parse_constants};
use wavecascade::chain::scene::Setup;
use wavecascade::chain::{NoBranches, UnitCell};
use wavecascade::field::is_run_file;
use wavecascade::report::RunFile;
use wavecascade::{Error, Field};

use crate::args::Analyze;
use crate::failure::Failure;

/// The relations to draw over the spectrum of the field of a file; `None` leaves the choice to the field.
pub fn of(typed: &Analyze, path: &Path, field: &Field) -> Result<Option<Vec<Dispersion>>, Failure> {
    stated(typed, lattice(path, field)?, field)
}

/// The same of a field that may carry the lattice of a run.
pub fn stated(
    typed: &Analyze,
    lattice: Option<Result<UnitCell, NoBranches>>,
    field: &Field,
) -> Result<Option<Vec<Dispersion>>, Failure> {
    let typed_relations = &typed.dispersion.dispersion;
    let branches = |cell: &UnitCell| Dispersion::lattice(name(cell), cell.clone(), None);
    if typed_relations.is_empty() {
        return Ok(match (&field.dispersion, lattice) {
            (None, Some(Ok(cell))) => Some(vec![branches(&cell)]),
            _ => None,
        });
    }
    if typed_relations.iter().any(|one| one == "none") {
        return match typed_relations.len() {
            1 => Ok(Some(Vec::new())),
            _ => Err(Error::request("dispersion", "none alone, or relations", "both").into()),
        };
    }
    let known = constants(typed, &lattice)?;
    let mut relations = Vec::new();
    for one in typed_relations {
        if one != "auto" {
            relations.push(read(one, &known)?);
            continue;
        }
        match (&lattice, &field.dispersion) {
            (_, Some(stated)) => relations.push(Dispersion::parse(stated, &Constants::new())?),
            (Some(Ok(cell)), None) => relations.push(branches(cell)),
            (Some(Err(reason)), None) => eprintln!("note: no dispersion branches: {reason}"),
            (None, None) => eprintln!(
                "note: no dispersion branches: the field carries no chain, and its sidecar states \
                 no `dispersion`"
            ),
        }
    }
    Ok(Some(relations))
}

/// The lattice of a run, with time in the unit of the field's axis; `None` for other fields.
fn lattice(path: &Path, field: &Field) -> Result<Option<Result<UnitCell, NoBranches>>, Failure> {
    if !is_run_file(path)? {
        return Ok(None);
    }
    let (setup, step) = RunFile::read_scene(path)?;
    Ok(Some(of_chain(&setup, step, field)))
}

/// The lattice of a chain whose run has times so far apart, with time in the unit of the field's axis.
pub fn of_chain(setup: &Setup, step: f64, field: &Field) -> Result<UnitCell, NoBranches> {
    let cell = UnitCell::of(&setup.simulation.chain);
    cell.map(|cell| cell.with_time_unit(step / field.time.step))
}

fn name(cell: &UnitCell) -> String {
    let with = match cell.branches() > cell.bodies() {
        true => " with resonators",
        false => "",
    };
    match cell.bodies() {
        1 => format!("lattice{with}, linearized"),
        bodies => format!("lattice of {bodies} bodies a cell{with}, linearized"),
    }
}

/// The constants typed, over those of a run of equal bodies.
fn constants(
    typed: &Analyze,
    lattice: &Option<Result<UnitCell, NoBranches>>,
) -> Result<Constants, Failure> {
    let mut known = Constants::new();
    if let Some(Ok(cell)) = lattice
        && let Some((m, c)) = cell.uniform()
    {
        known.extend([("c".to_owned(), c), ("m".to_owned(), m)]);
    }
    if let Some(text) = &typed.dispersion.dispersion_constants {
        known.extend(parse_constants(text)?);
    }
    Ok(known)
}

/// A relation that is typed, or that of a table.
pub fn read(one: &str, known: &Constants) -> Result<Dispersion, Error> {
    let path = Path::new(one);
    let extension = path.extension().unwrap_or_default();
    match extension.eq_ignore_ascii_case("csv") {
        true => Dispersion::read_csv(path),
        false => Dispersion::parse(one, known),
    }
}
