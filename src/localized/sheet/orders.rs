//! The table of orders: exact, estimated, of struck chains, published.

use serde_json::json;

use super::super::{Alternation, Comparison, Direct, OrderRow};
use super::{DIGITS, LOCALIZED, TIME};
use crate::sheet::{
    Chart, Describe, Look, PlotRow, Series, Sheet, Table, error_size, name_of, number, percent,
    with_half,
};

/// Ratios that the answer names at most.
const SHOWN: usize = 4;
/// Samples on each side of the centre of a wave that is drawn.
const HALF: usize = 400;
const ESTIMATE: [&str; 2] = [
    "estimate",
    "Asymptotic: a fast oscillation driven by the slow wave, exact or fitted.",
];
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
        let (of, exponent) = (name_of(&family.alternation), family.exponent);
        let mut sheet = Sheet {
            version: 2,
            about: format!("Dimers whose {of} alternates, contact law of exponent {exponent}"),
            answer: self.answer(),
            records: self.records(),
            definitions: vec![LOCALIZED, TIME, ESTIMATE],
            ..Sheet::of("localize", "Localized waves", "")
        };
        let short = Table::of_columns("Orders", &self.rows, &SHORT).printed();
        let leaks = Table::of_columns("Energy that pulses lose", &self.leaks(), &LEAKS).printed();
        let strikes = self.comparison.cells.is_some();
        sheet.tables.push(short);
        sheet.tables.extend(strikes.then_some(leaks));
        let coefficients = self.rows.iter().find_map(|row| row.angle?.coefficients);
        if let Some([soft, _]) = coefficients {
            let text = format!("{soft:.6e} N/m^1.5, at 90 degrees");
            sheet.fact("soft contacts", text);
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
            let points = rows.filter_map(|row| Some((row.order as f64, value(row)?)));
            Series::line(label, n, points.collect()).with(look)
        };
        let chart = |title: &str, label: &str, mut series: Vec<Series>| {
            series.retain(|series| !series.points.is_empty());
            (!series.is_empty()).then(|| Chart::of(title, "order", label, series).logarithmic())
        };
        let ratios = vec![
            over_order("exact", 0, Look::Line, ratio),
            over_order("estimate, exact wave", 1, Look::Dots, on_exact),
            over_order("estimate, fitted wave", 2, Look::Dots, on_fitted),
            over_order("struck chains", 3, Look::Dots, struck),
        ];
        let leak: Value = |row| Some(row.direct?.leak);
        let largest: Value = |row| Some(row.most_dispersive?.leak);
        let leaks = vec![
            over_order("at the order", 0, Look::Line, leak),
            over_order("largest before the next", 1, Look::Line, largest),
        ];
        let of_leaks = "energy that a struck chain's pulse loses in a cell";
        let charts = [
            chart("ratios of localized waves", "ratio", ratios),
            chart(of_leaks, "leak a cell", leaks),
        ];
        let charts: Vec<Chart> = charts.into_iter().flatten().collect();
        let mut rows = vec![PlotRow::of(charts), PlotRow::of(self.waves())];
        rows.retain(|row| !row.plots.is_empty());
        rows
    }
}

impl Orders {
    /// The ratios that carry waves, their angles, and where struck pulses lose most, in words.
    fn answer(&self) -> String {
        let resolved = || self.rows.iter().filter(|row| row.exact.is_some());
        let count = resolved().count();
        let first = |values: Vec<f64>| {
            let more = if count > SHOWN { ", ..." } else { "" };
            let shown: Vec<String> = values.into_iter().take(SHOWN).map(number).collect();
            shown.join(", ") + more
        };
        let orders = match (self.comparison.orders.start(), self.comparison.orders.end()) {
            (first, last) if first == last => format!("order {first}"),
            (first, last) => format!("orders {first} to {last}"),
        };
        let of = name_of(&self.comparison.family.alternation);
        let ratios = first(resolved().filter_map(ratio).collect());
        let mut answer = match count {
            0 => return format!("no localized wave of {orders} is resolved"),
            1 => format!("a localized wave at {of} ratio {ratios}"),
            _ => format!("localized waves at {of} ratios {ratios}"),
        };
        let degrees = resolved().filter_map(|row| Some(row.angle?.degrees));
        let degrees: Vec<f64> = degrees.collect();
        if !degrees.is_empty() {
            answer += &format!(", cylinders crossed at {} degrees", first(degrees));
        }
        answer += &format!(" ({orders})");
        if count < self.rows.len() {
            answer += &format!("; {} not resolved", self.rows.len() - count);
        }
        let most = self.rows.iter().filter_map(|row| row.most_dispersive);
        if let Some(most) = most.max_by(|a, b| a.leak.total_cmp(&b.leak)) {
            let degrees = degrees_of(&most).map_or(String::new(), |text| format!(" ({text})"));
            let (leak, at) = (percent(most.leak), stated(&most));
            answer += &format!("; struck pulses lose most, {leak} a cell, at {at}{degrees}");
        }
        answer
    }

    /// What pulses lose at the orders and, most, between them.
    fn leaks(&self) -> Vec<(String, Direct)> {
        let of = |row: &OrderRow| {
            let order = row.direct.map(|it| (format!("order {}", row.order), it));
            let between = row.most_dispersive.map(|it| ("most dispersive".into(), it));
            order.into_iter().chain(between)
        };
        self.rows.iter().flat_map(of).collect()
    }

