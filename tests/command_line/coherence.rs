//! `cascade coherence` as a stranger runs it.

use ndarray::{Array2, s};
use test_support::fields::noise;
use test_support::place::Place;

/// A site that follows its neighbour three samples later, in noise, and one that does not.
#[test]
fn regress_a_delay_is_found_and_written() {
    let place = Place::new();
    let source = noise(4100, 4);
    let values = Array2::from_shape_fn((4096, 3), |(n, j)| match j {
        0 => source[[n + 3, 0]] + 0.2 * source[[n, 1]],
        1 => source[[n, 0]] + 0.2 * source[[n, 2]],
        _ => source[[n, 3]],
    });
    place.save("field.npy", &values);
    let said = place.says("coherence field.npy --dt 10us --figures png");
    let first = said.lines().next().unwrap();
    let facts = [
        "1 of 2 sites coherent with site 0",
        "3.00",
        "e-5 s",
        "(95 %)",
    ];
    assert!(facts.iter().all(|fact| first.contains(fact)), "{first}");
    let summary = place.json("field-coherence/summary.json");
    let delay = &summary["delays"][1];
    let number = |name: &str| delay[name].as_f64().unwrap();
    assert!(
        (number("delay") - 3e-5).abs() < 4.0 * number("error"),
        "{delay}"
    );
    assert!(number("error") < 1e-6 && number("interval") > number("error"));
    assert!(summary["delays"][2].is_null() && summary["velocity"].is_null());
    let coherence = place.array::<f64>("field-coherence/coherence.npz", "coherence");
    assert_eq!(coherence.shape(), [257, 3]);
    place.has("field-coherence", "report.html figures/coherence.png");
    // An existing result is replaced on request.
    let again = "coherence field.npy --multitaper 4,7 --figures none";
    place.refuses(2, again);
    place.says(&format!("{again} --force"));
    for (words, named) in [
        ("--reference 3", "--reference"),
        ("--multitaper 4", "NW,K"),
        ("--overlap 50%", "--segment"),
    ] {
        place.refuses_for(2, &format!("coherence field.npy {words} --force"), named);
    }
}

/// The first line says what is so: no site follows, all do at one velocity, or it cannot be told.
#[test]
fn regress_the_first_line_is_the_answer() {
    let place = Place::new();
    let random = noise(2400, 9);
    place.save("unrelated.npy", &random.slice(s![..2048, ..2]).to_owned());
    let travels = Array2::from_shape_fn((2048, 8), |(n, j)| {
        random[[n + 100 - 4 * j, 0]] + 0.05 * random[[n, j + 1]]
    });
    place.save("travels.npy", &travels);
    let pulse = Array2::from_shape_fn((2048, 4), |(n, j)| {
        (-((n as f64 - 300.0 - 5.0 * j as f64) / 6.0).powi(2)).exp()
    });
    place.save("pulse.npy", &pulse);
    let mut silent = random.clone();
    silent.column_mut(0).fill(0.0);
    place.save("silent.npy", &silent);
    for (file, fact) in [
        ("unrelated.npy", "0 of 1 sites coherent with site 0"),
        ("travels.npy", "7 of 7 sites coherent with site 0"),
        ("pulse.npy", "one transient"),
        ("silent.npy", "silent"),
    ] {
        let line = format!("coherence {file} --dt 1ms --dx 0.1m --figures none");
        let said = place.says(&line);
        let first = said.lines().next().unwrap();
        assert!(first.starts_with(&format!("{file}: ")), "{said}");
        assert!(first.contains(fact), "{first}");
        if let Some((_, velocity)) = first.split_once("towards +x at ") {
            let velocity: f64 = velocity.split(' ').next().unwrap().parse().unwrap();
            assert!((velocity - 25.0).abs() < 0.02, "{first}");
        }
        assert!(said.lines().count() <= 12, "{said}");
    }
}
