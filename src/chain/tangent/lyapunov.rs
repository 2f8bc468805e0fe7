//! How fast small differences of the start grow along a run.

use super::{Direction, Follower};
use crate::chain::simulation::Simulation;
use crate::error::Result;
use crate::numeric::lanes::LaneBlock;
use crate::observer::Observer;

/// Equal parts of the run, after each of which the tangent is renormalised.
const PARTS: usize = 256;

/// The largest Lyapunov exponent of a run.
///
/// # Equation
/// `lambda(t) = ln(|Y(t)| / |Y(0)|) / t`, Y the tangent of the run (see [`Simulation::tangents`]) that starts with the velocities
/// `cos j` of bodies j, `|Y|^2 = sum_j m_j (v_j^2 + (x_j / tau)^2)`, tau the longest time in which a contact stops a body.
///
/// # Units
/// Over the unit of time.
///
/// # Source
/// G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9-30.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Lyapunov {
    /// At the end of the run.
    pub exponent: f64,
    /// After an eighth, a quarter, a half, and all of the run: time and exponent. Of regular motion it falls as `ln(t) / t`.
    pub convergence: [[f64; 2]; 4],
}

impl Simulation {
    /// The largest Lyapunov exponent along a run to this time.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for schemes of fixed steps; as [`Simulation::run`].
    pub fn lyapunov(&self, end: f64, observer: &dyn Observer) -> Result<Lyapunov> {
        self.check()?;
        let local = self.local_error("lyapunov")?;
        let [below, above] = [-0.5, 0.5].map(|share| {
            let mut kicked = self.clone();
            let bodies = kicked.velocity.iter_mut().enumerate();
            bodies.for_each(|(j, v)| *v += share * (j as f64).cos());
            kicked
        });
        let directions = [Direction::between(&below, &above, 1.0)?];
        let times: Vec<f64> = (0..=PARTS).map(|i| end * i as f64 / PARTS as f64).collect();
        let tau = self.contact_time(self.speed());
        let mut grown = Vec::with_capacity(times.len());
        self.pass(&directions, &times, local, observer, &mut |follower| {
            let before = grown.last().copied().unwrap_or(0.0);
            grown.push(before + follower.renormalised(tau).ln());
        })?;
        let convergence = [8, 4, 2, 1].map(|part| {
            let i = PARTS / part;
            [times[i], (grown[i] - grown[0]) / times[i]]
        });
        Ok(Lyapunov {
            exponent: convergence[3][1],
            convergence,
        })
    }
}

impl Follower<'_> {
    /// The size of the first tangent, which is brought to 1.
    fn renormalised(&mut self, tau: f64) -> f64 {
        let square =
            |(m, [x, v]): (&f64, &[LaneBlock; 2])| m * (v.0[0].powi(2) + (x.0[0] / tau).powi(2));
        let size = self
            .masses
            .iter()
            .zip(&self.at.each)
            .map(square)
            .sum::<f64>()
            .sqrt();
        let all = self.at.each.iter_mut().flatten().map(|each| &mut each.0[0]);
        all.chain(&mut self.largest[..1])
            .for_each(|value| *value /= size);
        size
    }
}
