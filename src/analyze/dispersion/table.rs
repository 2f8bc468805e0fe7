//! Dispersion curves from a table of comma-separated values.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use super::super::Axes;
use crate::error::{Error, Result};
use crate::measure::{Frequency, Length, Time, size};

/// Curves as a file lists them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    path: PathBuf,
    k_unit: Option<String>,
    curves: Vec<Curve>,
}

#[derive(Debug, Clone, PartialEq)]
struct Curve {
    is_cycles: bool,
    unit: Option<String>,
    /// Rising k with their frequencies; NaN in gaps.
    points: Vec<(f64, f64)>,
}

/// What a column of the table is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Column {
    Wavenumber,
    Omega,
    Cycles,
    Curve,
}

impl Column {
    /// With its unit: `k`, `k (rad/m)`, `omega`, `omega_2 [rad/s]`, `f (Hz)`, `frequency`, `curve`.
    fn of(header: &str) -> Option<(Column, Option<String>)> {
        let header = header.trim();
        let (name, unit) = match header.find(['(', '[']) {
            Some(at) => {
                let unit = header[at + 1..].strip_suffix([')', ']'])?.trim();
                (header[..at].trim(), Some(unit.to_owned()))
            }
            None => (header, None),
        };
        // A number after the name tells branches apart.
        let name = name.trim_end_matches(|c: char| c.is_ascii_digit());
        let column = match name.trim_end_matches('_').to_ascii_lowercase().as_str() {
            "k" | "wavenumber" => Column::Wavenumber,
            "omega" | "\u{3c9}" | "angular_frequency" => Column::Omega,
            "f" | "frequency" => Column::Cycles,
            "curve" | "branch" => Column::Curve,
            _ => return None,
        };
        Some((column, unit))
    }
}

impl Table {
    pub(super) fn read(path: &Path) -> Result<Table> {
        let text = std::fs::read_to_string(path).map_err(Error::read("read", path))?;
        Table::parse(path, &text)
    }

    fn parse(path: &Path, text: &str) -> Result<Table> {
        let fault = |expected: &str, found: String| Error::Unfit {
            path: path.to_owned(),
            expected: expected.into(),
            found,
        };
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let broken = |error: csv::Error| fault("comma-separated values", error.to_string());
        let headers = reader.headers().map_err(broken)?.clone();
        let header = "columns k and omega or f by name, such as `k (rad/m),f (Hz)`, and at most \
                      one column `curve`";
        let columns: Vec<(Column, Option<String>)> = headers
            .iter()
            .map(|cell| Column::of(cell).ok_or_else(|| fault(header, format!("`{cell}`"))))
            .collect::<Result<_>>()?;
        let places = |of: &[Column]| -> Vec<usize> {
            let places = 0..columns.len();
            places.filter(|&n| of.contains(&columns[n].0)).collect()
        };
        let k = places(&[Column::Wavenumber]);
        let frequencies = places(&[Column::Omega, Column::Cycles]);
        let curve = places(&[Column::Curve]);
        if k.len() != 1 || frequencies.is_empty() || curve.len() > 1 {
            let found: Vec<&str> = headers.iter().collect();
            return Err(fault(header, format!("`{}`", found.join(","))));
        }
        let mut points: BTreeMap<(String, usize), Vec<(f64, f64)>> = BTreeMap::new();
        for record in reader.records() {
            let record = record.map_err(broken)?;
            let line = record.position().map_or(0, csv::Position::line);
            let number = |n: usize| match &record[n] {
                "" => Ok(f64::NAN),
                cell => cell
                    .parse()
                    .map_err(|_| fault("a number", format!("`{cell}` in line {line}"))),
            };
            let label = curve.first().map_or("", |&n| &record[n]);
            let at = number(k[0])?;
            if !at.is_finite() {
                return Err(fault(
                    "a finite k",
                    format!("`{}` in line {line}", &record[k[0]]),
                ));
            }
            for &n in &frequencies {
                let points = points.entry((label.to_owned(), n)).or_default();
                if points.last().is_some_and(|last| last.0 >= at) {
                    let expected = "k that rises along a branch (a column `curve` tells branches \
                                    apart)";
                    return Err(fault(expected, format!("{at} in line {line}")));
                }
                points.push((at, number(n)?));
            }
        }
        if points.is_empty() {
            return Err(fault("rows of numbers", "none".into()));
        }
        let curves = points.into_iter().map(|((_, n), points)| Curve {
            is_cycles: columns[n].0 == Column::Cycles,
            unit: columns[n].1.clone(),
            points,
        });
        Ok(Table {
            path: path.to_owned(),
            k_unit: columns[k[0]].1.clone(),
            curves: curves.collect(),
        })
    }

