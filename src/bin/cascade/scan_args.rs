//! Files with one record each, as one field.

use wavecascade::field::{EqualPositions, OpenOptions, PositionFrom, Scan, ScanRecord};

use crate::prelude::*;

#[derive(Debug, Args)]
#[command(next_help_heading = "Scans: one record a file, one field")]
pub struct ScanArgs {
    /// Take all files as one field, one site a file, at positions from: the number in their `name` that
    /// differs (`name:x`: the one behind x), a number of their `header` (`header:NAME`), or a table
    /// (positions.csv) with the columns file and position.
    #[arg(long, value_name = "name|header|TABLE", value_parser = position_from)]
    pub position_from: Option<PositionFrom>,
    /// The record in each file, of files with several: an array or a column by name, or a column by its
    /// number from 0 [default: the only one, or the one beside the reference].
    #[arg(long, value_name = "CHANNEL", requires = "position_from")]
    pub channel: Option<String>,
    /// Align the records by the delay of this channel, such as that of a hammer, against that of the first
    /// site [default: by the times of the files].
    #[arg(long, value_name = "CHANNEL", requires = "position_from")]
    pub reference: Option<String>,
    /// Least correlation coefficient of the reference channels; less is an error [default: 0.7].
    #[arg(long, value_name = "NUMBER", value_parser = parse::finite, requires = "reference")]
    pub least_correlation: Option<f64>,
    /// What becomes of several records at one position [default: refuse].
    #[arg(long, value_enum, requires = "position_from")]
    pub equal_positions: Option<EqualPositionsArg>,
}

crate::args::choice!(EqualPositionsArg => EqualPositions {
    /// They are an error.
    Refuse,
    /// Their mean is taken, once they are aligned.
    Average,
});

/// `name`, `header`, both with `:NAME`, or the path of a table.
fn position_from(text: &str) -> Result<PositionFrom, String> {
    let (kind, asked) = match text.split_once(':') {
        Some((kind, asked)) => (kind, Some(asked.trim().to_owned())),
        None => (text, None),
    };
    match kind {
        "name" => Ok(PositionFrom::Name(asked)),
        "header" => Ok(PositionFrom::Header(asked)),
        _ => {
            let table = PathBuf::from(text);
            let extension = table.extension().unwrap_or_default().to_ascii_lowercase();
            match extension.to_str() {
                Some("csv" | "tsv" | "txt") => Ok(PositionFrom::Table(table)),
                _ => Err("expected name, header, or a table of text such as positions.csv".into()),
            }
        }
    }
}

impl ScanArgs {
    /// The scan, if one is typed.
    pub fn scan(&self) -> Option<Scan> {
        let mut scan = Scan::new(self.position_from.clone()?);
        scan.channel = self.channel.clone();
        scan.reference = self.reference.clone();
        scan.least_correlation = self.least_correlation.unwrap_or(scan.least_correlation);
        scan.equal_positions = self.equal_positions.map(Into::into).unwrap_or_default();
        Some(scan)
    }

    /// That several files are a scan, for commands that take one field.
    ///
    /// # Errors
    /// Several files without a scan.
    pub fn check_files(&self, files: &[PathBuf]) -> Result<(), Error> {
        let is_one = files.len() == 1 || self.position_from.is_some();
        let expected = "it beside several files, which it makes one field";
        let found = format!("{} files without it", files.len());
        Error::require(is_one, "position-from", expected, found)
    }

    /// The field of one file, or of all files of a scan with what was taken of each.
    pub fn open(
        &self,
        files: &[PathBuf],
        options: &OpenOptions,
    ) -> Result<(Field, Option<Vec<ScanRecord>>), Error> {
        match self.scan() {
            Some(scan) => {
                let scanned = scan.open(files, options)?;
                Ok((scanned.field, Some(scanned.records)))
            }
            None => Ok((Field::open(&files[0], options)?, None)),
        }
    }
}

/// The name of a result of several files: that of their folder.
pub fn folder_name(first: &Path) -> PathBuf {
    let folder = first.parent().and_then(Path::file_name);
    folder.unwrap_or("scan".as_ref()).into()
}
