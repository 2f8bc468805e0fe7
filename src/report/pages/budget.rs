//! Maps and curves of one budget, or of several on shared scales.

use std::f64::consts::PI;

use super::sheet::page_of;
use crate::analyze::{Map, Reduction};
use crate::budget::{Budget, FrequencyFlow, ScaleBudget, WavenumberBudget};
use crate::plot::{self, Style};
use crate::report::Provenance;
use crate::report::page::{Chart, CurveGroup, Look, MapData, Picture, Role, Series};
use crate::sheet::Sheet;

type Named<'a> = (&'a str, &'a Budget);

/// The page of one budget, or of two: the same pictures on the same scales. Maps have the colours of `style`.
///
/// # Errors
/// None for results of this library.
pub fn budget_html(
    budgets: &[Named],
    sheet: &Sheet,
    provenance: &Provenance,
    style: &Style,
) -> serde_json::Result<String> {
    let names: Vec<&str> = budgets.iter().map(|(name, _)| *name).collect();
    page_of(sheet, of(budgets), &names.join(" and "), provenance, style)
}

type Points = Vec<(f64, f64)>;

/// One kind of map.
struct Kind {
    id: &'static str,
    title: &'static str,
    shows: &'static str,
    roles: (Role, Role),
    map: for<'a> fn(&'a Budget) -> Option<&'a Map>,
}

const FLUX: Kind = Kind {
    id: "energy-flux",
    title: "Energy flux J(x, t)",
    shows: "Power through each contact, positive towards +x. Look for the leading pulse, and for what \
            comes back behind it.",
    roles: (Role::Position, Role::Time),
    map: |budget| Some(&budget.flux_map),
};

const POWER_FLOW: Kind = Kind {
    id: "power-flow",
    title: "Power flow P(f) through each contact",
    shows: "Energy that passes each contact at each frequency. Where the top of the picture fades along \
            x, high frequencies do not pass. The dashed line is the band edge.",
    roles: (Role::Position, Role::Frequency),
    map: |budget| Some(&budget.frequency.as_ref()?.map),
};

const SPECTRUM: Kind = Kind {
    id: "energy-spectrum",
    title: "Energy spectrum E(k, t)",
    shows: "Energy of motion and of contacts at each wavenumber. The dashed line is the band edge.",
    roles: (Role::Wavenumber, Role::Time),
    map: |budget| Some(&budget.wavenumber.as_ref()?.energy_map),
};

const SPECTRAL_FLUX: Kind = Kind {
    id: "spectral-flux",
    title: "Spectral flux Π(k, t)",
    shows: "Power that passes from below k to above it: positive towards high k.",
    roles: (Role::Wavenumber, Role::Time),
    map: |budget| Some(&budget.wavenumber.as_ref()?.flux_map),
};

const SCALE_FLUX: Kind = Kind {
    id: "scale-flux",
    title: "Scale flux Π_l(x, t)",
    shows: "Power that leaves the scales larger than l, where it does so; grey where the filter does \
            not fit into the chain.",
    roles: (Role::Position, Role::Time),
    map: |budget| budget.scales.as_ref()?.flux_map.as_ref(),
};

/// The pictures in the order of reading; maps of one kind in a row.
fn of(budgets: &[Named]) -> Vec<Vec<Picture>> {
    let mut rows = Vec::new();
    let alone = |group: Option<CurveGroup>| group.map(|group| vec![group.into()]);
    rows.extend(alone(views(budgets)));
    rows.push(maps(budgets, &FLUX));
    rows.push(vec![energies(budgets).into()]);
    rows.extend(alone(modes(budgets)));
    rows.push(vec![passed(budgets).into()]);
    for kind in [&POWER_FLOW, &SPECTRUM, &SPECTRAL_FLUX, &SCALE_FLUX] {
        rows.push(maps(budgets, kind));
    }
    rows
}

