//! A directory of results that appears whole or not at all.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::new_file::is_there;
use crate::error::{Error, Result};
use crate::system::publish::{Working, write_whole};

/// Files are written to a directory beside the wanted one, which then gets its name:
/// [`ResultDirectory::publish`]. Dropped before that, it is removed with everything in it.
#[derive(Debug)]
pub struct ResultDirectory {
    wanted: PathBuf,
    working: Working,
    replace: bool,
}

/// What any result may have beside files of its own name.
const COMMON: &str =
    "summary.json report.html figures table.csv design.toml fitted.toml records.csv plot.py";

/// The file that describes the others.
const SUMMARY: &str = "summary.json";

/// The results whose files or figures are not called as they are, by the name of their schema: their arrays, without
/// extension, where numbers follow a dash, and their figures.
const OTHERWISE: [(&str, &str, &str); 5] = [
    (
        "analyze",
        "spectra",
        "space-time temporal-spectrum spatial-spectrum spacetime-spectrum along-x along-t short-time short-space \
         flux-surrogate",
    ),
    (
        "budget",
        "budget",
        "energies energy-flux energy-passed power-flow energy-spectrum spectral-flux scale-flux views",
    ),
    ("compare", "", "views"),
    ("localize", "wave-", "localize"),
    ("spacetime", "spectrum", "spectrum"),
];

/// Names of the arrays and the figures of a result.
fn names_of(result: &str) -> (&str, &str) {
    let known = OTHERWISE.iter().find(|(name, ..)| *name == result);
    known.map_or((result, result), |&(_, arrays, figures)| (arrays, figures))
}

fn is_in(names: &str, name: &str) -> bool {
    names.split(' ').any(|known| known == name)
}

/// Whether the directory of a result, by the name of its schema, may hold a file of this name; anything else in it is not
/// ours to remove.
fn may_hold(result: &str, name: &str) -> bool {
    let is_plot = name.starts_with("plot-") && name.ends_with(".png");
    let is_scene = result == "fit" && name == "fitted.toml";
    if is_in(COMMON, name) || is_plot || is_scene {
        return true;
    }
    let Some((stem, "npz" | "nc" | "csv")) = name.rsplit_once('.') else {
        return false;
    };
    let (arrays, _) = names_of(result);
    match stem.strip_prefix(arrays) {
        Some(digits) if arrays.ends_with('-') => {
            !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())
        }
        rest => rest == Some(""),
    }
}

/// The same of its folder of figures.
fn may_draw(result: &str, name: &str) -> bool {
    let Some((stem, "png" | "svg")) = name.rsplit_once('.') else {
        return false;
    };
    is_in(names_of(result).1, stem)
}

/// The name of a result in the schema of its summary.
fn result_of(summary: &str) -> Option<&str> {
    let (_, after) = summary.split_once("\"schema\": \"cascade.")?;
    Some(after.split_once('/')?.0)
}

impl ResultDirectory {
    /// Makes the working directory of an analysis; fails before any work is done.
    ///
    /// # Errors
    /// [`Error::Exists`] if a result is at `wanted` and is not to be replaced,
    /// [`Error::OutputInUse`] if something else is there (an empty directory may be);
    /// [`Error::Request`] if `wanted` has no name (`.`, `/`); [`Error::Write`] if nothing can be
    /// written beside it.
    pub fn create(wanted: &Path, replace: bool) -> Result<Self> {
        // A separator at the end would lead through a symbolic link.
        let wanted: PathBuf = wanted.components().collect();
        let expected = "a directory with a name, which the run makes";
        let has_name = wanted.file_name().is_some();
        Error::require(has_name, "out", expected, wanted.display())?;
        check_free(&wanted, replace)?;
        let working = Working::reserve(&wanted)
            .and_then(|working| working.create_directory().map(|()| working))
            .map_err(Error::write("create", &wanted))?;
        Ok(ResultDirectory {
            wanted,
            working,
            replace,
        })
    }

    /// Where to write.
    pub fn path(&self) -> &Path {
        self.working.path()
    }

    /// Writes one file of it.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> Result<()> {
        let path = self.path().join(name);
        write_whole(&path, contents.as_ref()).map_err(Error::write("write", &path))
    }

    /// Gives the directory its name, in place of an older one where that was allowed: the name is
    /// always that of the older or of the new one, on the disk too.
    ///
    /// # Errors
    /// [`Error::Exists`] or [`Error::OutputInUse`] if someone else was there first; [`Error::Write`].
    pub fn publish(mut self) -> Result<PathBuf> {
        let published = match check_free(&self.wanted, self.replace)? {
            Destination::Result => self.working.swap(),
            Destination::Free => self.working.publish(),
        };
        published.map_err(Error::write("finish", &self.wanted))?;
        Ok(self.wanted)
    }
}

/// What exists at the path of the result.
#[derive(Debug, PartialEq, Eq)]
enum Destination {
    /// Nothing, or an empty directory.
    Free,
    /// An earlier result.
    Result,
}

