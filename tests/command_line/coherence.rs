//! `cascade coherence` as a stranger runs it.

use ndarray::Array2;
use ndarray_npy::NpzReader;
use test_support::fields::noise;
use test_support::place::Place;

/// A site that follows its neighbour three samples later, in noise, and one that does not.
fn place() -> Place {
    let place = Place::new();
    let source = noise(4100, 4);
    let values = Array2::from_shape_fn((4096, 3), |(n, j)| match j {
        0 => source[[n + 3, 0]] + 0.2 * source[[n, 1]],
        1 => source[[n, 0]] + 0.2 * source[[n, 2]],
        _ => source[[n, 3]],
    });
    place.save("field.npy", &values);
    place
}

#[test]
fn regress_a_delay_is_found_and_written() {
    let place = place();
    let said = place.good(&["coherence", "field.npy", "--dt", "10us", "--figures", "png"]);
    // One of two sites follows, three samples of 10 us later; the other one does not.
    let first = said.lines().next().unwrap();
    let facts = [
        "field.npy: site 1 follows site 0",
        "3.00",
        "e-5 s",
        "(95 %)",
    ];
    assert!(facts.iter().all(|fact| first.contains(fact)), "{first}");
    let summary = place.json("field-coherence/summary.json");
    let delay = &summary["delays"][1];
    let (found, error) = (
        delay["delay"].as_f64().unwrap(),
        delay["error"].as_f64().unwrap(),
    );
    assert!(
        (found - 3e-5).abs() < 4.0 * error && error < 1e-6,
        "{delay}"
    );
    assert!(delay["ambiguity"].is_null() && delay["interval"].as_f64().unwrap() > error);
    assert_eq!(
        summary["is_coherent"],
        serde_json::json!([true, true, false])
    );
    assert!(summary["delays"][2].is_null() && summary["velocity"].is_null());
    assert!(summary["level"].as_f64().unwrap() > 0.1);
    let file = std::fs::File::open(place.path("field-coherence/coherence.npz")).unwrap();
    let mut archive = NpzReader::new(file).unwrap();
    let coherence: Array2<f64> = archive.by_name("coherence").unwrap();
    assert_eq!(coherence.dim(), (257, 3));
    let mean = |j: usize| coherence.column(j).mean().unwrap();
    assert!(mean(1) > 0.8 && mean(2) < 0.2, "{} {}", mean(1), mean(2));
    for name in ["report.html", "figures/coherence.png"] {
        assert!(place.path(format!("field-coherence/{name}")).exists());
    }
    // An existing result is replaced on request.
    let again = [
        "coherence",
        "field.npy",
        "--multitaper",
        "4,7",
        "--figures",
        "none",
    ];
    place.bad(2, &again);
    place.good(&[&again[..], &["--force"]].concat());
}

#[test]
fn regress_what_does_not_fit_is_refused_by_its_option() {
    let place = place();
    let before = place.names();
    for (words, named) in [
        ("--reference 3", "--reference"),
        ("--segment 5000", "--segment"),
        ("--multitaper 4,9", "--multitaper"),
        ("--multitaper 4", "NW,K"),
        ("--overlap 50%", "--segment"),
    ] {
        let words: Vec<&str> = ["coherence", "field.npy"]
            .into_iter()
            .chain(words.split(' '))
            .collect();
        let said = place.bad(2, &words);
        assert!(said.contains(named), "{words:?}: {said}");
        assert_eq!(place.names(), before, "{words:?}");
    }
}

#[test]
fn regress_a_silent_reference_is_said() {
    let place = Place::new();
    let mut field = noise(400, 3);
    field.column_mut(1).fill(0.0);
    place.save("field.npy", &field);
    let words = [
        "coherence",
        "field.npy",
        "--segment",
        "64",
        "--out",
        "out",
        "--reference",
        "1",
    ];
    let said = place.good(&words);
    let first = said.lines().next().unwrap();
    assert!(
        first.starts_with("field.npy: ") && first.contains("site 1, is silent"),
        "{said}"
    );
    assert!(
        said.contains("warning: ") && said.contains("--reference"),
        "{said}"
    );
}

/// The first line says what is so: no site follows, all do at one velocity, or it cannot be told.
#[test]
fn regress_the_first_line_is_the_answer() {
    let place = Place::new();
    let random = noise(2400, 9);
    place.save(
        "unrelated.npy",
        &random.slice(ndarray::s![..2048, ..2]).to_owned(),
    );
    let travels = Array2::from_shape_fn((2048, 8), |(n, j)| {
        random[[n + 100 - 4 * j, 0]] + 0.05 * random[[n, j + 1]]
    });
    place.save("travels.npy", &travels);
    let pulse = Array2::from_shape_fn((2048, 4), |(n, j)| {
        (-((n as f64 - 300.0 - 5.0 * j as f64) / 6.0).powi(2)).exp()
    });
    place.save("pulse.npy", &pulse);
    for (file, facts) in [
        ("unrelated.npy", &["no site follows site 0"][..]),
        (
            "travels.npy",
            &["all 7 sites follow site 0", "towards +x at ", "m/s (95 %)"],
        ),
        ("pulse.npy", &["one transient"]),
    ] {
        let words = [
            "coherence",
            file,
            "--dt",
            "1ms",
            "--dx",
            "0.1m",
            "--figures",
            "none",
        ];
        let said = place.good(&words);
        let first = said.lines().next().unwrap();
        assert!(first.starts_with(&format!("{file}: ")), "{said}");
        assert!(facts.iter().all(|fact| first.contains(fact)), "{first}");
        if let Some((_, velocity)) = first.split_once("towards +x at ") {
            let velocity: f64 = velocity.split(' ').next().unwrap().parse().unwrap();
            assert!((velocity - 25.0).abs() < 0.02, "{first}");
        }
        assert!(said.lines().count() <= 12, "{said}");
        assert!(!said.contains("effective realisations"), "{said}");
        let all = place.good(&[&words[..], &["--force", "--verbose"]].concat());
        assert!(all.contains("effective realisations"), "{all}");
    }
}
