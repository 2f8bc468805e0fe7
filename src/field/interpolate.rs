//! Samples between samples: the nearest one, a straight line, a cubic spline.

/// How samples at given places become samples at others.
///
/// For nodes `x_i` with values `y_i`, and a place `x = x_i + w (x_{i+1} - x_i)` with `0 <= w <= 1`:
///
/// - `Nearest`: `y_i` where `w <= 1/2`, else `y_{i+1}`.
/// - `Linear`: `(1 - w) y_i + w y_{i+1}`.
/// - `Cubic`: the piecewise cubic with two continuous derivatives through all nodes, whose third derivative
///   is continuous at the second and the last but one node, too (not-a-knot, as SciPy's `CubicSpline` has
///   it by default). Three nodes give a parabola, two a line.
///
/// A sample that is not finite is a gap: places beside it are gaps, and a spline passes through the other
/// nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// The value of the nearest node.
    Nearest,
    /// Straight lines.
    Linear,
    /// A cubic spline with not-a-knot ends.
    Cubic,
}

impl Interpolation {
    /// All methods.
    pub const ALL: [Interpolation; 3] = [
        Interpolation::Nearest,
        Interpolation::Linear,
        Interpolation::Cubic,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Interpolation::Nearest => "nearest",
            Interpolation::Linear => "linear",
            Interpolation::Cubic => "cubic",
        }
    }

    /// By how much of its amplitude a sine at half the Nyquist frequency is changed at a place `fraction` of
    /// a step behind a node, among nodes one step apart.
    ///
    /// With `theta = pi / 2` a step: `Linear` has the gain `|1 - w + w e^{i theta}|`, `Cubic` the gain
    /// `|sum_k B(k - w) e^{i theta k}| / (2/3 + cos(theta) / 3)` with the cubic B-spline `B`. `Nearest` keeps
    /// the amplitude and takes it at another time: the error is `|e^{i theta w} - 1|` with the distance `w`
    /// to the nearest node.
    ///
    /// # Examples
    /// ```
    /// use wavecascade::field::Interpolation;
    ///
    /// let percent = |method: Interpolation| (100.0 * method.error(0.5)).round();
    /// assert_eq!(Interpolation::ALL.map(percent), [77.0, 29.0, 3.0]);
    /// ```
    ///
    /// # Source
    /// M. Unser, Splines: a perfect fit for signal and image processing, IEEE Signal Processing Magazine 16,
    /// 22 (1999), for the spline.
    pub fn error(self, fraction: f64) -> f64 {
        let w = fraction.clamp(0.0, 1.0);
        match self {
            Interpolation::Nearest => 2.0 * (std::f64::consts::FRAC_PI_4 * w.min(1.0 - w)).sin(),
            Interpolation::Linear => 1.0 - (1.0 - w).hypot(w),
            Interpolation::Cubic => {
                let v = 1.0 - w;
                let of = |w: f64| (4.0 - 6.0 * w * w + 3.0 * w * w * w) / 6.0;
                let (behind, here, next, after) = (v.powi(3) / 6.0, of(w), of(v), w.powi(3) / 6.0);
                1.0 - (here - after).hypot(next - behind) * 1.5
            }
        }
    }
}

/// A method with the nodes and the places of all series that it is used on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Interpolant {
    method: Interpolation,
    nodes: Vec<f64>,
    places: Vec<Place>,
    spline: Option<Spline>,
}

/// A place between a node and the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    node: usize,
    /// Share of the distance to the next node, below 1; 0 at the last node.
    fraction: f64,
}

impl Interpolant {
    /// From values at increasing `nodes` to those at increasing `places` between the first and the last.
    pub(crate) fn new(
        method: Interpolation,
        nodes: Vec<f64>,
        places: impl Iterator<Item = f64>,
    ) -> Interpolant {
        let last = nodes.len() - 1;
        let mut node = 0;
        let places = places.map(|place| {
            while node < last && nodes[node + 1] <= place {
                node += 1;
            }
            let fraction = match node < last {
                true => ((place - nodes[node]) / (nodes[node + 1] - nodes[node])).max(0.0),
                false => 0.0,
            };
            Place { node, fraction }
        });
        Interpolant {
            method,
            places: places.collect(),
            spline: (method == Interpolation::Cubic && last > 0).then(|| Spline::new(&nodes)),
            nodes,
        }
    }

    /// How many values it takes.
    pub(crate) fn n_nodes(&self) -> usize {
        self.nodes.len()
    }

    /// How many it gives.
    pub(crate) fn n_places(&self) -> usize {
        self.places.len()
    }

    /// The largest [`Interpolation::error`] of all places.
    pub(crate) fn error(&self) -> f64 {
        let nearness = |place: &Place| place.fraction.min(1.0 - place.fraction);
        let worst = self.places.iter().map(nearness);
        self.method.error(worst.fold(0.0, f64::max))
    }

