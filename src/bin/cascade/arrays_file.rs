//! The file of a result's arrays, in the format that was chosen.

use wavecascade::Result;
use wavecascade::arrays::Precision;
use wavecascade::report::{Archive, ArrayFile, ArrayFormat, NetCdf, ResultDirectory};

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

    /// Ends the file, of NetCDF with what `describe` adds.
    pub fn finish(self, describe: impl FnOnce(&NetCdf)) -> Result<()> {
        match self {
            ArraysFile::Npz(archive) => archive.finish(),
            ArraysFile::NetCdf(file) => {
                describe(&file);
                file.finish()
            }
        }
    }
}
