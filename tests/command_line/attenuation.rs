//! `cascade attenuate` as a stranger meets them.

use std::fs;
use std::process::{Command, Stdio};

use serde_json::Value;
use test_support::place::Place;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// Killed at any moment, both kinds of curves and sweeps go on to the identical table; `CASCADE_KILLS` requests more
/// kills than ten.
#[test]
fn regress_killed_ten_times() {
    let kills = std::env::var("CASCADE_KILLS");
    let kills: u64 = kills.map_or(10, |text| text.parse().unwrap());
    let place = Place::new();
    let key = "attenuate --sites 31 --against stiffness_ratio=1:30:30log";
    let length = "attenuate --ratios 1.5,2,2.5,3,4,5,6,7 --bodies 24";
    let sweep = "sweep --sites 12 --end-time 20 --samples 240 --vary stiffness_ratio=1:120:60log";
    for (name, words, table) in [
        ("key", key, "curves.csv"),
        ("length", length, "curves.csv"),
        ("sweep", sweep, "table.csv"),
    ] {
        let command = |out: &str| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_cascade"));
            command
                .current_dir(place.folder())
                .args(words.split(' '))
                .args(["--threads", "2", "--out", &format!("{name}-{out}")])
                .stdout(Stdio::null())
                .stderr(Stdio::null());
            command
        };
        let of = |out: &str, file: &str| fs::read(place.path(format!("{name}-{out}")).join(file));
        let known = |out: &str| {
            let text = of(out, "members.jsonl").unwrap_or_default();
            text.iter().filter(|b| **b == b'\n').count()
        };
        assert!(command("whole").status().unwrap().success());
        let (mut kept, mut midway) = (0, 0);
        for _ in 0..kills {
            let mut child = command("killed").spawn().unwrap();
            // As soon as it has computed something more.
            while known("killed") == kept && child.try_wait().unwrap().is_none() {
                std::thread::yield_now();
            }
            child.kill().unwrap();
            child.wait().unwrap();
            assert!(known("killed") >= kept, "what was computed is kept");
            kept = known("killed");
            midway += u64::from(0 < kept && kept < known("whole"));
        }
        assert!(midway > 0, "{name}: no kill hit the work");
        assert!(command("killed").status().unwrap().success());
        let table = |out| of(out, table).unwrap();
        assert_eq!(table("killed"), table("whole"));
        let numbers = |out| {
            let mut all = json(&String::from_utf8(of(out, "summary.json").unwrap()).unwrap());
            // The command differs by its folder.
            all["provenance"].take();
            all
        };
        assert_eq!(numbers("killed"), numbers("whole"));
    }
}

/// A digit that changed in what was kept is computed again.
#[test]
fn regress_what_was_kept_and_is_damaged_is_computed_again() {
    let place = Place::of(&["attenuate"]);
    for (words, folder) in [
        (
            "--ratios 2.4 --bodies 7 --sense wall --lengths 3,7 --json --out length",
            "length",
        ),
        (
            "--sites 9 --against stiffness_ratio=1,2,4 --json --out key",
            "key",
        ),
    ] {
        let whole = place.says(words);
        let path = place.path(format!("{folder}/members.jsonl"));
        let kept = fs::read_to_string(&path).unwrap();
        fs::write(&path, kept.replacen('3', "4", 40)).unwrap();
        assert_eq!(place.says(words), whole, "{folder}");
    }
}