fn maps(budgets: &[Named], kind: &Kind) -> Vec<Picture> {
    let mut present: Vec<(&str, &Budget, &Map)> = Vec::new();
    for &(name, budget) in budgets {
        present.extend((kind.map)(budget).map(|map| (name, budget, map)));
    }
    let values = || {
        let all = present.iter().flat_map(|(_, _, map)| map.values.iter());
        all.map(|&value| f64::from(value))
    };
    let is_signed = |map: &Map| matches!(map.reduction, Reduction::Extreme { .. });
    let clipped = plot::ordinary(values());
    let shared = (budgets.len() > 1).then(|| extent(values()));
    let one = |(n, (name, budget, map)): (usize, &(&str, &Budget, &Map))| -> Picture {
        let (id, title) = match budgets.len() {
            1 => (kind.id.to_owned(), kind.title.to_owned()),
            _ => (
                format!("{}-{}", kind.id, n + 1),
                format!("{}: {name}", kind.title),
            ),
        };
        let title = match kind.id {
            "scale-flux" => at_scale(&title, budget),
            _ => title,
        };
        let second = Some(("k a / π".to_owned(), budget.pitch / PI));
        let edge = |edge: Option<f64>| edge.filter(|edge| edge.is_finite());
        let frequency = edge(budget.frequency.as_ref().map(|flow| flow.edge));
        let wavenumber = edge(budget.wavenumber.as_ref().map(|found| found.edge));
        let limit = if is_signed(map) { clipped } else { 0.0 };
        MapData::of(map, &id, &title, kind.shows, kind.roles)
            .annotated(frequency, wavenumber, &second)
            .with_limit(limit)
            .with_range(shared)
            .into()
    };
    present.iter().enumerate().map(one).collect()
}

fn at_scale(title: &str, budget: &Budget) -> String {
    match &budget.scales {
        Some(ScaleBudget { map_scale, .. }) => format!("{title}, l = {map_scale:.4}"),
        None => title.to_owned(),
    }
}

/// Least positive and largest magnitude.
fn extent(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let sizes = values.map(f64::abs).filter(|size| *size > 0.0);
    sizes.fold([f64::INFINITY, 0.0], |[low, high], size| {
        [low.min(size), high.max(size)]
    })
}

/// The curves of budgets: one colour for each quantity, the second budget's dashed.
struct Curves<'a> {
    budgets: &'a [Named<'a>],
    series: Vec<Series>,
    quantities: usize,
}

impl<'a> Curves<'a> {
    fn new(budgets: &'a [Named<'a>]) -> Self {
        Curves {
            budgets,
            series: Vec::new(),
            quantities: 0,
        }
    }

    /// Values at the group's x.
    fn values(&mut self, what: &str, of: &dyn Fn(&Budget) -> Option<Vec<f64>>) {
        self.add(what, &|label, budget| {
            Some(Series::new(label, &of(budget)?))
        });
    }

    /// Points with an x of their own.
    fn points(&mut self, what: &str, of: &dyn Fn(&Budget) -> Option<Points>) {
        self.add(what, &|label, budget| {
            Some(Series::points(label, &of(budget)?))
        });
    }

    fn add(&mut self, what: &str, of: &dyn Fn(String, &Budget) -> Option<Series>) {
        let before = self.series.len();
        for (n, (name, budget)) in self.budgets.iter().enumerate() {
            let label = match self.budgets.len() {
                1 => what.to_owned(),
                _ => format!("{name}: {what}"),
            };
            let look = if n == 0 { Look::Line } else { Look::Dashed };
            let series = of(label, budget).map(|s| s.colored(self.quantities).looking(look));
            self.series.extend(series);
        }
        self.quantities += usize::from(self.series.len() > before);
    }
}

/// Motion, contacts, losses and input over time.
fn energies(budgets: &[Named]) -> CurveGroup {
    let first = budgets[0].1;
    let mut curves = Curves::new(budgets);
    let any = |values: &[f64]| {
        values
            .iter()
            .any(|value| *value != 0.0)
            .then(|| values.to_vec())
    };
    let same_times = budgets.iter().all(|(_, budget)| budget.time == first.time);
    let mut add = |what: &str, values: &dyn Fn(&Budget) -> Option<Vec<f64>>| match same_times {
        true => curves.values(what, values),
        false => curves.points(what, &|budget| {
            Some(budget.time.iter().copied().zip(values(budget)?).collect())
        }),
    };
    add("in the chain", &|b| Some(b.energies()));
    add("of motion", &|b| Some(b.kinetic.clone()));
    add("of contacts", &|b| Some(b.contact.clone()));
    add("lost", &|b| any(&b.lost));
    add("put in", &|b| any(&b.input));
    CurveGroup::new(
        ("energies", "Energy over time"),
        "What the chain holds, in motion and in contacts, what it has lost, and what was put in.",
        (first.units.time(), Some(Role::Time)),
        &first.time,
        vec![Chart::new(first.units.energy("energy"), curves.series)],
    )
}

