//! Long runs as a stranger meets them: interrupted, changed below, short of memory, on a terminal.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::fs;
use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use test_support::place::{Place, program, text, wait_for_handler};
use test_support::running::{signal, sparse, start, wait_for};

/// Sends `name` and expects the end that a shell gives such a signal, with nothing left.
fn ends(place: &Place, mut child: Child, name: &str, before: &BTreeSet<String>) {
    signal(&child, name);
    let status = child.wait().unwrap();
    let mut said = String::new();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    let code = if name == "TERM" { 143 } else { 130 };
    assert_eq!(status.code(), Some(code), "{name}: {said}");
    assert_eq!(said, "error: cancelled; nothing was written\n");
    assert_eq!(&place.names(), before, "{name}");
}

/// While results are written, some milliseconds after that began, or as soon as interrupts are handled.
#[test]
fn an_interrupt_ends_a_run_and_leaves_nothing() {
    let place = Place::new();
    sparse(&place, "long.npy", 40_000, 400);
    let before = place.names();
    let analyze = "analyze long.npy --out new/long";
    for (name, line, wait) in [
        ("INT", analyze, Some(0)),
        ("TERM", analyze, Some(100)),
        ("INT", analyze, Some(300)),
        ("INT", "convert long.npy long.csv", None),
        (
            "INT",
            "simulate --sites 3000 --end-time 1e6 --samples 3 --out x/run.npz",
            None,
        ),
    ] {
        let mut child = start(&place, &line.split(' ').collect::<Vec<_>>());
        match wait {
            Some(wait) => {
                // The place is tried before the field is read, and is gone again for a moment.
                let written = || {
                    let mut entries = fs::read_dir(place.path("new")).into_iter().flatten();
                    entries.any(|entry| entry.is_ok_and(|e| e.path().join("spectra.npz").exists()))
                };
                wait_for(&mut child, written);
                std::thread::sleep(Duration::from_millis(wait));
            }
            None => wait_for_handler(&mut child),
        }
        ends(&place, child, name, &before);
    }
}

/// Pages of the field count as memory that is allowed, and so do those of the program.
#[test]
#[cfg(target_os = "linux")]
fn a_field_larger_than_memory_keeps_to_it() {
    use test_support::running::peak;

    const ALLOWED: u64 = 100_000_000;
    let place = Place::new();
    sparse(&place, "large.npy", 8192, 2048);
    let words = "analyze large.npy --only temporal --figures none --threads 2 --memory 100MB";
    let (output, peak) = peak(start(&place, &words.split(' ').collect::<Vec<_>>()));
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!((ALLOWED / 2..ALLOWED).contains(&peak), "{peak}");
}

#[test]
#[cfg(target_os = "linux")]
fn an_interrupt_while_the_input_is_hashed_ends_at_once() {
    let place = Place::new();
    // 40 GiB of nothing take seconds to hash, and no disk.
    sparse(&place, "huge.npy", 5 << 20, 1 << 10);
    let before = place.names();
    for name in ["INT", "TERM"] {
        let mut child = start(&place, &["analyze", "huge.npy", "--memory", "1TB"]);
        let listens = format!("/proc/{}/task", child.id());
        wait_for(&mut child, || {
            fs::read_dir(&listens).is_ok_and(|t| t.count() > 2)
        });
        ends(&place, child, name, &before);
    }
}

/// On a terminal a bar may come; it goes again, and lines keep to the width.
#[test]
#[cfg(target_os = "linux")]
fn on_a_terminal_the_bar_goes_away_again() {
    let place = test_support::pulse::place();
    sparse(&place, "long.npy", 20_000, 60);
    let script = |columns: u32, command: &str| {
        let line = format!(
            "stty cols {columns} rows 40; {} {command}",
            program().display()
        );
        Command::new("script")
            .args(["-qec", &line, "/dev/null"])
            .stdin(Stdio::null())
            .current_dir(place.folder())
            .output()
    };
    let Ok(short) = script(80, "analyze wave.npy --figures none") else {
        eprintln!("SKIPPED: this machine has no `script` to make a terminal with");
        return;
    };
    let said = anstream::adapter::strip_str(&text(&short.stdout)).to_string();
    assert!(short.status.success(), "{said}");
    assert!(!said.contains("transforming"), "{said}");
    assert!(
        said.lines()
            .all(|line| line.trim_end().chars().count() <= 80),
        "{said}"
    );
    assert!(
        !said.contains("left"),
        "a run this short shows no bar: {said:?}"
    );
    let long = script(120, "analyze long.npy --figures none").unwrap();
    let said = text(&long.stdout);
    assert!(long.status.success(), "{said}");
    let last = said.lines().last().unwrap();
    assert!(last.contains("done in") && !last.contains('█'), "{last:?}");
}
