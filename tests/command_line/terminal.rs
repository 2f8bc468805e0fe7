//! Text on a terminal and without one: widths, colors.

use test_support::place::{Place, text};

/// Commands whose summaries are looked at, once their inputs are there.
const COMMANDS: [&str; 7] = [
    "analyze wave.npy --figures none --force",
    "budget run.npz --figures none --force",
    "compare run.npz other.npz --force",
    "simulate --sites 5 --end-time 4 --samples 65 --force",
    "localize --order 1..3",
    "attenuate --ratios 2,4.9 --bodies 6",
    "attenuate --sites 7 --against stiffness_ratio=1:4:3 --no-extremes",
];

fn place() -> Place {
    let place = test_support::pulse::place();
    for (name, ratio) in [("run", "2"), ("other", "3")] {
        let out = format!("{name}.npz");
        let words = "simulate --sites 5 --end-time 4 --samples 65 --quiet --stiffness-ratio";
        let words: Vec<&str> = words.split(' ').chain([ratio, "--out", &out]).collect();
        place.good(&words);
    }
    place
}

#[test]
fn lines_keep_to_the_width_that_is_stated() {
    let place = place();
    for columns in [50, 80] {
        for command in COMMANDS {
            let mut run = place.command(command.split(' '));
            let output = run.env("COLUMNS", columns.to_string()).output().unwrap();
            assert!(output.status.success(), "{command}: {output:?}");
            let said = text(&output.stdout);
            let long = said.lines().find(|line| line.chars().count() > columns);
            assert_eq!(long, None, "{command} at {columns}:\n{said}");
            assert!(
                said.lines().all(|line| line == line.trim_end()),
                "{command}:\n{said}"
            );
        }
        for command in ["", "analyze", "budget", "filter", "localize", "scene"] {
            for help in ["-h", "--help"] {
                let words = command.split_whitespace().chain([help]);
                let mut run = place.command(words);
                let said = run.env("COLUMNS", columns.to_string()).output().unwrap();
                let said = text(&said.stdout);
                // A word, such as the name of an option with its value, is never broken.
                let is_long =
                    |line: &&str| line.chars().count() > columns && line.trim().contains(' ');
                let long = said
                    .lines()
                    .filter(is_long)
                    .find(|line| !line.contains("--"));
                assert_eq!(long, None, "{command} {help}");
            }
        }
    }
}

#[test]
fn colors_are_forced_and_turned_off() {
    let place = place();
    let said = |words: &str, environment: &[(&str, &str)]| {
        let mut command = place.command(words.split(' '));
        let output = command.envs(environment.iter().copied()).output().unwrap();
        text(&output.stdout) + &text(&output.stderr)
    };
    let forced = [("CLICOLOR_FORCE", "1")];
    for words in [
        COMMANDS[0],
        COMMANDS[4],
        "analyze missing.npy",
        "analyze wave.npy --dt 0",
    ] {
        assert!(!said(words, &[]).contains('\x1b'), "{words}");
        let colored = said(words, &forced);
        assert!(colored.contains("\x1b[1m"), "{words}: {colored:?}");
        // Nothing but colors differs.
        let plain = anstream::adapter::strip_str(&colored).to_string();
        let first = |text: &str| text.lines().next().unwrap().to_owned();
        assert_eq!(first(&plain), first(&said(words, &[])), "{words}");
        assert!(
            !said(words, &[("NO_COLOR", "1")]).contains('\x1b'),
            "{words}"
        );
    }
}
