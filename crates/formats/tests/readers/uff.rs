//! Universal files of many records.

use std::sync::Arc;
use wavecascade_formats::{Format, Options, open};

use super::common::values;

/// A data set 58 in ASCII with even or uneven abscissas.
fn ascii(count: usize, uneven: bool, first: f64) -> String {
    let mut text = format!(
        "    -1\n    58\nname\nNONE\nNONE\nNONE\nNONE\n{:5}{:10}{:5}{:10} {:<10}{:10}{:4} {:<10}{:10}{:4}\n",
        1, 0, 0, 0, "NONE", 7, 3, "NONE", 1, 3
    );
    let even = usize::from(!uneven);
    text += &format!(
        "{:10}{count:10}{even:10}{:13.5e}{:13.5e}{:13.5e}\n",
        4, 0.0, 1.0, 0.0
    );
    for (kind, unit) in [(17, "s"), (11, "m/s"), (0, "NONE"), (0, "NONE")] {
        text += &format!("{kind:10}{:5}{:5}{:5} {:<20} {unit:<20}\n", 0, 0, 0, "NONE");
    }
    for i in 0..count {
        if uneven {
            text += &format!("{:13.4e}", first * (i * i + 1) as f64);
        }
        text += &format!("{:20.11e}\n", count as f64 + i as f64 / 8.0);
    }
    text + "    -1\n"
}

/// Shapes in any order: functions of one are one variable, in the order of the file.
#[test]
fn regress_functions_of_many_shapes() {
    const SHAPES: usize = 200;
    let shapes = |uneven: bool| (1..=SHAPES).map(move |count| ascii(count, uneven, 1.0));
    let mut text: String = (0..2)
        .flat_map(|_| shapes(false).chain(shapes(true)))
        .collect();
    // Zeros of both signs are one abscissa; another scale is another one.
    text += &(ascii(3, true, -0.0) + &ascii(3, true, 0.0) + &ascii(3, true, 2.0));
    let container = open(
        Format::Uff,
        Arc::new(text.into_bytes()),
        &Options::default(),
    )
    .unwrap();
    let records: Vec<_> = container
        .variables
        .iter()
        .filter(|v| v.path.starts_with("/records/"))
        .collect();
    let shapes: Vec<Vec<u64>> = records.iter().map(|v| v.shape()).collect();
    let each = (1..=SHAPES as u64).map(|count| vec![2, count]);
    let mut expected: Vec<Vec<u64>> = each.clone().chain(each).collect();
    expected.extend([vec![2, 3], vec![1, 3]]);
    assert_eq!(shapes, expected);
    assert_eq!(
        values(&container, "/records/3"),
        [3.0, 3.125, 3.25, 3.0, 3.125, 3.25]
    );
    let last = format!("/abscissa/{}", 2 * SHAPES + 2);
    assert_eq!(values(&container, &last), [2.0, 4.0, 10.0]);
}
