//! Random states in place of a trajectory: identities hold for any states.

use ndarray::{Array1, Array2};
use test_support::measured::Normal;
use wavecascade::arrays::Arrays;
use wavecascade::budget::{Budget, BudgetRequest, Motion, budget};
use wavecascade::chain::{Chain, Drive};

use crate::wavenumber_only;

pub const STEP: f64 = 0.37;

pub struct States {
    pub chain: Chain,
    pub drive: Option<Drive>,
    pub time: Array1<f64>,
    pub x: Array2<f64>,
    pub v: Array2<f64>,
}

impl States {
    /// Nine states of a seed, numbers from -1 to 1.
    pub fn new(chain: Chain, drive: Option<Drive>, seed: u64) -> States {
        let dim = (9, chain.n_sites());
        let mut random = Normal(seed << 32);
        let mut array = || Array2::from_shape_simple_fn(dim, || random.between(-1.0, 1.0));
        States {
            drive,
            time: Array1::from_iter((0..dim.0).map(|i| STEP * i as f64)),
            x: array(),
            v: array(),
            chain,
        }
    }

    pub fn motion(&self) -> Motion<'_> {
        Motion {
            chain: &self.chain,
            drive: self.drive.as_ref(),
            time: self.time.view(),
            displacement: self.x.view(),
            velocity: self.v.view(),
            resonators: None,
            energy_passed: None,
            energy_lost: None,
            energy_input: None,
        }
    }

    pub fn budget(&self, request: &BudgetRequest) -> (Budget, Arrays) {
        budget(&self.motion(), request).unwrap()
    }

    pub fn wavenumbers(&self) -> (Budget, Arrays) {
        self.budget(&wavenumber_only())
    }
}
