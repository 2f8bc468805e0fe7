//! The table of orders: exact, estimated, of struck chains, published.

use serde_json::json;

use super::super::{Comparison, Direct, OrderRow};
use super::{DIGITS, LOCALIZED, TIME};
use crate::sheet::{Chart, Describe, Look, PlotRow, Series, Sheet, Table, error_size, number};

/// Ratios that the answer names at most.
const SHOWN: usize = 4;
/// Samples on each side of the centre of a wave that is drawn.
const HALF: usize = 400;
/// Cells on each side of the centre that are drawn.
const REACH: f64 = 2.5;

/// What was found of each order.
#[derive(Debug, Clone)]
pub struct Orders {
    pub comparison: Comparison,
    pub rows: Vec<OrderRow>,
}

impl Describe for Orders {
    fn describe(&self) -> Sheet<'_> {
        let family = self.comparison.family;
        let mut sheet = Sheet {
            name: "localize",
            version: 2,
            title: "Localized waves".into(),
            about: format!(
                "Dimers whose {} alternates, contact law of exponent {}",
                family.alternation.name(),
                family.exponent
            ),
            answer: self.answer(),
            records: self.records(),
            definitions: vec![
                LOCALIZED,
                TIME,
                [
                    "estimate",
                    "Asymptotic: a fast oscillation driven by the slow wave, exact or fitted.",
                ],
                [
                    "rel. diff.",
                    "Relative to the exact ratio; of the paper's estimate, to the estimate on the fitted wave.",
                ],
            ],
            ..Sheet::default()
        };
        sheet.tables.push(self.short_table());
        if self.strikes() {
            sheet.tables.push(self.leaks());
        }
        sheet.tables.push(self.whole_table());
        let coefficients = self.rows.iter().find_map(|row| row.angle?.coefficients);
        if let Some([soft, _]) = coefficients {
            sheet.fact(
                "soft contacts",
                format!("{soft:.6e} N/m^1.5, at 90 degrees"),
            );
        }
        for row in &self.rows {
            if let Some(reason) = &row.reason {
                sheet.warn(format!("order {} is unresolved: {reason}", row.order), "");
            }
        }
        sheet.numbers(json!({
            "family": family,
            "cells": self.comparison.cells,
            "orders": self.rows,
        }));
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let over_order = |label: &str, n: usize, look: Look, value: Value| {
            let rows = self.rows.iter();
            let points: Vec<(f64, f64)> = rows
                .filter_map(|row| Some((row.order as f64, value(row)?)))
                .collect();
            (!points.is_empty()).then(|| Series::line(label, n, points).with(look))
        };
        let chart = |title: &str, label: &str, series: Vec<Option<Series>>| {
            let series: Vec<Series> = series.into_iter().flatten().collect();
            (!series.is_empty()).then(|| Chart::of(title, "order", label, series).logarithmic())
        };
        let ratios = vec![
            over_order("exact", 0, Look::Line, |row| Some(row.exact?.ratio.value())),
            over_order("estimate, exact wave", 1, Look::Dots, |row| {
                Some(row.asymptotic?.exact_profile)
            }),
            over_order("estimate, fitted wave", 2, Look::Dots, |row| {
                row.asymptotic?.fitted_profile
            }),
            over_order("struck chains", 3, Look::Dots, |row| {
                Some(row.direct?.ratio.value())
            }),
        ];
        let leaks = vec![
            over_order("at the order", 0, Look::Line, |row| Some(row.direct?.leak)),
            over_order("largest before the next", 1, Look::Line, |row| {
                Some(row.most_dispersive?.leak)
            }),
        ];
        let charts = [
            chart("ratios of localized waves", "ratio", ratios),
            chart(
                "energy that a struck chain's pulse loses in a cell",
                "leak a cell",
                leaks,
            ),
        ];
        let charts: Vec<Chart> = charts.into_iter().flatten().collect();
        let rows = [PlotRow::of(charts), PlotRow::of(self.waves())];
        rows.into_iter()
            .filter(|row| !row.plots.is_empty())
            .collect()
    }
}

/// The drawn quantity of an order.
type Value = fn(&OrderRow) -> Option<f64>;

impl Orders {
    fn strikes(&self) -> bool {
        self.comparison.cells.is_some()
    }

    fn is_published(&self) -> bool {
        self.rows.iter().any(|row| row.published.is_some())
    }

