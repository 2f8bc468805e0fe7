//! `--open` and `--show`: the page in the browser, the main picture in the terminal.

#[cfg(target_os = "linux")]
#[test]
fn val_the_page_is_what_the_browser_gets() {
    use std::os::unix::fs::PermissionsExt;
    use std::time::{Duration, Instant};

    let place = test_support::pulse::place();
    let browser = place.path("xdg-open");
    std::fs::write(
        &browser,
        "#!/bin/sh\nprintf %s \"$1\" > opened.partial\nmv opened.partial opened\n",
    )
    .unwrap();
    std::fs::set_permissions(&browser, std::fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:/usr/bin:/bin", place.folder().display());
    for (words, page) in [
        ("increments wave.npy --open", "wave-increments/report.html"),
        (
            "analyze wave.npy --only temporal --open",
            "wave-cascade/report.html",
        ),
    ] {
        let mut run = place.command(words.split(' '));
        let output = run.env("PATH", &path).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        // It runs by itself.
        let began = Instant::now();
        while !place.path("opened").exists() && began.elapsed() < Duration::from_secs(30) {
            std::thread::sleep(Duration::from_millis(20));
        }
        assert_eq!(place.read("opened"), page);
        std::fs::remove_file(place.path("opened")).unwrap();
    }
    // Without a browser the result is there all the same.
    let mut run = place.command("increments wave.npy --open --force".split(' '));
    let output = run.env("PATH", "").output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let said = test_support::place::text(&output.stderr);
    assert!(said.contains("no browser could be started"), "{said}");
}

#[test]
fn regress_what_cannot_be_shown_is_refused_before_the_work() {
    let place = test_support::pulse::place();
    for (words, expected) in [
        (
            "increments wave.npy --show",
            "--show: expected a terminal to draw in, found standard output that is a file or a pipe",
        ),
        (
            "increments wave.npy --show --figures svg",
            "--show: expected `png` among `--figures`",
        ),
        (
            "increments wave.npy --open --figures none",
            "--open: expected figures",
        ),
        ("localize --open", "--out"),
        ("attenuate --ratios 2 --show", "--out"),
    ] {
        place.refuses_for(2, words, expected);
        assert!(!place.path("wave-increments").exists(), "{words}");
        assert!(!place.path("fields-cascade").exists(), "{words}");
    }
}
