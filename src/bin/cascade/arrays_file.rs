//! The file of a result's arrays, in the format that was chosen.

use wavecascade::Result;
use wavecascade::analyze::Analysis;
use wavecascade::arrays::Precision;
use wavecascade::budget::Budget;
use wavecascade::report::{
    Archive, ArrayFile, ArrayFormat, NetCdf, ResultDirectory, describe_analysis, describe_budget,
    write_budget_arrays,
};
use wavecascade::sheet::Describe;

/// A file of arrays while they are computed.
pub enum ArraysFile {
    Npz(Archive),
    NetCdf(NetCdf),
}

impl ArraysFile {
    /// `spectra.npz` or `spectra.nc` for the arrays `spectra`.
    pub fn create(
        directory: &ResultDirectory,
        arrays: &str,
        format: ArrayFormat,
        precision: Precision,
    ) -> Result<ArraysFile> {
        let path = directory.path().join(format.file_name(arrays));
        Ok(match format {
            ArrayFormat::Npz => ArraysFile::Npz(Archive::create(&path, precision)?),
            ArrayFormat::NetCdf => ArraysFile::NetCdf(NetCdf::create(&path, precision)?),
        })
    }

    /// Where the arrays go; as a [`wavecascade::arrays::Sink`], the large ones.
    pub fn arrays(&self) -> &dyn ArrayFile {
        match self {
            ArraysFile::Npz(archive) => archive,
            ArraysFile::NetCdf(file) => file,
        }
    }

    /// Adds all that is known once an analysis is done.
    pub fn finish(self, analysis: &Analysis, summary: &serde_json::Value) -> Result<()> {
        analysis.describe().write_to(self.arrays())?;
        match self {
            ArraysFile::Npz(archive) => archive.finish(),
            ArraysFile::NetCdf(file) => {
                describe_analysis(analysis, summary, &file);
                file.finish()
            }
        }
    }

    /// Adds all that is known once a budget is computed.
    pub fn finish_budget(self, budget: &Budget, summary: &serde_json::Value) -> Result<()> {
        write_budget_arrays(budget, self.arrays())?;
        match self {
            ArraysFile::Npz(archive) => archive.finish(),
            ArraysFile::NetCdf(file) => {
                describe_budget(budget, summary, &file);
                file.finish()
            }
        }
    }
}
