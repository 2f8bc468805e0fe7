//! The file of an analysis' arrays, in the format that was chosen.

use wavecascade::analyze::Analysis;
use wavecascade::arrays::{Precision, Sink};
use wavecascade::report::{
    Archive, NetCdf, Provenance, ResultDirectory, SpectraFormat, write_labelled_arrays,
    write_small_arrays,
};

/// A file of arrays while the analysis runs.
pub enum SpectraFile {
    Npz(Archive),
    NetCdf(NetCdf),
}

impl SpectraFile {
    pub fn create(
        directory: &ResultDirectory,
        format: SpectraFormat,
        precision: Precision,
    ) -> wavecascade::Result<SpectraFile> {
        let path = directory.path().join(format.file_name());
        Ok(match format {
            SpectraFormat::Npz => SpectraFile::Npz(Archive::create(&path, precision)?),
            SpectraFormat::NetCdf => SpectraFile::NetCdf(NetCdf::create(&path, precision)?),
        })
    }

    /// Where the large arrays go.
    pub fn sink(&self) -> &dyn Sink {
        match self {
            SpectraFile::Npz(archive) => archive,
            SpectraFile::NetCdf(file) => file,
        }
    }

    /// Adds all that is known once the analysis is done.
    pub fn finish(self, analysis: &Analysis, provenance: &Provenance) -> wavecascade::Result<()> {
        match self {
            SpectraFile::Npz(archive) => {
                write_small_arrays(analysis, &archive)?;
                archive.finish()
            }
            SpectraFile::NetCdf(file) => {
                write_labelled_arrays(analysis, provenance, &file)?;
                file.finish()
            }
        }
    }
}