    /// The forces of all waves, each over its largest.
    fn waves(&self) -> Vec<Chart> {
        let names = self.comparison.family.alternation.contacts();
        let waves = self.rows.iter().filter_map(|row| row.wave.as_ref());
        let profiles: Vec<_> = waves.map(|wave| (wave.order, wave.profile(HALF))).collect();
        let chart = |(contact, name): (usize, &str)| {
            let series = profiles.iter().enumerate().map(|(n, (order, profile))| {
                let force = &profile.force[contact];
                let largest = force.iter().fold(0.0, |most: f64, f| most.max(*f));
                let points = profile.time.iter().zip(force);
                let points = points.map(|(t, f)| (*t, f / largest));
                let near = points.filter(|point| point.0.abs() <= REACH);
                Series::line(format!("order {order}"), n, near.collect())
            });
            let title = format!("the waves, {name}");
            Chart::of(title, "time (cells)", "force / largest", series.collect())
        };
        let contacts = names.into_iter().enumerate();
        let contacts = contacts.filter(|_| !profiles.is_empty());
        contacts.map(chart).collect()
    }

    /// One row for each order, with all digits; unknown values are empty.
    fn records(&self) -> Table {
        let ratio = match self.comparison.family.alternation {
            Alternation::Stiffness => "kappa",
            Alternation::Mass => "mass_ratio",
        };
        let places = RECORDS.replace("RATIO", ratio);
        let places = places.lines().filter_map(|line| line.split_once(": "));
        let places: Vec<(&str, &str)> = places.collect();
        Table::of_places(&places, self.rows.iter().map(|row| json!(row)))
    }
}

/// A number of an order.
type Value = fn(&OrderRow) -> Option<f64>;
/// A cell of a table of items, under its name.
type Column<T> = (&'static str, fn(&T) -> Option<String>);

fn ratio(row: &OrderRow) -> Option<f64> {
    Some(row.exact?.ratio.value())
}

fn on_exact(row: &OrderRow) -> Option<f64> {
    Some(row.asymptotic?.exact_profile)
}

fn on_fitted(row: &OrderRow) -> Option<f64> {
    row.asymptotic?.fitted_profile
}

fn struck(row: &OrderRow) -> Option<f64> {
    Some(row.direct?.ratio.value())
}

/// A ratio of struck chains with its error.
fn stated(direct: &Direct) -> String {
    let ratio = direct.ratio.value();
    with_half(ratio, direct.error * ratio, "")
}

/// The angle of struck chains with its error.
fn degrees_of(direct: &Direct) -> Option<String> {
    let angle = direct.angle?;
    Some(with_half(angle.degrees, angle.degrees_error, "degrees"))
}

fn six(value: f64) -> String {
    format!("{value:.6}")
}

const SHORT: [Column<OrderRow>; 7] = [
    ("order", |row| Some(row.order.to_string())),
    ("exact ratio", |row| {
        Some(format!("{:.DIGITS$}", ratio(row)?))
    }),
    ("error", |row| Some(error_size(row.exact?.error))),
    ("degrees", |row| Some(six(row.angle?.degrees))),
    ("estimate", |row| Some(six(on_exact(row)?))),
    ("struck chain", |row| Some(stated(&row.direct?))),
    ("paper", |row| Some(row.published?.direct.to_string())),
];

const LEAKS: [Column<(String, Direct)>; 4] = [
    ("wave", |(name, _)| Some(name.clone())),
    ("ratio", |(_, direct)| Some(stated(direct))),
    ("leak a cell", |(_, direct)| Some(error_size(direct.leak))),
    ("angle", |(_, direct)| degrees_of(direct)),
];

/// The numbers of `table.csv`: their names, and where they are in the JSON of an order.
const RECORDS: &str = "\
order: /order
ratio: /exact/RATIO
error: /exact/error
digits: /exact/digits
residual: /exact/residual
iterations: /exact/iterations
tail: /exact/tail
points: /exact/points
period: /exact/period
speed_coefficient: /exact/speed_coefficient
width: /exact/width
energy: /exact/energy
momentum: /exact/momentum
angle: /angle/degrees
exact_profile: /asymptotic/exact_profile
fitted_profile: /asymptotic/fitted_profile
direct: /direct/RATIO
direct_error: /direct/error
direct_leak: /direct/leak
direct_angle: /direct/angle/degrees
direct_angle_error: /direct/angle/degrees_error
most_dispersive: /most_dispersive/RATIO
most_dispersive_error: /most_dispersive/error
most_dispersive_leak: /most_dispersive/leak
most_dispersive_angle: /most_dispersive/angle/degrees
most_dispersive_angle_error: /most_dispersive/angle/degrees_error
printed_order: /published/printed_order
published_direct: /published/direct
published_estimate: /published/estimate
exact_profile_difference: /differences/exact_profile
fitted_profile_difference: /differences/fitted_profile
direct_difference: /differences/direct
published_direct_difference: /differences/published_direct
published_estimate_difference: /differences/published_estimate
reason: /reason";
