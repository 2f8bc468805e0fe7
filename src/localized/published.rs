//! Published ratios.

/// A row of Table 1 of the source paper.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Published {
    /// The order as printed.
    pub printed_order: usize,
    /// The order that the row's estimate belongs to; that of row "18" belongs to order 19.
    pub order: usize,
    /// From simulated chains.
    pub direct: f64,
    /// From the asymptotic condition on the fitted profile.
    pub estimate: f64,
}

/// R. Chaunsali, M. Toles, J. Yang, E. Kim, *Extreme control of impulse transmission by
/// cylinder-based nonlinear phononic crystals*, Table 1: stiffness ratios, Hertz contacts.
///
/// The direct values of orders 2 and 3 are correct as printed. The last digit of order 4 and the
/// last two digits of orders 5 to 7 are not (31.2757, 54.5201, 82.9973, 119.9304). The direct value
/// of the last row is not a localized wave: order 18 is at 1440.05492, order 19 at 1667.70163. The
/// estimate of that row belongs to order 19, and the direct value lies close to the estimate. A
/// plot of a simulation does not show the difference: a struck pulse loses 2e-11 of its energy per
/// cell at 1631.0, and at most 4e-10 between the two orders.
pub const PUBLISHED: [Published; 8] = [
    row(1, 1, 1.0000, 1.3542),
    row(2, 2, 4.9272, 6.9766),
    row(3, 3, 14.622, 15.533),
    row(4, 4, 31.275, 29.809),
    row(5, 5, 54.517, 50.130),
    row(6, 6, 82.990, 77.948),
    row(7, 7, 119.92, 114.31),
    row(18, 19, 1631.0, 1629.9),
];

const fn row(printed_order: usize, order: usize, direct: f64, estimate: f64) -> Published {
    Published {
        printed_order,
        order,
        direct,
        estimate,
    }
}
