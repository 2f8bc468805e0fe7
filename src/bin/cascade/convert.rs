//! `cascade convert`: a field in another format.

use serde_json::json;
use wavecascade::report::{FieldFile, records_json};

use crate::analyze::{open_options, print_notes};
use crate::fields::expanded;
use crate::prelude::*;
use crate::scan_args::ScanArgs;
use crate::terminal::print_json;

/// What `cascade convert` takes.
#[derive(Debug, Args)]
pub struct Convert {
    /// File with the field; with `--position-from` all files of a scan, or patterns such as `'scan/*.uff'`.
    #[arg(required = true, value_name = "IN")]
    pub fields: Vec<PathBuf>,

    /// File to write: .nc, .npz, .npy or .csv.
    #[arg(value_name = "OUT")]
    pub out: PathBuf,

    /// Replace an earlier field of this program.
    #[arg(long)]
    pub force: bool,

    /// Working memory, such as 500MB or 2GiB [default: half of the available memory]. What has to be decoded
    /// and is larger goes to a scratch file.
    #[arg(long, value_name = "SIZE", value_parser = parse::bytes)]
    pub memory: Option<u64>,

    /// Print what was written as JSON on standard output.
    #[arg(long)]
    pub json: bool,

    /// Print errors only.
    #[arg(long, short)]
    pub quiet: bool,

    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub scan: ScanArgs,
}

/// Runs the command on one file, or on the files of a scan.
pub fn run(typed: &Convert) -> Result<(), Failure> {
    let files = &expanded(&typed.fields)?;
    let out = &typed.out;
    typed.scan.check_files(files)?;
    check_extension(typed)?;
    // Before any work: could the result be written?
    FieldFile::check(out, typed.force)?;
    let progress = Progress::new(!typed.quiet);
    let options = open_options(&typed.input, typed.memory);
    let (field, records) = typed.scan.open(files, &options)?;
    print_notes(&field, typed.quiet);
    progress.begin_writing();
    FieldFile::write_observed(out, typed.force, &field, &progress)?;
    progress.clear();
    let (times, sites) = (field.n_times(), field.n_sites());
    let quantity = field.quantity.name();
    let precision = field.precision();
    if typed.json {
        let mut summary = json!({
            "file": out,
            "quantity": quantity,
            "shape": [times, sites],
            "precision": precision,
        });
        if let Some(records) = &records {
            summary["records"] = records_json(records);
        }
        print_json(&summary)?;
    } else if !typed.quiet {
        writeln!(
            terminal::stdout(),
            "wrote {}, {quantity} at {times} times and {sites} sites; next: cascade analyze {0}",
            out.display()
        )?;
    }
    Ok(())
}

/// Refuses a file whose name does not say which format it is to have.
fn check_extension(typed: &Convert) -> Result<(), Error> {
    let extension = typed.out.extension().unwrap_or_default();
    let extension = extension.to_ascii_lowercase();
    let mut all = FieldFile::EXTENSIONS.iter();
    if all.any(|known| extension == *known) {
        return Ok(());
    }
    let names = FieldFile::EXTENSIONS.map(|known| format!(".{known}"));
    let expected = format!("a name that ends in {}", names.join(", "));
    Err(unfit(&typed.out, expected, format!("{extension:?}")))
}
