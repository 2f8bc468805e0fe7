//! The program as a stranger meets it: help, and how it fails on what it cannot take, read or write.

use std::fs;

use test_support::contains_all;
use test_support::place::Place;

#[test]
fn help_and_manuals_are_there() {
    let place = Place::new();
    let version = place.good(&["--version"]);
    assert_eq!(version, format!("cascade {}\n", env!("CARGO_PKG_VERSION")));
    for (words, holds) in [
        (&["--help"][..], "analyze"),
        (&["analyze", "--help"], "sidecar"),
        (&["analyze", "--help"], "--window-time"),
        (&["analyze", "-h"], "cascade analyze scan.npy"),
        (&["analyse", "-h"], "--dt"),
        (&["-h"], "Estimate, with intervals:"),
        (&["examples"], "growing_harmonic"),
        (&["completions", "bash"], "complete"),
        (&["completions", "zsh"], "#compdef cascade"),
        (&["completions", "fish"], "complete -c cascade"),
        (&["man"], ".TH"),
        (&["man", "analyze"], "window\\-time"),
    ] {
        let said = place.good(words);
        assert!(said.contains(holds), "{words:?}: {said}");
    }
    assert!(place.bad(2, &["man", "bogus"]).contains("analyze"));
    assert!(place.bad(2, &["completions", "bogus"]).contains("zsh"));
    assert!(place.bad(2, &["analyze"]).contains("<FIELD>"));
}

/// What is written is read, in the words that are printed.
#[test]
fn examples_are_written_and_lead_to_an_answer() {
    let place = Place::new();
    let said = place.good(&["examples", "growing_harmonic"]);
    let expected = "wrote growing_harmonic.npz; next: cascade analyze growing_harmonic.npz";
    assert!(said.contains(expected), "{said}");
    let said = place.says("analyze growing_harmonic.npz --figures none");
    contains_all(&said, &["energy moves up in frequency along x"]);
    let said = place.good(&["examples", "linear_chain"]);
    contains_all(&said, &["cascade simulate linear_chain.toml"]);
    place.says("scene --check linear_chain.toml");
    for name in ["growing_harmonic", "linear_chain"] {
        assert!(place.bad(2, &["examples", name]).contains("--force"));
        place.good(&["examples", name, "--force"]);
    }
    assert!(place.bad(2, &["examples", "dimr"]).contains("dimer"));
}

/// What newcomers type, and the word of the answer that helps.
#[test]
fn natural_mistakes_are_answered_with_what_to_type() {
    let place = test_support::pulse::place();
    place.write("scene.toml", "sites = 8\nstiffnes_ratio = 3\n");
    for (typed, code, expected) in [
        ("wave.npy", 2, "cascade analyze wave.npy"),
        ("analyze", 2, "<FIELD>"),
        ("analize wave.npy", 2, "subcommand exists: 'analyze'\n"),
        ("plot wave.npy", 2, "cascade"),
        ("analyze wave", 1, "check the path"),
        ("analyze wave.npy --dt 0", 2, "above 0"),
        ("analyze wave.npy --dt 1e-5m", 2, "s, ms, us"),
        ("analyze wave.npy --fs 1 --dt 1", 2, "--rate"),
        ("analyze wave.npy --output here", 2, "--out"),
        ("analyze wave.npy --help-me", 2, "--help"),
        ("analyze wave.npy --window hann", 2, "--window-time"),
        ("analyze wave.npy --window-time hanning", 2, "hann"),
        ("analyze wave.npy --figures pdf", 2, "svg"),
        ("analyze scene.toml", 1, "cascade simulate"),
        ("simulate wave.npy", 2, "cascade analyze wave.npy"),
        ("fit dimer.toml wave.npy", 2, "cascade fit FIELD SCENE"),
        ("filter wave.npy --band 1:2", 2, "--frequency 2kHz:6kHz"),
        (
            "filter wave.npy --low-pass 2kHz",
            2,
            "--frequency 2kHz:6kHz",
        ),
        ("simulate --ratio 3", 2, "`--stiffness-ratio`"),
        ("sweep --vary stiffness_ratio=1-10 --out s", 2, "1:10:19"),
        (
            "spectrum wave.npy --segment 100000",
            2,
            "4 samples to the 96 of the record",
        ),
        ("simulate dimer.toml", 1, "cascade examples dimer"),
        ("scene.toml", 2, "cascade simulate scene.toml"),
        ("analyze wave.npy --dt 1ms --noise 1mm", 2, "mm/s"),
        ("simulate scene.toml", 2, "stiffness_ratio"),
        ("simulate --stiffness-ration 3", 2, "--stiffness-ratio"),
        (
            "budget wave.npy",
            2,
            "cascade budget wave.npy --scene SCENE.toml",
        ),
        ("coherence wave.npy --reference 99", 2, "0 to 11"),
    ] {
        place.refuses_for(code, typed, expected);
    }
}

