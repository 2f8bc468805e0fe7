//! Where settings files are looked for.

use std::path::{Path, PathBuf};

use super::keys::Kind;

/// Settings of this kind beside what a command reads, or here. A file that is read itself, or is the
/// sidecar of a field of that name, is none.
pub fn beside(kind: Kind, input: Option<&Path>) -> Option<PathBuf> {
    let path = match input {
        Some(input) => input.with_file_name(kind.file_name()),
        None => kind.file_name().into(),
    };
    let is_input = |input: &Path| input == path || input.with_extension("toml") == path;
    let is_there = path.symlink_metadata().is_ok();
    (is_there && !input.is_some_and(is_input)).then_some(path)
}

/// The style of the home configuration.
pub fn style() -> Option<PathBuf> {
    let path = configuration()?
        .join("cascade")
        .join(Kind::Style.file_name());
    path.symlink_metadata().is_ok().then_some(path)
}

/// The user's folder for configurations; a relative one is ignored, as the XDG rules have it.
#[cfg(not(windows))]
fn configuration() -> Option<PathBuf> {
    let folder =
        |name| Some(PathBuf::from(std::env::var_os(name)?)).filter(|path| path.is_absolute());
    folder("XDG_CONFIG_HOME").or_else(|| Some(folder("HOME")?.join(".config")))
}

#[cfg(windows)]
fn configuration() -> Option<PathBuf> {
    let folder = PathBuf::from(std::env::var_os("APPDATA")?);
    folder.is_absolute().then_some(folder)
}