    /// Omega of every branch at the wavenumbers of a field, in its units.
    pub(super) fn branches(&self, axes: &Axes, wavenumber: &[f64]) -> Result<Vec<Vec<f64>>> {
        let in_k = |unit: &str| {
            let length = unit.strip_prefix("rad/").or(unit.strip_prefix("1/"))?;
            Some(size::<Length>(axes.space_unit())? / size::<Length>(length)?)
        };
        let k_factor = self.factor(&self.k_unit, axes.wavenumber_unit(), in_k)?;
        let second = size::<Time>(axes.time_unit());
        let in_cycles = |unit: &str| Some(second? * size::<Frequency>(unit)?);
        let in_omega = |unit: &str| Some(second? / size::<Time>(unit.strip_prefix("rad/")?)?);
        let one_sided = |curve: &Curve| curve.points.iter().all(|point| point.0 >= 0.0);
        let both = self.curves.iter().all(one_sided);
        let branch = |curve: &Curve| {
            let factor = match curve.is_cycles {
                true => TAU * self.factor(&curve.unit, axes.frequency_unit(), in_cycles)?,
                false => {
                    let own = format!("rad/{}", axes.time_unit());
                    self.factor(&curve.unit, own, in_omega)?
                }
            };
            let at = |&k: &f64| {
                let k = if both { k.abs() } else { k };
                factor * interpolated(&curve.points, k / k_factor)
            };
            Ok(wavenumber.iter().map(at).collect())
        };
        self.curves.iter().map(branch).collect()
    }

    /// By what values in `unit` are multiplied; without a unit they are in that of the field, its `own`, in which `of` is
    /// the size of others.
    fn factor(
        &self,
        unit: &Option<String>,
        own: String,
        of: impl Fn(&str) -> Option<f64>,
    ) -> Result<f64> {
        let Some(unit) = unit.as_ref().filter(|unit| **unit != own) else {
            return Ok(1.0);
        };
        of(unit).ok_or_else(|| Error::Unfit {
            path: self.path.clone(),
            expected: format!("values in {own} or a unit that converts to it"),
            found: format!("values in {unit}"),
        })
    }
}

/// Linear between points; NaN outside them and beside a gap.
fn interpolated(points: &[(f64, f64)], k: f64) -> f64 {
    let after = points.partition_point(|point| point.0 < k);
    match (points.get(after.wrapping_sub(1)), points.get(after)) {
        (_, Some(&(at, value))) if at == k => value,
        (Some(&(a, low)), Some(&(b, high))) => low + (high - low) * (k - a) / (b - a),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Table> {
        Table::parse(Path::new("curve.csv"), text)
    }

    #[test]
    fn columns_and_labels_are_branches() {
        let table = parse("# measured\nk,f_1 (kHz),f_2 (kHz)\n0,0,5\n1,2,\n2,3,4\n").unwrap();
        assert_eq!(table.curves.len(), 2);
        assert_eq!(interpolated(&table.curves[0].points, 0.5), 1.0);
        assert!(interpolated(&table.curves[1].points, 0.5).is_nan());
        assert_eq!(interpolated(&table.curves[1].points, 2.0), 4.0);
        assert!(interpolated(&table.curves[0].points, 2.1).is_nan());

        let table = parse("k,omega,curve\n0,0,low\n0,5,high\n1,2,low\n1,4,high\n").unwrap();
        assert_eq!(table.curves.len(), 2);
        assert!(!table.curves[0].is_cycles);
    }

    #[test]
    fn faults_name_line_and_column() {
        for (text, expected, found) in [
            ("k,speed\n0,1\n", "columns k and omega or f", "`speed`"),
            ("k\n0\n", "columns k and omega or f", "`k`"),
            ("omega,f\n0,1\n", "columns k", "`omega,f`"),
            ("k,f\n0,1\n1,two\n", "a number", "`two` in line 3"),
            ("k,f\n1,1\n0,2\n", "k that rises", "0 in line 3"),
            ("k,f\n,2\n", "a finite k", "`` in line 2"),
            ("k,f\n", "rows of numbers", "none"),
            ("k,f\n1\n", "comma-separated", "found record"),
            ("", "columns k", "``"),
        ] {
            match parse(text) {
                Err(Error::Unfit {
                    expected: e,
                    found: f,
                    ..
                }) => {
                    assert!(e.starts_with(expected), "{text}: {e}");
                    assert!(f.contains(found), "{text}: {f}");
                }
                other => panic!("{text}: {other:?}"),
            }
        }
    }
}
