//! Sums over a part of the realisations of an estimate, as a file.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Archive, ArrayFile, ArrayLabels};
use crate::arrays::Precision;
use crate::error::{Error, Result};
use crate::estimates::{Partial, PartialAbout};
use crate::field::{Members, read_members};

/// The schema of partial results.
pub const PARTIAL_SCHEMA: &str = "cascade.part/3";

/// What the file says of itself.
#[derive(Serialize, Deserialize)]
struct Stored {
    schema: String,
    /// BLAKE3 hash of the arrays.
    checksum: String,
    about: PartialAbout,
}

fn checksum(sums: &[f64]) -> String {
    let mut hasher = blake3::Hasher::new();
    for number in sums {
        hasher.update(&number.to_le_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

/// Writes a partial result to the new file `path` (`.npz`): the text `part`, JSON with the request, the axes,
/// the range of segments and a checksum; `sums`, the state of each tile of sites after another.
///
/// # Errors
/// [`Error::Write`].
pub fn write_partial(path: &Path, partial: &Partial) -> Result<()> {
    let stored = Stored {
        schema: PARTIAL_SCHEMA.into(),
        checksum: checksum(&partial.sums),
        about: partial.about.clone(),
    };
    let text = serde_json::to_string(&stored).map_err(std::io::Error::from);
    let archive = Archive::create(path, Precision::F64)?;
    archive.append_text("part", &text.map_err(Error::write("describe", path))?)?;
    let axes = [("sums", partial.sums.len())];
    archive.append(&ArrayLabels::of("sums", &axes), &partial.sums)?;
    archive.finish()
}

/// What a partial result is part of, without its sums.
///
/// # Errors
/// [`Error::Unfit`] for a file that is no partial result; those of reading.
pub fn read_partial_about(path: &Path) -> Result<PartialAbout> {
    read_members(path, |members| Ok(stored(path, members)?.about))
}

/// A partial result.
///
/// # Errors
/// [`Error::Unfit`] for a file that is no partial result, or damaged; those of reading.
pub fn read_partial(path: &Path) -> Result<Partial> {
    read_members(path, |members| {
        let stored = stored(path, members)?;
        let sums = array(path, members, "sums")?;
        if checksum(&sums) != stored.checksum {
            return Err(unfit(
                path,
                "the sums that were written",
                "others: a damaged file",
            ));
        }
        Ok(Partial {
            about: stored.about,
            sums,
        })
    })
}

fn unfit(path: &Path, expected: &str, found: &str) -> Error {
    Error::Unfit {
        path: path.to_owned(),
        expected: expected.into(),
        found: found.into(),
    }
}

fn stored(path: &Path, members: &mut Members) -> Result<Stored> {
    const EXPECTED: &str = "a partial result of an estimate";
    let text = members.text("part")?;
    let text = text.ok_or_else(|| unfit(path, EXPECTED, "an archive without `part`"))?;
    let stored: Stored =
        serde_json::from_str(&text).map_err(|error| unfit(path, EXPECTED, &error.to_string()))?;
    if stored.schema != PARTIAL_SCHEMA {
        let expected = format!("the layout {PARTIAL_SCHEMA:?}");
        let found = format!("the layout {:?}", stored.schema);
        return Err(unfit(path, &expected, &found));
    }
    Ok(stored)
}

fn array(path: &Path, members: &mut Members, name: &str) -> Result<Vec<f64>> {
    let found = members.array(name)?;
    let missing = || unfit(path, &format!("an array `{name}`"), "none");
    found.map(|(_, values)| values).ok_or_else(missing)
}
