//! `cascade lomb` as a stranger runs it.

use test_support::place::Place;

#[test]
fn regress_uneven_times_are_refused_elsewhere_and_taken_here() {
    let place = Place::new();
    let rows = (0..60).map(|n| {
        let t = f64::from(n) + if n % 4 == 1 { 0.3 } else { 0.0 };
        let gap = if n % 7 == 3 {
            "nan".to_owned()
        } else {
            (0.6 * t).cos().to_string()
        };
        format!("{t},{gap},{}\n", (1.1 * t).sin())
    });
    std::fs::write(
        place.path("record.csv"),
        format!("time,a,b\n{}", rows.collect::<String>()),
    )
    .unwrap();
    let said = place.bad(1, &["analyze", "record.csv"]);
    assert!(said.contains("cascade lomb"), "{said}");
    let text = place.good(&[
        "lomb",
        "record.csv",
        "--out",
        "record-lomb",
        "--figures",
        "png",
    ]);
    assert!(text.contains("2 of 2 records"), "{text}");
    let summary = place.json("record-lomb/summary.json");
    assert_eq!(
        (&summary["missing"], &summary["schema"]),
        (&8.into(), &"cascade.lomb/1".into())
    );
    for (column, omega) in [(0, 0.6), (1, 1.1)] {
        let column = &summary["columns"][column];
        let f = column["frequency"].as_f64().unwrap();
        assert!((std::f64::consts::TAU * f - omega).abs() < 0.02, "{column}");
        assert!(column["false_alarm"].as_f64().unwrap() < 1e-9);
    }
    for name in ["lomb.npz", "report.html", "figures/lomb.png"] {
        assert!(place.path(format!("record-lomb/{name}")).exists(), "{name}");
    }
    let said = place.bad(2, &["lomb", "record.csv", "--force", "--highest", "0"]);
    assert!(said.contains("--highest"), "{said}");
    let said = place.bad(2, &["lomb", "record.csv", "--force", "--oversampling", "0"]);
    assert!(said.contains("--oversampling"), "{said}");
}
