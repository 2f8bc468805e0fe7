//! The numbers of a budget; what is undefined is `null`.

use serde_json::{Map, Value, json};

use super::RESIDUALS;
use crate::budget::{
    Budget, Closure, Curves, FrequencyFlow, Integration, ModeBudget, Residual, ScaleBudget,
    WavenumberBudget, usual_pairs,
};

/// Gathers what is known; computes nothing new.
pub(super) fn of(budget: &Budget) -> Value {
    let last = budget.time.len() - 1;
    // Through the last contact between two sites.
    let inner = budget.n_contacts.min(budget.n_sites.saturating_sub(1));
    let energies = |curves: &Curves| {
        json!({
            "start": curves["total_energy"][0],
            "end": curves["total_energy"][last],
            "kinetic_end": curves["kinetic_energy"][last],
            "contact_end": curves["contact_energy"][last],
            "lost": curves["lost_energy"][last],
            "passed": inner.checked_sub(1).map(|j| curves["passed"][j]),
            "passed_middle": curves["passed"].get(budget.n_contacts / 2),
        })
    };
    let mut energy = energies(&budget.curves());
    energy["put_in"] = json!(budget.input[last]);
    energy["followed_inside_the_steps"] = json!(budget.followed);
    if let Some(errors) = &budget.errors {
        energy["errors"] = energies(errors);
    }
    json!({
        "sites": budget.n_sites,
        "contacts": budget.n_contacts,
        "samples": budget.time.len(),
        "duration": budget.time[last] - budget.time[0],
        "units": budget.units,
        "conventions": conventions(budget.closure.integration),
        "energy": energy,
        "wavenumber": budget.wavenumber.as_ref().map(|found| wavenumber(budget, found)),
        "frequency": budget.frequency.as_ref().map(|flow| frequency(budget, flow)),
        "scale": budget.scales.as_ref().map(|found| scales(budget, found)),
        "modes": budget.modes.as_ref().map(modes),
        "closure": closure(&budget.closure),
    })
}

fn modes(found: &ModeBudget) -> Value {
    let last = found.entropy.len() - 1;
    json!({
        "modes": found.frequency.len(),
        "entropy": [found.entropy[0], found.entropy[last]],
        "normalized_entropy_end": found.normalized_entropy[last],
        "effective_modes": [found.effective_modes(0), found.effective_modes(last)],
        "equilibrium_entropy": found.equilibrium,
        "equipartition_time": found.equipartition,
    })
}

fn conventions(integration: Integration) -> Value {
    json!({
        "flux": "J positive towards +x; spectral and scale fluxes positive towards high k and small scales",
        "wavenumber": "rad per unit of length; E and T hold both signs of k and sum to the energy and to 0",
        "integrated_flux": match integration {
            Integration::Stepping => {
                "the integral of - sum T up to k inside the stepping; checked by what the wavenumbers gained, lost to \
                 damping and were given"
            }
            Integration::Samples => {
                "minus what the wavenumbers up to k gained, lost to damping and were given; losses and inputs by the \
                 trapezoid rule over the samples"
            }
        },
        "power_flow": "one-sided; its sum times df is the energy passed by the trapezoid rule",
        "residuals": "largest over all samples, relative to the largest energy of the chain",
    })
}

fn wavenumber(budget: &Budget, found: &WavenumberBudget) -> Value {
    let passed = found.passed_edge().filter(|_| budget.scale > 0.0);
    let last = budget.time.len() - 1;
    let duration = budget.time[last] - budget.time[0];
    let most = budget.largest_passage();
    let share_of_all = |energy: f64, i: usize| energy / (budget.kinetic[i] + budget.contact[i]);
    let optical = |i: usize| {
        let energy = &found.branches.as_ref()?.optical_energy;
        Some(share_of_all(energy[i], i))
    };
    let passed_error = found.passed_error;
    let mut all = json!({
        "basis": found.basis,
        "band_edge": found.edge,
        // Energy that has passed from below the edge to above, net, over the largest energy, and its numerical error; of
        // a measured field its standard error.
        "share_passed": passed.map(|passed| passed / budget.scale),
        "share_passed_error": passed.map(|_| passed_error / budget.scale),
        "direction": passed.and_then(|_| budget.direction()),
        // Mean flux through the edge.
        "rate": passed.map(|passed| passed / duration),
        // Where most has passed, either way; none where that is no more than its error.
        "largest_passage": most.filter(|most| most.share.abs() > most.error).map(|most| {
            json!({ "wavenumber": most.wavenumber, "share": most.share })
        }),
        "centroid_start": found.centroid.first(),
        "centroid_end": found.centroid.last(),
        "optical_share_start": optical(0),
        "optical_share_end": optical(last),
    });
    if budget.errors.is_some() {
        let optical = |i: usize| Some(share_of_all(budget.error("optical_energy", i)?, i));
        all["errors"] = json!({
            "share_passed": passed.map(|_| passed_error / budget.scale),
            "rate": passed.map(|_| passed_error / duration),
            "largest_passage": most.map(|most| most.error),
            "centroid_start": budget.error("wavenumber_centroid", 0),
            "centroid_end": budget.error("wavenumber_centroid", last),
            "optical_share_start": optical(0),
            "optical_share_end": optical(last),
        });
    }
    all
}

/// Between the first contact, the middle one and the last that joins two sites, and the requested pairs.
fn frequency(budget: &Budget, flow: &FrequencyFlow) -> Value {
    let usual = usual_pairs(budget);
    let between = usual.iter().map(|[a, b]| flow.between(*a, *b));
    let between = between.chain(flow.chosen.iter().copied()).enumerate();
    let between = between.map(|(i, of)| {
        let mut of = json!(of);
        if budget.errors.is_some() {
            let names = ["low_error", "high_error", "behind_error"];
            for (part, name) in names.into_iter().enumerate() {
                of[name] = json!(budget.error("between", 3 * i + part));
            }
        }
        of
    });
    json!({
        "band_edge": flow.edge,
        "between": between.collect::<Vec<_>>(),
        // Of chosen contacts, from records made inside the stepping.
        "refined": flow.refined,
    })
}

fn scales(budget: &Budget, found: &ScaleBudget) -> Vec<Value> {
    let rows = found.scales.iter().enumerate();
    let rows = rows.map(|(i, of)| {
        let mut of = json!(of);
        of["contacts"] = json!(found.contacts[i]);
        of["integrated_flux"] = json!(found.integrated_flux[i]);
        if budget.errors.is_some() {
            of["integrated_flux_error"] = json!(budget.error("integrated_scale_flux", i));
        }
        of["residual"] = json!(found.residual[i]);
        of
    });
    rows.collect()
}

/// Residuals; where one is `null`, `reasons` says why.
fn closure(closure: &Closure) -> Value {
    let mut all = Map::new();
    let mut reasons = Map::new();
    for (name, _, of) in RESIDUALS {
        all.insert(name.into(), json!(of(closure).value()));
        if let Residual::Undefined(reason) = of(closure) {
            reasons.insert(name.into(), json!(reason));
        }
    }
    all.insert("integration".into(), json!(closure.integration));
    all.insert("departure".into(), json!(closure.departure));
    all.insert("integrated_flux".into(), json!(closure.integrated_flux));
    all.insert("identities".into(), json!(closure.identities));
    if !reasons.is_empty() {
        all.insert("reasons".into(), reasons.into());
    }
    all.into()
}