    /// The ratios that carry waves, in words.
    fn answer(&self) -> String {
        let known = self.rows.iter().filter_map(|row| row.exact.as_ref());
        let ratios: Vec<String> = known.map(|exact| number(exact.ratio.value())).collect();
        let unresolved = match self.rows.len() - ratios.len() {
            0 => String::new(),
            count => format!("; {count} not resolved"),
        };
        let orders = match (self.comparison.orders.start(), self.comparison.orders.end()) {
            (first, last) if first == last => format!("order {first}"),
            (first, last) => format!("orders {first} to {last}"),
        };
        let of = self.comparison.family.alternation.name();
        let shown = ratios.len().min(SHOWN);
        let more = if ratios.len() > shown { ", ..." } else { "" };
        let what = match ratios.len() {
            0 => return format!("no localized wave of {orders} is resolved"),
            1 => format!("a localized wave at {of} ratio"),
            _ => format!("localized waves at {of} ratios"),
        };
        format!(
            "{what} {}{more} ({orders}){unresolved}",
            ratios[..shown].join(", ")
        )
    }

    fn short_table(&self) -> Table {
        let mut head = vec!["order", "exact ratio", "error", "estimate"];
        head.extend(self.strikes().then_some("struck chain"));
        head.extend(self.is_published().then_some("paper"));
        let rows = self.rows.iter().map(|row| {
            let mut cells = exact_cells(row).to_vec();
            cells.push(six(row.asymptotic.map(|a| a.exact_profile)));
            if self.strikes() {
                cells.push(six(row.direct.map(|direct| direct.ratio.value())));
            }
            if self.is_published() {
                cells.push(row.published.map_or("-".into(), |p| p.direct.to_string()));
            }
            cells
        });
        table("Orders", &head, rows.collect(), true)
    }