    /// The values at the places; `slopes` is scratch.
    pub(crate) fn apply(&self, values: &[f64], out: &mut [f64], slopes: &mut Vec<f64>) {
        assert_eq!((values.len(), out.len()), (self.n_nodes(), self.n_places()));
        if self.spline.is_some() {
            self.slopes(values, slopes);
        }
        for (out, &Place { node, fraction }) in out.iter_mut().zip(&self.places) {
            let here = values[node];
            if fraction == 0.0 {
                *out = here;
                continue;
            }
            let next = values[node + 1];
            *out = match self.method {
                _ if !(here.is_finite() && next.is_finite()) => f64::NAN,
                Interpolation::Nearest if fraction <= 0.5 => here,
                Interpolation::Nearest => next,
                Interpolation::Linear => here + fraction * (next - here),
                Interpolation::Cubic => {
                    let step = self.nodes[node + 1] - self.nodes[node];
                    let secant = (next - here) / step;
                    let (a, b) = (slopes[node], slopes[node + 1]);
                    let bend = (a + b - 2.0 * secant) / step;
                    let x = fraction * step;
                    here + x * (a + x * ((secant - a) / step - bend + x * (bend / step)))
                }
            };
        }
    }

    /// The derivatives of the spline at all nodes, through those that are finite.
    fn slopes(&self, values: &[f64], slopes: &mut Vec<f64>) {
        slopes.clear();
        slopes.resize(values.len(), f64::NAN);
        let finite = (0..values.len()).filter(|&i| values[i].is_finite());
        let finite: Vec<usize> = finite.collect();
        match &self.spline {
            Some(spline) if finite.len() == values.len() => return spline.slopes(values, slopes),
            _ if finite.len() < 2 => return,
            _ => {}
        }
        let of = |all: &[f64]| -> Vec<f64> { finite.iter().map(|&i| all[i]).collect() };
        let mut some = vec![0.0; finite.len()];
        Spline::new(&of(&self.nodes)).slopes(&of(values), &mut some);
        for (&i, slope) in finite.iter().zip(some) {
            slopes[i] = slope;
        }
    }
}

/// The equations for the derivatives of a spline at its nodes, with the lower diagonal eliminated.
///
/// Without exchange of rows: beyond the first row, what remains on the diagonal exceeds what is beside it.
#[derive(Debug, Clone, PartialEq)]
struct Spline {
    steps: Vec<f64>,
    /// What multiplies the row before when it is subtracted.
    factors: Vec<f64>,
    diagonal: Vec<f64>,
    upper: Vec<f64>,
}

impl Spline {
    fn new(nodes: &[f64]) -> Spline {
        let steps: Vec<f64> = nodes.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let n = nodes.len();
        let mut spline = Spline {
            factors: vec![0.0; n],
            diagonal: vec![1.0; n],
            upper: vec![0.0; n],
            steps,
        };
        if n > 3 {
            spline.eliminate();
        }
        spline
    }

    fn eliminate(&mut self) {
        let (steps, last) = (&self.steps, self.steps.len());
        self.diagonal[0] = steps[1];
        self.upper[0] = steps[0] + steps[1];
        for i in 1..=last {
            let (lower, diagonal, upper) = match i == last {
                true => (steps[last - 2] + steps[last - 1], steps[last - 2], 0.0),
                false => (steps[i], 2.0 * (steps[i - 1] + steps[i]), steps[i - 1]),
            };
            self.factors[i] = lower / self.diagonal[i - 1];
            self.diagonal[i] = diagonal - self.factors[i] * self.upper[i - 1];
            self.upper[i] = upper;
        }
    }

    fn slopes(&self, values: &[f64], slopes: &mut [f64]) {
        let h = &self.steps;
        let last = h.len();
        let secant = |i: usize| (values[i + 1] - values[i]) / h[i];
        match last {
            1 => return slopes.fill(secant(0)),
            2 => {
                let bend = (secant(1) - secant(0)) / (h[0] + h[1]);
                slopes[0] = secant(0) - bend * h[0];
                slopes[1] = secant(0) + bend * h[0];
                slopes[2] = secant(1) + bend * h[1];
                return;
            }
            _ => {}
        }
        // At an end: its step, the step beside it, and the secants over both.
        let end = |own: f64, other: f64, own_secant: f64, other_secant: f64| {
            let both = own + other;
            ((own + 2.0 * both) * other * own_secant + own * own * other_secant) / both
        };
        slopes[0] = end(h[0], h[1], secant(0), secant(1));
        for i in 1..last {
            let right = 3.0 * (h[i] * secant(i - 1) + h[i - 1] * secant(i));
            slopes[i] = right - self.factors[i] * slopes[i - 1];
        }
        let right = end(h[last - 1], h[last - 2], secant(last - 1), secant(last - 2));
        slopes[last] = (right - self.factors[last] * slopes[last - 1]) / self.diagonal[last];
        for i in (0..last).rev() {
            slopes[i] = (slopes[i] - self.upper[i] * slopes[i + 1]) / self.diagonal[i];
        }
    }
}