/// One option of each kind of fault, with what the message must name.
#[test]
fn options_that_do_not_fit_are_named_with_what_was_expected_and_found() {
    let place = test_support::pulse::place();
    for (options, expected) in [
        ("--segment 97", &["--segment", "1 to 96", "97"][..]),
        ("--overlap 3", &["--segment"]),
        ("--sites 3:13", &["--sites", "0:12", "3:13"]),
        ("--sites 5", &["--sites", "FIRST:END"]),
        ("--times 0.5:0.1", &["--times", "lower one first"]),
        (
            "--times 0:1 --until-arrival",
            &["--times", "--until-arrival"],
        ),
        (
            "--window-time bartlet",
            &["--window-time", "hann", "bartlet"],
        ),
        (
            "--window-time dpss:49",
            &["--window-time", "below 48.5", "49"],
        ),
        (
            "--reference-time 1",
            &["--reference-time", "0 to 0.95", "1"],
        ),
        ("--short-time-hop 0", &["--short-time-hop", "0"]),
        ("--threads 100000", &["--threads", "1024", "100000"]),
        ("--memory lots", &["--memory", "2GiB", "lots"]),
        (
            "--pad-time 1000000000000000",
            &["memory", "TiB", "--memory"],
        ),
        ("--dt -1", &["--dt", "above 0", "-1"]),
        ("--only everything", &["--only", "temporal", "everything"]),
    ] {
        let said = place.refuses(2, &format!("analyze wave.npy {options}"));
        contains_all(&said, expected);
    }
}

#[test]
fn inputs_that_cannot_be_read_are_named_with_advice() {
    let place = test_support::pulse::place();
    let whole = fs::read(place.path("wave.npy")).unwrap();
    place.write("cut.npy", &whole[..whole.len() / 2]);
    place.write("worded.npy", &whole);
    place.write("worded.toml", "dt = 0.01\ndz = 1.0\n");
    let mut holes = test_support::pulse::wave(96, 12);
    holes[[10, 3]] = f64::NAN;
    place.save("holes.npy", &holes);
    for (name, expected) in [
        ("missing.npy", "No such file"),
        ("cut.npy", "truncated"),
        ("worded.toml", "dz"),
        ("holes.npy", "--gaps interpolate"),
    ] {
        let field = name.replace("toml", "npy");
        for options in ["", "--json", "--quiet"] {
            let said = place.refuses(1, &format!("analyze {field} {options}"));
            assert!(said.contains(name) && said.contains(expected), "{said}");
            assert!(said.contains("\nhelp: "), "{name}: {said}");
        }
    }
    place.says("analyze holes.npy --gaps interpolate -q");
}

#[test]
fn places_that_cannot_be_written_are_named_with_advice() {
    let place = test_support::pulse::place();
    for out in ["wave.npy/result", "wave.npy/deep/result", "/proc/result"] {
        let said = place.refuses(1, &format!("analyze wave.npy --out {out}"));
        let folder = out.rsplit_once('/').unwrap().0;
        assert!(said.contains(folder) && said.contains("--out"), "{said}");
    }
    // Directories made on the way go again.
    place.refuses(1, "analyze missing.npy --out a/b/result");
    place.refuses(2, "analyze wave.npy --out a/b/result --pad-time 2");
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::process::{Command, Output};
    use test_support::place::{NO_CONFIGURATION, program, text};
    use test_support::running::start;

    fn shell(place: &Place, script: &str) -> Output {
        Command::new("sh")
            .envs(NO_CONFIGURATION)
            .args(["-c", script, "sh"])
            .arg(program())
            .current_dir(place.folder())
            .output()
            .unwrap()
    }

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
        use std::os::unix::ffi::OsStrExt;

        let place = test_support::pulse::place();
        let name = OsStr::from_bytes(b"wave\xff.npy");
        fs::rename(place.path("wave.npy"), place.path(name)).unwrap();
        let out = ["--out", "result"];
        let mut command = place.command(["analyze"]);
        command.arg(name).args(out).assert().success();
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_file_system_leaves_nothing() {
        let place = test_support::pulse::place();
        fs::create_dir(place.path("disk")).unwrap();
        let mount = "mount -t tmpfs -o size=256k none disk";
        let privileged = |script: &str| {
            Command::new("unshare")
                .envs(NO_CONFIGURATION)
                .args(["-rm", "sh", "-c", script, "sh"])
                .arg(program())
                .current_dir(place.folder())
                .output()
        };
        if !privileged(mount).is_ok_and(|output| output.status.success()) {
            eprintln!("SKIPPED: this machine does not let a test mount a file system");
            return;
        }
        for figures in ["none", "png"] {
            let options = format!("--memory 1GB --pad-time 3000 --figures {figures}");
            let script = format!(
                "{mount} && \"$1\" analyze wave.npy --out disk/full {options}; \
                                  echo \"$?\"; ls -A disk"
            );
            let output = privileged(&script).unwrap();
            let said = text(&output.stderr);
            assert_eq!(text(&output.stdout), "1\n", "{said}");
            contains_all(&said, &["No space left", "free some space"]);
        }
    }
}