    /// All that is known; deviations are relative to the exact ratio, that of the paper's estimate to ours.
    fn whole_table(&self) -> Table {
        let mut head = vec!["order", "exact ratio", "error"];
        let mut group = |names: &[&'static str]| head.extend(names);
        group(&[
            "estimate, exact wave",
            "rel. diff.",
            "estimate, fitted wave",
            "rel. diff.",
        ]);
        if self.strikes() {
            group(&["struck chain", "error", "rel. diff."]);
        }
        if self.is_published() {
            group(&[
                "paper, simulated",
                "rel. diff.",
                "paper, estimate",
                "rel. diff.",
                "printed as",
            ]);
        }
        let rows = self.rows.iter().map(|row| {
            let (estimates, off) = (row.asymptotic, &row.differences);
            let change = |value: Option<f64>| value.map_or("-".into(), error_size);
            let known = |value: Option<f64>| value.map_or("-".into(), |value| value.to_string());
            let mut cells = exact_cells(row).to_vec();
            cells.push(six(estimates.map(|a| a.exact_profile)));
            cells.push(change(off.exact_profile));
            cells.push(six(estimates.and_then(|a| a.fitted_profile)));
            cells.push(change(off.fitted_profile));
            if self.strikes() {
                cells.push(six(row.direct.map(|d| d.ratio.value())));
                cells.push(change(row.direct.map(|d| d.error)));
                cells.push(change(off.direct));
            }
            if self.is_published() {
                cells.push(known(row.published.map(|p| p.direct)));
                cells.push(change(off.published_direct));
                cells.push(known(row.published.map(|p| p.estimate)));
                cells.push(change(off.published_estimate));
                cells.push(
                    row.published
                        .map_or("-".into(), |p| p.printed_order.to_string()),
                );
            }
            cells
        });
        table("Orders, with differences", &head, rows.collect(), false)
    }

    /// What pulses lose at the orders and, most, between them.
    fn leaks(&self) -> Table {
        let with_angles = self.comparison.cylinders.is_some();
        let mut head = vec!["wave", "ratio", "leak a cell"];
        head.extend(with_angles.then_some("degrees"));
        let mut rows = Vec::new();
        for row in &self.rows {
            let mut add = |name: String, direct: Direct, degrees: Option<f64>| {
                let mut cells = vec![
                    name,
                    six(Some(direct.ratio.value())),
                    error_size(direct.leak),
                ];
                cells.extend(with_angles.then(|| six(degrees)));
                rows.push(cells);
            };
            if let Some(direct) = row.direct {
                let degrees = row.angle.map(|angle| angle.degrees);
                add(format!("order {}", row.order), direct, degrees);
            }
            if let Some(direct) = row.most_dispersive {
                let degrees = direct.angle.map(|angle| angle.degrees);
                add("most dispersive".into(), direct, degrees);
            }
        }
        table("Energy that pulses lose", &head, rows, true)
    }

    /// The forces of all waves, each over its largest.
    fn waves(&self) -> Vec<Chart> {
        let names = self.comparison.family.alternation.contacts();
        let waves = self.rows.iter().filter_map(|row| row.wave.as_ref());
        let profiles: Vec<_> = waves.map(|wave| (wave.order, wave.profile(HALF))).collect();
        let charts = names.into_iter().enumerate().map(|(contact, name)| {
            let series = profiles.iter().enumerate().map(|(n, (order, profile))| {
                let force = &profile.force[contact];
                let largest = force.iter().fold(0.0, |most: f64, f| most.max(*f));
                let points = profile.time.iter().zip(force);
                let points = points.map(|(t, f)| (*t, f / largest));
                let near = points.filter(|point| point.0.abs() <= REACH);
                Series::line(format!("order {order}"), n, near.collect())
            });
            Chart::of(
                format!("the waves, {name}"),
                "time (cells)",
                "force / largest",
                series.collect(),
            )
        });
        match profiles.is_empty() {
            true => Vec::new(),
            false => charts.collect(),
        }
    }

    /// One row for each order, with all digits; unknown values are empty.
    fn records(&self) -> Table {
        let rows = self.rows.iter().map(|row| {
            let exact = row.exact.as_ref();
            let text = |value: Option<f64>| value.map(|x| x.to_string()).unwrap_or_default();
            let count = |value: Option<usize>| value.map(|x| x.to_string()).unwrap_or_default();
            let extreme = |direct: Option<Direct>| {
                [
                    text(direct.map(|d| d.ratio.value())),
                    text(direct.map(|d| d.error)),
                    text(direct.map(|d| d.leak)),
                    text(direct.and_then(|d| Some(d.angle?.degrees))),
                ]
            };
            let mut cells = vec![
                row.order.to_string(),
                text(exact.map(|e| e.ratio.value())),
                text(exact.map(|e| e.error)),
                count(exact.map(|e| e.digits as usize)),
                text(exact.map(|e| e.convergence.residual)),
                count(exact.map(|e| e.convergence.iterations)),
                text(exact.map(|e| e.convergence.tail)),
                count(exact.map(|e| e.convergence.points)),
                text(exact.map(|e| e.convergence.period)),
                text(exact.map(|e| e.speed_coefficient)),
                text(exact.map(|e| e.width)),
                text(exact.map(|e| e.energy)),
                text(exact.map(|e| e.momentum)),
                text(row.angle.map(|angle| angle.degrees)),
                text(row.asymptotic.map(|a| a.exact_profile)),
                text(row.asymptotic.and_then(|a| a.fitted_profile)),
            ];
            cells.extend(extreme(row.direct));
            cells.extend(extreme(row.most_dispersive));
            cells.extend([
                count(row.published.map(|p| p.printed_order)),
                text(row.published.map(|p| p.direct)),
                text(row.published.map(|p| p.estimate)),
                text(row.differences.exact_profile),
                text(row.differences.fitted_profile),
                text(row.differences.direct),
                text(row.differences.published_direct),
                text(row.differences.published_estimate),
                row.reason.clone().unwrap_or_default(),
            ]);
            cells
        });
        table("", &COLUMNS, rows.collect(), false)
    }
}

fn table(title: &str, head: &[&str], rows: Vec<Vec<String>>, is_fact: bool) -> Table {
    Table {
        title: title.into(),
        head: head.iter().map(|name| (*name).to_owned()).collect(),
        rows,
        is_fact,
    }
}

/// Order, exact ratio, and its error.
fn exact_cells(row: &OrderRow) -> [String; 3] {
    let [ratio, error] = match &row.exact {
        Some(exact) => [
            format!("{:.DIGITS$}", exact.ratio.value()),
            error_size(exact.error),
        ],
        None => ["unresolved".into(), "-".into()],
    };
    [row.order.to_string(), ratio, error]
}

fn six(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.6}"))
}

const COLUMNS: [&str; 33] = [
    "order",
    "ratio",
    "error",
    "digits",
    "residual",
    "iterations",
    "tail",
    "points",
    "period",
    "speed_coefficient",
    "width",
    "energy",
    "momentum",
    "angle",
    "exact_profile",
    "fitted_profile",
    "direct",
    "direct_error",
    "direct_leak",
    "direct_angle",
    "most_dispersive",
    "most_dispersive_error",
    "most_dispersive_leak",
    "most_dispersive_angle",
    "printed_order",
    "published_direct",
    "published_estimate",
    "exact_profile_difference",
    "fitted_profile_difference",
    "direct_difference",
    "published_direct_difference",
    "published_estimate_difference",
    "reason",
];
