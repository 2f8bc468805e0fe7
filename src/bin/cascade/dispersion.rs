//! `--dispersion`: what is typed to relations of the library, with what a run says of its lattice.

use wavecascade::analyze::{Constants, Dispersion, parse_constants};
use wavecascade::chain::UnitCell;

use crate::args::Analyze;
use crate::prelude::*;

/// The relations to draw over the spectrum of a field, which may be that of a chain; `None` leaves the choice to the field.
pub fn stated(
    typed: &Analyze,
    chain: Option<&Chain>,
    field: &Field,
) -> Result<Option<Vec<Dispersion>>, Error> {
    let typed_relations = &typed.dispersion.dispersion;
    // With time in the unit of the field's axis.
    let lattice = chain.map(|(setup, step)| {
        let cell = UnitCell::of(&setup.simulation.chain);
        cell.map(|cell| cell.with_time_unit(step / field.time.step))
    });
    let branches = |cell: &UnitCell| Dispersion::lattice(name(cell), cell.clone(), None);
    if typed_relations.is_empty() {
        return Ok(match (&field.dispersion, lattice) {
            (None, Some(Ok(cell))) => Some(vec![branches(&cell)]),
            _ => None,
        });
    }
    if typed_relations.iter().any(|one| one == "none") {
        let is_alone = typed_relations.len() == 1;
        Error::require(is_alone, "dispersion", "none alone, or relations", "both")?;
        return Ok(Some(Vec::new()));
    }
    // Constants that are typed, over those of a run of equal bodies.
    let mut known = Constants::new();
    if let Some(Ok(cell)) = &lattice
        && let Some((m, c)) = cell.uniform()
    {
        known.extend([("c".to_owned(), c), ("m".to_owned(), m)]);
    }
    if let Some(text) = &typed.dispersion.dispersion_constants {
        known.extend(parse_constants(text)?);
    }
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

/// A relation that is typed, or that of a table.
pub fn read(one: &str, known: &Constants) -> Result<Dispersion, Error> {
    let path = Path::new(one);
    let extension = path.extension().unwrap_or_default();
    match extension.eq_ignore_ascii_case("csv") {
        true => Dispersion::read_csv(path),
        false => Dispersion::parse(one, known),
    }
}
