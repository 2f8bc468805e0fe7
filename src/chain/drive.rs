//! What moves or pushes the first end.

/// A waveform in time, zero before t = 0.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Waveform {
    /// `amplitude * sin(2 pi frequency t)`, frequency in cycles per time unit.
    Sine { amplitude: f64, frequency: f64 },
    /// `amplitude * sin(pi t / duration)` up to `duration`, 0 after.
    HalfSine { amplitude: f64, duration: f64 },
}

impl Waveform {
    /// Value at time t.
    pub fn at(&self, t: f64) -> f64 {
        let (amplitude, phase) = self.phase(t);
        amplitude * phase.sin()
    }

    /// Derivative in time at time t.
    pub fn rate_at(&self, t: f64) -> f64 {
        let (amplitude, phase) = self.phase(t);
        if amplitude == 0.0 {
            return 0.0;
        }
        amplitude * self.angular_frequency() * phase.cos()
    }

    /// Second derivative in time at time t.
    pub fn acceleration_at(&self, t: f64) -> f64 {
        -self.angular_frequency().powi(2) * self.at(t)
    }

    /// The time at which the waveform ends; infinite for a sine.
    pub fn end(&self) -> f64 {
        match self {
            Waveform::Sine { .. } => f64::INFINITY,
            Waveform::HalfSine { duration, .. } => *duration,
        }
    }

    /// The same up to its end, and smooth beyond: what a step that ends there sees.
    pub(crate) fn onward(&self) -> Waveform {
        match *self {
            Waveform::HalfSine {
                amplitude,
                duration,
            } => Waveform::Sine {
                amplitude,
                frequency: 0.5 / duration,
            },
            sine => sine,
        }
    }

    pub fn angular_frequency(&self) -> f64 {
        match self {
            Waveform::Sine { frequency, .. } => 2.0 * std::f64::consts::PI * frequency,
            Waveform::HalfSine { duration, .. } => std::f64::consts::PI / duration,
        }
    }

    pub fn amplitude(&self) -> f64 {
        match self {
            Waveform::Sine { amplitude, .. } | Waveform::HalfSine { amplitude, .. } => *amplitude,
        }
    }

    fn phase(&self, t: f64) -> (f64, f64) {
        match self {
            Waveform::HalfSine { duration, .. } if t > *duration => (0.0, 0.0),
            _ => (self.amplitude(), self.angular_frequency() * t),
        }
    }
}

/// A driven first end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive {
    /// A force on site 0, positive towards +x.
    Force(Waveform),
    /// The displacement of the wall before site 0, positive towards +x.
    Wall(Waveform),
}

impl Drive {
    /// With another waveform.
    pub(crate) fn with(self, waveform: Waveform) -> Drive {
        match self {
            Drive::Force(_) => Drive::Force(waveform),
            Drive::Wall(_) => Drive::Wall(waveform),
        }
    }

    pub fn waveform(&self) -> &Waveform {
        match self {
            Drive::Force(waveform) | Drive::Wall(waveform) => waveform,
        }
    }
}