/// By how many normal modes the energy is shared over time, and by how many in equilibrium; `None` without modes.
fn modes(budgets: &[Named]) -> Option<CurveGroup> {
    let first = budgets.iter().find(|(_, budget)| budget.modes.is_some())?.1;
    let mut curves = Curves::new(budgets);
    curves.points("modes", &|budget| {
        let modes = budget.modes.as_ref()?;
        let shared = modes.entropy.iter().map(|entropy| entropy.exp());
        Some(budget.time.iter().copied().zip(shared).collect())
    });
    curves.points("in equilibrium", &|budget| {
        let equilibrium = budget.modes.as_ref()?.equilibrium;
        let ends = [budget.time.first()?, budget.time.last()?];
        let points = ends.map(|time| (*time, equilibrium.exp()));
        equilibrium.is_finite().then(|| points.to_vec())
    });
    Some(CurveGroup::new(
        ("modes", "Modes that share the energy"),
        "exp(S), S the entropy of the shares of the normal modes: 1 where one mode holds all of it. Beside it the \
         mean of a chain in equilibrium.",
        (first.units.time(), Some(Role::Time)),
        &[],
        vec![Chart::new("modes", curves.series).log()],
    ))
}

/// Energy passed by the end through each contact, in either band, and what stayed behind.
fn passed(budgets: &[Named]) -> CurveGroup {
    let first = budgets[0].1;
    let mut curves = Curves::new(budgets);
    let mut along = |what: &str, values: &dyn Fn(&Budget) -> Option<Vec<f64>>| {
        curves.points(what, &|budget| Some(at_contacts(budget, &values(budget)?)));
    };
    let band = |of: fn(&FrequencyFlow) -> &Vec<f64>| {
        move |budget: &Budget| Some(of(budget.frequency.as_ref()?).clone())
    };
    along("passed by the end", &|b| Some(b.passed.clone()));
    along("low band", &band(|flow| &flow.low));
    along("high band", &band(|flow| &flow.high));
    along("held behind at the end", &|b| Some(b.left_behind.clone()));
    CurveGroup::new(
        ("energy-passed", "Energy passed along x"),
        "Energy that has passed each contact by the end of the record, split at the band edge, and \
         what the bodies behind it hold.",
        (first.units.position(), Some(Role::Position)),
        &[],
        vec![Chart::new(first.units.energy("energy"), curves.series)],
    )
}

fn at_contacts(budget: &Budget, values: &[f64]) -> Points {
    let place = |j: usize| budget.pitch * (j as f64 + 0.5);
    values
        .iter()
        .enumerate()
        .map(|(j, &value)| (place(j), value))
        .collect()
}

/// Energy that has passed from low to high k, and out of the scales larger than l, as shares of the
/// largest energy; `None` without a budget over wavenumbers.
fn views(budgets: &[Named]) -> Option<CurveGroup> {
    let first = budgets
        .iter()
        .find(|(_, budget)| budget.wavenumber.is_some())?
        .1;
    let mut curves = Curves::new(budgets);
    let over_k = |values: fn(&WavenumberBudget) -> &Vec<f64>| {
        move |budget: &Budget| {
            let found = budget.wavenumber.as_ref()?;
            let k = found.wavenumber.iter().copied();
            Some(
                k.zip(values(found).iter().map(|flux| flux / budget.scale))
                    .collect(),
            )
        }
    };
    curves.points(
        "over k, whole record",
        &over_k(|found| &found.integrated_flux),
    );
    curves.points("over k, second half", &over_k(|found| &found.late_flux));
    curves.points("over 2π/l", &|budget| {
        let scales = budget.scales.as_ref()?;
        let k = scales.scales.iter().map(|scale| 2.0 * PI / scale.scale);
        let flux = scales
            .integrated_flux
            .iter()
            .map(|flux| flux / budget.scale);
        Some(k.zip(flux).collect())
    });
    Some(CurveGroup::new(
        ("views", "Energy passed to higher wavenumber"),
        "Net energy that has passed k towards higher k, as a share of the largest energy: over the \
         whole record, and over its second half, when the impact is taken up. Beside it what has left \
         the scales larger than l for smaller ones, where the filter fits into the chain.",
        (first.units.wavenumber(), Some(Role::Wavenumber)),
        &[],
        vec![Chart::new("share of the energy", curves.series).marked(Some(0.0))],
    ))
}
