//! Findings about a run, said to a person, each with what to do.

use super::RunWarning;

impl RunWarning {
    /// One sentence with the numbers.
    pub fn message(&self) -> String {
        match self {
            RunWarning::Sensitive {
                tolerance,
                reached,
                amplification,
            } => format!(
                "two runs agree to {reached:.1e}, which does not assure {tolerance:.1e}, whatever the \
                 steps: the chain amplifies a relative change of its masses at least \
                 {amplification:.1e} times"
            ),
            RunWarning::Rounding { tolerance, reached } => format!(
                "two runs agree to {reached:.1e}, which does not assure {tolerance:.1e}; rounding \
                 leaves no more"
            ),
        }
    }

    /// What the user can do about it.
    pub fn advice(&self) -> String {
        match self {
            RunWarning::Sensitive { .. } => {
                "state a larger `tolerance` or an earlier `end_time`; where single velocities are \
                 not to be had, compare energies and spectra, over several seeds"
            }
            RunWarning::Rounding { .. } => "state a larger `tolerance`",
        }
        .into()
    }
}
