//! The program as a stranger meets it: help, and how it fails on what it cannot take, read or write.

#[cfg(unix)]
mod unix {
    use test_support::place::text;
    use test_support::running::{shell, start};

    #[test]
    fn a_reader_that_goes_away_is_no_failure() {
        let place = test_support::pulse::place();
        let words = ["analyze", "wave.npy", "--json", "--figures", "none"];
        for words in [&words[..], &["man", "analyze"], &["completions", "zsh"]] {
            let mut child = start(&place, words);
            drop(child.stdout.take());
            let output = child.wait_with_output().unwrap();
            assert_eq!(output.status.code(), Some(0));
            assert_eq!(text(&output.stderr), "");
        }
        assert!(place.path("wave-cascade/summary.json").exists());
        let script = "\"$1\" analyze wave.npy -o b --figures none >&- 2>&-";
        let closed = shell(&place, script);
        assert_eq!(closed.status.code(), Some(0));
        assert!(place.path("b/summary.json").exists());
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn output_that_cannot_be_written_is_a_failure() {
        let place = test_support::pulse::place();
        let full = shell(&place, "\"$1\" analyze wave.npy --figures none >/dev/full");
        assert_eq!(full.status.code(), Some(1));
        assert!(text(&full.stderr).contains("standard output"), "{full:?}");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_name_that_is_no_text_is_still_a_name() {
        use std::ffi::OsStr;
        use std::fs;
        use std::os::unix::ffi::OsStrExt;

        let place = test_support::pulse::place();
        let name = OsStr::from_bytes(b"wave\xff.npy");
        fs::rename(place.path("wave.npy"), place.path(name)).unwrap();
        let out = ["--out", "result"];
        let mut command = place.command(["analyze"]);
        command.arg(name).args(out).assert().success();
    }
}
