//! Stiffness ratios of localized waves: Table 1 of the paper, beside the exact ones.
//!
//! Equation: that of `wavecascade::localized`.
//! Command: `cargo run --release -p figures --bin table1_stiffness_ratios`; seconds.
//! Shows: exact ratio and its error; estimates on the fitted and on the exact slow wave; the
//! paper's two columns and how far they are off. Writes `figures/out/table1_stiffness_ratios.csv`.
//! Asserts: the paper's direct column to 1e-4, its estimates to 0.1 %, and that its row 18 is
//! neither order 18 nor, in its direct value, order 19.

use std::fmt::Write;

use wavecascade::localized::{Family, PUBLISHED, SlowWave};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let family = Family::default();
    let search = family.search(19)?;
    let fitted = family.estimates(&SlowWave::fitted()?, 19)?;
    let mut table = String::from(
        "order,exact,relative_error,estimate_exact_profile,estimate_fitted_profile,paper_direct,paper_estimate\n",
    );
    for order in 1..=19 {
        let wave = search.wave(order)?;
        let estimate = search.estimate(order).ok_or("no estimate")?;
        let paper = PUBLISHED.iter().find(|row| row.order == order);
        let columns = paper.map_or(",".to_owned(), |p| format!("{},{}", p.direct, p.estimate));
        writeln!(
            table,
            "{order},{:.12},{:.1e},{estimate:.6},{:.6},{columns}",
            wave.ratio,
            wave.convergence.error(),
            fitted[order - 1],
        )?;
        if let Some(paper) = paper {
            let off = [
                paper.direct / wave.ratio - 1.0,
                paper.estimate / fitted[order - 1] - 1.0,
            ];
            let row = paper.printed_order;
            println!(
                "row {row}: direct {:+.1e}, estimate {:+.1e}",
                off[0], off[1]
            );
            assert!(off[1].abs() < 1e-3);
            assert_eq!(off[0].abs() < 1e-4, order <= 7);
        }
    }
    print!("{table}");
    let file = figures::root().join("figures/out/table1_stiffness_ratios.csv");
    let part = file.with_extension("part");
    std::fs::write(&part, table)?;
    std::fs::rename(&part, &file)?;
    Ok(())
}