/// Refuses a place that is taken.
fn check_free(path: &Path, replace: bool) -> Result<Destination> {
    let occupied = |found: String| {
        Err(Error::OutputInUse {
            path: path.to_owned(),
            found,
        })
    };
    if !is_there(path, true)? {
        return Ok(Destination::Free);
    }
    let names = names(path)?;
    if names.is_empty() {
        return Ok(Destination::Free);
    }
    let summary = read_text(&path.join(SUMMARY))?;
    let Some(result) = result_of(&summary) else {
        return occupied(format!("holds {:?} and no {SUMMARY} of a run", names[0]));
    };
    if let Some(name) = names.iter().find(|name| !may_hold(result, name)) {
        return occupied(format!("holds {name:?}, which no run has written"));
    }
    let figures = path.join("figures");
    let drawn = if figures.is_dir() {
        self::names(&figures)?
    } else {
        Vec::new()
    };
    if let Some(name) = drawn.iter().find(|name| !may_draw(result, name)) {
        return occupied(format!(
            "holds \"figures/{name}\", which no run has written"
        ));
    }
    if replace {
        return Ok(Destination::Result);
    }
    Err(Error::Exists {
        path: path.to_owned(),
    })
}

/// Writes a file of a directory that keeps results, whole or not at all.
///
/// # Errors
/// [`Error::Write`].
pub fn write_beside(directory: &Path, name: &str, bytes: &[u8]) -> Result<PathBuf> {
    crate::system::journal::write_whole(directory, name, bytes)
}

/// The text of a file; none of a file that is not there or holds something else.
pub(super) fn read_text(path: &Path) -> Result<String> {
    match fs::read_to_string(path) {
        Ok(text) => Ok(text),
        Err(error) if [ErrorKind::NotFound, ErrorKind::InvalidData].contains(&error.kind()) => {
            Ok(String::new())
        }
        Err(error) => Err(Error::read("read", path)(error)),
    }
}

/// Whether a directory holds the results of one field, and nothing else.
pub(super) fn holds_result(path: &Path) -> bool {
    check_free(path, true).is_ok_and(|found| found == Destination::Result)
}

/// Names in the directory `path`, those that are no text changed so that they match nothing.
pub(super) fn names(path: &Path) -> Result<Vec<String>> {
    let entries = fs::read_dir(path).map_err(Error::read("list", path))?;
    entries
        .map(|entry| {
            let entry = entry.map_err(Error::read("list", path))?;
            Ok(entry.file_name().to_string_lossy().into_owned())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn appears_whole_or_not_at_all() -> std::result::Result<(), Box<dyn std::error::Error>> {
        let place = tempfile::tempdir()?;
        let wanted = place.path().join("out");
        let count = || fs::read_dir(place.path()).map(Iterator::count);

        let dropped = ResultDirectory::create(&wanted, false)?;
        dropped.write("a", "1")?;
        drop(dropped);
        assert_eq!(count()?, 0);

        let summary = r#"{ "schema": "cascade.analyze/1" }"#;
        let first = ResultDirectory::create(&wanted, false)?;
        first.write("summary.json", summary)?;
        first.publish()?;
        assert_eq!(fs::read_to_string(wanted.join("summary.json"))?, summary);
        let refused = ResultDirectory::create(&wanted, false);
        assert!(matches!(refused, Err(Error::Exists { .. })));

        let second = ResultDirectory::create(&wanted, true)?;
        second.write("report.html", "2")?;
        second.publish()?;
        assert!(!wanted.join("summary.json").exists() && wanted.join("report.html").exists());
        assert_eq!(count()?, 1);
        Ok(())
    }

    #[test]
    fn only_results_are_replaced() -> std::result::Result<(), Box<dyn std::error::Error>> {
        let place = tempfile::tempdir()?;
        let (file, folder) = (place.path().join("field.npy"), place.path().join("data"));
        fs::write(&file, "samples")?;
        fs::create_dir(&folder)?;
        fs::write(folder.join("notes.txt"), "mine")?;
        // Figures alone, and figures that no run has drawn beside those of one.
        let (paper, mixed) = (place.path().join("paper"), place.path().join("mixed"));
        fs::create_dir_all(paper.join("figures"))?;
        fs::create_dir_all(mixed.join("figures"))?;
        fs::write(
            mixed.join("summary.json"),
            r#""schema": "cascade.analyze/1""#,
        )?;
        fs::write(mixed.join("figures/mine.png"), "picture")?;
        for wanted in [&file, &folder, &paper, &mixed] {
            let refused = ResultDirectory::create(wanted, true);
            assert!(matches!(refused, Err(Error::OutputInUse { .. })));
        }
        let nameless = ResultDirectory::create(Path::new("."), true);
        assert!(matches!(nameless, Err(Error::Request { .. })));
        assert_eq!(fs::read_dir(place.path())?.count(), 4);
        Ok(())
    }

    #[test]
    fn parents_that_it_made_go_with_it() -> std::result::Result<(), Box<dyn std::error::Error>> {
        let place = tempfile::tempdir()?;
        let deep = place.path().join("a/b/out");
        drop(ResultDirectory::create(&deep, false)?);
        assert!(!place.path().join("a").exists());
        Ok(())
    }
}
