//! Warnings about a run.

use super::RunWarning;

impl RunWarning {
    /// One sentence with the numbers.
    pub fn message(&self) -> String {
        match self {
            RunWarning::Amplifies {
                tolerance,
                reached,
                rounding,
                growth,
            } => {
                let growth = growth.map_or(String::new(), |[rate, until]| {
                    format!(" (the largest Lyapunov exponent is about {rate:.1e}; they stand to {tolerance:.1e} until {until:.3e})")
                });
                format!(
                    "velocities stand to {reached:.1e}, not to {tolerance:.1e}, and were not stepped finer: \
                     two runs grow apart so fast that rounding alone leaves about {rounding:.0e}{growth}"
                )
            }
            RunWarning::Rounding { tolerance, reached } => format!(
                "velocities stand to {reached:.1e}, not to {tolerance:.1e}: rounding leaves no more"
            ),
            RunWarning::OutsideLaw {
                contact,
                overlap,
                range: [least, most],
            } => format!(
                "the overlap of contact {contact} reached {overlap:.3e}, but its law is known from {least:.3e} to \
                 {most:.3e}: beyond, the force was taken along a line"
            ),
            RunWarning::EnergyBalance { drift, allowed } => format!(
                "the energy changed by {drift:.1e} of itself without work or loss, where {allowed:.1e} \
                 would be in order: collisions are shorter than the steps resolve"
            ),
        }
    }
}
