//! Ratios that others have published.

/// A row of Table 1 of the source paper.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Published {
    /// The order as printed.
    pub printed_order: usize,
    /// The order whose estimate the row has: that of the row "18" is the nineteenth.
    pub order: usize,
    /// From simulated chains.
    pub direct: f64,
    /// From the asymptotic condition on the fitted profile.
    pub estimate: f64,
}

/// R. Chaunsali, M. Toles, J. Yang, E. Kim, *Extreme control of impulse transmission by
/// cylinder-based nonlinear phononic crystals*, Table 1: stiffness ratios, Hertz contacts.
///
/// The direct values of orders 2 and 3 are exact as printed; the last digit of order 4 and the last
/// two of orders 5 to 7 are not (31.2757, 54.5201, 82.9973, 119.9304). The last row's is that of no
/// localized wave: 1440.05492 is order 18, 1667.70163 order 19. Its estimate is that of order 19, and
/// its direct value is as near to it. A simulation does not tell them apart by eye: a struck pulse
/// loses 2e-11 of its energy a cell at 1631.0, and 4e-10 at most between the two orders.
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
