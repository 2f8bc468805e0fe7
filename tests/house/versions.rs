//! One version: of all packages, of what is cited, and of the first section of the changelog.

use std::fs;

use crate::rooms::root;

fn text(file: &str) -> String {
    fs::read_to_string(root().join(file)).unwrap()
}

/// What stands behind `mark` in the first line that begins with it.
fn after<'a>(text: &'a str, mark: &str) -> &'a str {
    let mut found = text.lines().filter_map(|line| line.strip_prefix(mark));
    found.next().unwrap_or_default()
}

#[test]
fn regress_one_version_everywhere() {
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(after(&text("CITATION.cff"), "version: "), version);
    let section = text("CHANGELOG.md");
    let section = after(&section, "## ");
    assert!(
        section.split(',').next() == Some(version),
        "CHANGELOG.md begins with {section}"
    );
    assert!(text("README.md").contains(&format!("{version}, commit COMMIT")));
    let manifest = text("Cargo.toml");
    let own = manifest
        .lines()
        .filter(|line| line.contains("{ path = ") && line.contains("version = "));
    let own: Vec<&str> = own.collect();
    assert_eq!(own.len(), 4, "{own:?}");
    for line in own {
        assert!(line.contains(&format!("version = \"{version}\"")), "{line}");
    }
    for package in [
        "benches/throughput",
        "crates/column-fft",
        "crates/formats",
        "crates/system",
        "python",
    ] {
        let manifest = text(&format!("{package}/Cargo.toml"));
        assert!(
            manifest.contains("\nversion.workspace = true\n"),
            "{package} has a version of its own"
        );
    }
}
