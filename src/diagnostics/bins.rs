//! The intervals of the frequency (wavenumber) axis that bins represent.

/// Bins of a one-sided spectrum: bin m represents half a bin to both sides of `q_m`; 0 and, at even
/// length, Nyquist represent half a bin inside the axis.
#[derive(Debug)]
pub(crate) struct Bins<'a> {
    /// `q_m`, from 0.
    pub centres: &'a [f64],
    /// Upper end of the axis, Nyquist: the end of the last bin's interval.
    top: f64,
    /// Distance between bins; of a lone bin twice its width.
    pub step: f64,
}

impl<'a> Bins<'a> {
    /// Bins of a transform of `length` samples, `step` apart.
    pub fn new(centres: &'a [f64], length: usize, step: f64) -> Self {
        let top = 0.5 * length as f64 * step;
        Bins { centres, top, step }
    }

    /// Nyquist: the upper end of the axis.
    pub fn top(&self) -> f64 {
        self.top
    }

    pub fn len(&self) -> usize {
        self.centres.len()
    }

    fn low(&self, m: usize) -> f64 {
        match m {
            0 => 0.0,
            _ => (m as f64 - 0.5) * self.step,
        }
    }

    fn high(&self, m: usize) -> f64 {
        match m + 1 == self.len() {
            true => self.top,
            false => (m as f64 + 0.5) * self.step,
        }
    }

    /// Whether the last bin is half as wide as others: Nyquist's, at even length.
    pub fn ends_half(&self) -> bool {
        let last = self.len() - 1;
        last > 0 && self.high(last) - self.low(last) < 0.75 * self.step
    }

    /// The bin whose interval contains `edge`, and the part of it below the edge; the whole axis if
    /// the edge is beyond its end.
    pub fn split(&self, edge: f64) -> (usize, f64) {
        let last = self.len() - 1;
        // A saturating cast: edges may be anywhere.
        let m = ((edge / self.step + 0.5).floor().max(0.0) as usize).min(last);
        let (low, high) = (self.low(m), self.high(m));
        (m, ((edge - low) / (high - low)).clamp(0.0, 1.0))
    }

    /// Where the sum of `shares`, those of the bins from `first` on, reaches `level`.
    pub fn reached(&self, first: usize, shares: impl Iterator<Item = f64>, level: f64) -> f64 {
        let (mut below, mut end) = (0.0, self.low(first));
        for (m, share) in (first..).zip(shares) {
            if share > 0.0 {
                if below + share >= level {
                    let part = ((level - below) / share).clamp(0.0, 1.0);
                    let (low, high) = (self.low(m), self.high(m));
                    return low + part * (high - low);
                }
                end = self.high(m);
            }
            below += share;
        }
        // Only the sum in pairs reaches it: the end of what there is.
        end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: 8 samples have bins of widths 1/2, 1, 1, 1, 1/2; 7 have 1/2, 1, 1, 1.
    #[test]
    fn val_bins_cover_the_axis_up_to_nyquist() {
        let centres = [0.0, 1.0, 2.0, 3.0, 4.0];
        let even = Bins::new(&centres, 8, 1.0);
        let odd = Bins::new(&centres[..4], 7, 1.0);
        assert!(even.ends_half() && !odd.ends_half());
        assert_eq!((even.high(4), odd.high(3)), (4.0, 3.5));
        assert_eq!((even.split(0.25), even.split(3.75)), ((0, 0.5), (4, 0.5)));
        assert_eq!((odd.split(3.0), odd.split(9.0)), ((3, 0.5), (3, 1.0)));
        assert_eq!(even.split(0.0), (0, 0.0));
        let flat = [0.125, 0.25, 0.25, 0.25, 0.125];
        for level in [0.1, 0.125, 0.5, 0.9, 1.0] {
            assert_eq!(even.reached(0, flat.into_iter(), level), 4.0 * level);
        }
    }
}
