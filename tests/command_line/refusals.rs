//! What cannot be done is refused with its code and a word that helps, and leaves nothing: a command a row of `refusals.txt`.

use std::fs;

use ndarray::Array2;
use test_support::fields::noise;
use test_support::made::pulse;
use test_support::place::{Place, text};

/// All that the rows name.
fn inputs() -> Place {
    let place = test_support::pulse::place();
    let whole = fs::read(place.path("wave.npy")).unwrap();
    let mut holes = test_support::pulse::wave(96, 12);
    holes[[10, 3]] = f64::NAN;
    place.save("holes.npy", &holes);
    place.save("a.npy", &pulse(64, 8));
    place.save("noise.npy", &noise(1024, 8));
    place.save("narrow.npy", &noise(1024, 3));
    place.save("still.npy", &Array2::<f64>::zeros((64, 4)));
    for (name, text) in [
        ("a.csv", "1,2\n5,1\n2,2\n"),
        ("nan.csv", "1,2\nnan,1\n2,2\n"),
        ("badcurve.csv", "k,f\n0,0\n1,fast\n"),
        ("unitcurve.csv", "k (rad/m),f\n0,0\n1,1\n"),
        ("worded.toml", "dt = 0.01\ndz = 1.0\n"),
        ("typo.toml", "sites = 8\nstiffnes_ratio = 3\n"),
        (
            "scene.toml",
            "sites = 8\ntangent = 0.02\nend_time = 12.0\nsamples = 200\n",
        ),
        (
            "chain.toml",
            "sites = 6\ncoefficients = [1, 1, 1, 1, 1, 1]\nend_time = 30.0\nsamples = 256\n",
        ),
        ("units.csv", "time [ms], force [N]\n0, 1\n"),
        ("twice.csv", "0 1\n1 2\n1 3\n"),
        ("word.csv", "0;1,5\n1;2,5\n2;x\n"),
        ("three.csv", "0 1\n1 2\n2 1\n"),
        ("gap.csv", "0 1\n1 2\n2 1\n3 2\n4 3\n5 4\n30 4\n"),
        ("five.csv", "0 1\n0 1\n0 1\n0 1\n0 1\n"),
        ("thesis.npz", "mine"),
        ("thesis.nc", "mine"),
    ] {
        place.write(name, text);
    }
    place.write("cut.npy", &whole[..whole.len() / 2]);
    place.write("worded.npy", &whole);
    place.write("zip.npz", b"PK\xff\xfe");
    fs::create_dir(place.path("full")).unwrap();
    place.write("full/thesis.tex", "");
    let beads = "--material steel --shape sphere --radius 9mm --striker-velocity 1 --end-time 1e-4";
    for run in [
        "--end-time 4 --out run.npz",
        "--end-time 4 --record force --out force.npz",
        &format!("{beads} --out si.npz"),
    ] {
        place.says(&format!("simulate --sites 4 --samples 65 --quiet {run}"));
    }
    place.says("coherence noise.npy --segment 64 --part 1/1 --out part --quiet");
    place
}

#[test]
fn regress_what_cannot_be_done_is_refused() {
    let place = inputs();
    let rows = include_str!("refusals.txt").lines();
    let mut wrong = Vec::new();
    for row in rows.filter(|row| !row.is_empty() && !row.starts_with('#')) {
        let parts: Vec<&str> = row.split(" | ").collect();
        let typed: Vec<String> = parts[1].split(' ').map(|w| w.replace('~', " ")).collect();
        let typed: Vec<&str> = typed.iter().map(String::as_str).collect();
        let before = place.names();
        let output = place.run(&typed);
        let said = text(&output.stderr);
        let holds = |word: &str| match word.strip_prefix("not ") {
            Some(word) => !said.contains(word),
            None => said.contains(word),
        };
        let is_right = output.status.code() == parts[0].parse().ok()
            && output.stdout.is_empty()
            && said.starts_with("error: ")
            && place.names() == before
            && parts[2].split(" ; ").all(holds);
        if !is_right {
            wrong.push(format!("{row}\n{:?} {said}", output.status.code()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
