//! `cascade examples`: fields and scenes to try the program on, which come with it.

use clap::builder::PossibleValuesParser;
use wavecascade::chain::scene::{PRESETS, preset};
use wavecascade::reference::{GrowingHarmonic, LatticeImpact};
use wavecascade::report::{FieldFile, write_beside};

use crate::prelude::*;

/// A field that is computed where it is asked for.
struct ExampleField {
    name: &'static str,
    /// What it shows, in a line.
    shows: &'static str,
    make: fn() -> Field,
}

const FIELDS: [ExampleField; 2] = [
    ExampleField {
        name: "growing_harmonic",
        shows: "a burst in a noisy scan whose second harmonic grows: energy moves up",
        make: || GrowingHarmonic::EXAMPLE.field(),
    },
    ExampleField {
        name: "lattice_impact",
        shows: "a lattice of springs, struck: waves disperse, no energy moves",
        make: || {
            LatticeImpact {
                n_times: 768,
                n_sites: 96,
                dt: 0.125,
            }
            .field()
        },
    },
];

/// What `cascade examples` takes.
#[derive(Debug, Args)]
pub struct Examples {
    /// Write this one here, as NAME.npz or NAME.toml; without a name, list all.
    #[arg(value_name = "NAME", hide_possible_values = true, value_parser = PossibleValuesParser::new(names()))]
    pub name: Option<String>,

    /// Replace a file of that name.
    #[arg(long, requires = "name")]
    pub force: bool,
}

/// The names of all.
pub fn names() -> impl Iterator<Item = &'static str> {
    let fields = FIELDS.iter().map(|field| field.name);
    fields.chain(PRESETS.iter().map(|preset| preset.name))
}

/// Runs the command.
pub fn run(typed: Examples) -> Result<(), Failure> {
    let Some(name) = typed.name else {
        return list();
    };
    let next = match FIELDS.iter().find(|field| field.name == name) {
        Some(field) => {
            let path = PathBuf::from(format!("{name}.npz"));
            FieldFile::write(&path, typed.force, &(field.make)())?;
            format!("cascade analyze {name}.npz")
        }
        None => {
            write_scene(&name, typed.force)?;
            format!("cascade simulate {name}.toml; cascade analyze {name}.npz")
        }
    };
    let written = next.split([' ', ';']).nth(2).unwrap_or_default();
    Ok(writeln!(
        terminal::stdout(),
        "wrote {written}; next: {next}"
    )?)
}

fn write_scene(name: &str, replace: bool) -> Result<(), Error> {
    let file = format!("{name}.toml");
    if !replace && Path::new(&file).symlink_metadata().is_ok() {
        return Err(Error::Exists { path: file.into() });
    }
    let text = preset(name).map_or("", |preset| preset.text);
    write_beside(Path::new("."), &file, text.as_bytes()).map(|_| ())
}

fn list() -> Result<(), Failure> {
    let mut out = terminal::stdout();
    let width = names().map(str::len).max().unwrap_or(0);
    writeln!(out, "Fields, for `cascade analyze`:")?;
    for ExampleField { name, shows, .. } in &FIELDS {
        writeln!(out, "  {name:width$}  {shows}")?;
    }
    writeln!(out, "\nScenes, for `cascade simulate`:")?;
    for preset in PRESETS {
        writeln!(out, "  {:width$}  {}", preset.name, preset.shows)?;
    }
    Ok(writeln!(out, "\n`cascade examples NAME` writes one here.")?)
}
