//! What a transfer between two sites is, and what can be said of it.

use crate::estimates::realisations::Independence;
use crate::field::Axis;
use crate::numeric::chi_square_level;

/// What [`transfer`](super::transfer::transfer) finds. Errors are standard errors.
#[derive(Debug, Clone)]
pub struct Transfer {
    pub time: Axis,
    pub space: Axis,
    /// Unit of the samples.
    pub unit: Option<String>,
    pub from: usize,
    pub to: usize,
    pub lag: usize,
    /// Samples of a segment, and shared by neighbours.
    pub segment: [usize; 2],
    pub independence: Independence,
    pub alpha: f64,
    /// The most unknowns of a frequency.
    pub unknowns: usize,
    /// Blocks of realisations that are drawn, and how often.
    pub blocks: usize,
    pub resamplings: usize,
    /// Of each output frequency.
    pub outputs: Vec<OutputTransfer>,
    /// Of each pair of input frequencies, output by output.
    pub pairs: Vec<PairTransfer>,
    pub shares: TransferShares,
}

/// The balance of one output frequency: `output = input + linear + gain + residual`, one-sided power spectral
/// densities.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct OutputTransfer {
    pub frequency: f64,
    pub input: f64,
    pub output: f64,
    /// Magnitude and phase (rad) of the linear transfer function.
    pub magnitude: f64,
    pub phase: f64,
    pub magnitude_error: f64,
    /// What the linear transfer changes: `(|L|^2 - 1) input`.
    pub linear: f64,
    pub linear_error: f64,
    /// What pairs of other frequencies bring, less what they take.
    pub gain: f64,
    pub gain_error: f64,
    /// What no term explains.
    pub residual: f64,
    /// `- sum gain df` up to this frequency: power that passes it towards higher ones by quadratic terms.
    pub flux: f64,
    pub flux_error: f64,
    /// `sum gain df` above this frequency: equal to the flux if the model has all that gain and lose.
    pub above: f64,
    pub above_error: f64,
    /// Share of the output of realisations that were not fitted, by the linear term, and by what quadratic terms
    /// add.
    pub held_out_linear: f64,
    pub held_out_quadratic: f64,
    pub unknowns: usize,
    /// Terms that others replace: inputs that vary together.
    pub undetermined: usize,
}

/// What one pair of frequencies brings to their sum, or to their difference (`second` negative).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct PairTransfer {
    pub first: f64,
    pub second: f64,
    pub third: f64,
    /// `Q(f1, f2)` of `Y = L X + sum Q X X` over ordered pairs of Fourier coefficients, in 1 over the samples'
    /// unit.
    pub re: f64,
    pub im: f64,
    /// Part of the output's `gain`.
    pub gain: f64,
    pub gain_error: f64,
}

/// Shares of the output's power in all frequencies of the model.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct TransferShares {
    /// Of the realisations that were fitted, freed of what chance alone explains.
    pub linear: f64,
    pub quadratic: f64,
    pub residual: f64,
    /// Of realisations that were not fitted (five parts, each predicted from the others).
    pub held_out_linear: f64,
    pub held_out_quadratic: f64,
    /// What quadratic terms explain of the rest that the linear term leaves, of realisations that were not fitted:
    /// the mean over frequencies, each at least -1.
    pub held_out_of_rest: f64,
    /// The same of the stronger half of the realisations, fitted to the weaker half; `None` for fewer than four
    /// realisations for each unknown.
    pub stronger_half_of_rest: Option<f64>,
}

impl OutputTransfer {
    /// Power that passes, at least: the smaller of what one side loses and the other gains.
    pub fn passed(&self) -> f64 {
        self.flux.abs().min(self.above.abs())
    }
}

impl Transfer {
    /// Whether quadratic terms explain anything of realisations that were not fitted, and do so at another
    /// amplitude.
    pub fn holds(&self) -> bool {
        let shares = &self.shares;
        shares.held_out_of_rest > 0.0
            && shares.stronger_half_of_rest.is_none_or(|share| share > 0.0)
    }

    /// The output at which most power passes, in either direction, if that is more than chance: what
    /// frequencies below lose and what those above gain have one sign, and both are beyond their interval at `1 - alpha`,
    /// corrected for the number of frequencies (Bonferroni).
    pub fn passage(&self) -> Option<&OutputTransfer> {
        let count = self.outputs.len().saturating_sub(1);
        let score = self.score(count);
        let inside = self.outputs[..count].iter();
        inside
            .filter(|output| {
                output.flux * output.above > 0.0
                    && output.flux.abs() > score * output.flux_error
                    && output.above.abs() > score * output.above_error
            })
            .max_by(|a, b| a.passed().total_cmp(&b.passed()))
    }

    /// The outputs that gain more than by chance, whoever loses, the one that gains most first.
    pub fn gaining(&self) -> Vec<&OutputTransfer> {
        let score = self.score(self.outputs.len());
        let outputs = self.outputs.iter();
        let mut gaining: Vec<_> = outputs.filter(|o| o.gain > score * o.gain_error).collect();
        gaining.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        gaining
    }

    /// What one of so many normal variables exceeds in magnitude with probability `alpha`.
    fn score(&self, count: usize) -> f64 {
        chi_square_level(self.alpha / count.max(1) as f64, 1.0).sqrt()
    }

    /// Mean square of the input in all frequencies of the model.
    pub fn input(&self) -> f64 {
        let df = self.outputs[0].frequency;
        self.outputs.iter().map(|output| output.input * df).sum()
    }
}
