//! What moves or pushes a chain from outside.

use std::f64::consts::PI;
use std::sync::Arc;

use super::spline::Spline;
use crate::numeric::{fresnel_auxiliary, next_uniform};
use crate::{Error, Result};

/// Sines of which noise is the sum.
const NOISE_LINES: usize = 128;

/// A waveform in time, with a start and an end, constant before and after.
#[derive(Debug, Clone, PartialEq)]
pub struct Waveform {
    form: Arc<Form>,
    span: [f64; 2],
    /// Values before the start and after the end.
    outside: [f64; 2],
    /// Largest magnitude, and the angular frequency of its fastest part.
    size: f64,
    fastest: f64,
}

/// What a [`Waveform`] is between its start and its end, and smooth beyond.
#[derive(Debug, PartialEq)]
enum Form {
    /// `offset + sum a sin(w t + phase)`, each sine as `[a, w, phase]`.
    Sines {
        offset: f64,
        sines: Vec<[f64; 3]>,
    },
    /// The derivative of this order of a chirp, -1 for its integral from 0 on.
    Chirp(Chirp, i32),
    Spline(Spline),
}

/// `amplitude * sin(2 pi (from + rate t / 2) t)`, of a rate other than 0.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Chirp {
    amplitude: f64,
    from: f64,
    rate: f64,
}

impl Chirp {
    /// The derivative of this order at time t; of order -1 the integral from 0 on.
    fn derivative(&self, order: i32, t: f64) -> f64 {
        let turns = 2.0 * PI;
        let frequency = self.from + self.rate * t;
        let (sin, cos) = (turns * (self.from + 0.5 * self.rate * t) * t).sin_cos();
        self.amplitude
            * match order {
                -1 => self.swept(0.0, [0.0, 1.0]) - self.swept(t, [sin, cos]),
                0 => sin,
                1 => turns * frequency * cos,
                _ => turns * self.rate * cos - (turns * frequency).powi(2) * sin,
            }
    }

    /// (f(z) cos φ + g(z) sin φ) / √(2 |rate|) at z = frequency √(2 / |rate|), sine and cosine of the phase φ at hand: the
    /// integral of sin φ but for its sign and a constant, without the cancellation of Fresnel's S and C at many cycles.
    fn swept(&self, t: f64, [sin, cos]: [f64; 2]) -> f64 {
        let size = (2.0 * self.rate.abs()).sqrt();
        // Rounding may put the last frequency of a chirp to 0 below it.
        let z = (2.0 * (self.from + self.rate * t) / size).max(0.0);
        let [f, g] = fresnel_auxiliary(z);
        (f * cos + self.rate.signum() * g * sin) / size
    }
}

impl Form {
    /// The derivative of this order, 0 to 2, at time t.
    fn derivative(&self, order: usize, t: f64) -> f64 {
        match self {
            Form::Sines { offset, sines } => {
                let offset = if order == 0 { *offset } else { 0.0 };
                let each = sines.iter().map(|[a, w, phase]| {
                    let angle = w * t + phase;
                    match order {
                        0 => a * angle.sin(),
                        1 => a * w * angle.cos(),
                        _ => -a * w * w * angle.sin(),
                    }
                });
                offset + each.sum::<f64>()
            }
            Form::Chirp(chirp, own) => chirp.derivative(own + order as i32, t),
            Form::Spline(spline) => spline.derivative(order, t),
        }
    }
}

impl Waveform {
    /// `amplitude * sin(2 pi frequency t)`, frequency in cycles per time unit.
    pub fn sine(amplitude: f64, frequency: f64) -> Waveform {
        one_sine(amplitude, 2.0 * PI * frequency, f64::INFINITY)
    }

    /// `amplitude * sin(pi t / duration)` up to `duration`, 0 after.
    pub fn half_sine(amplitude: f64, duration: f64) -> Waveform {
        one_sine(amplitude, PI / duration, duration)
    }

    /// `cycles` cycles of a sine under Hann's window: `amplitude sin(2 pi f t) sin^2(pi f t / cycles)` up to
    /// `cycles / f`, 0 after.
    pub fn tone_burst(amplitude: f64, frequency: f64, cycles: f64) -> Waveform {
        let w = 2.0 * PI * frequency;
        let beside = w / cycles;
        let sines = vec![
            [0.5 * amplitude, w, 0.0],
            [-0.25 * amplitude, w + beside, 0.0],
            [-0.25 * amplitude, w - beside, 0.0],
        ];
        sum_of_sines(sines, cycles / frequency, [amplitude.abs(), w + beside])
    }

    /// `amplitude sin(2 pi (f0 t + (f1 - f0) t^2 / (2 duration)))` up to `duration`, 0 after: the
    /// frequency goes evenly from f0 to f1.
    pub fn chirp(amplitude: f64, [from, to]: [f64; 2], duration: f64) -> Waveform {
        let fastest = 2.0 * PI * from.max(to);
        if from == to {
            return one_sine(amplitude, fastest, duration);
        }
        let rate = (to - from) / duration;
        let chirp = Chirp {
            amplitude,
            from,
            rate,
        };
        ended(Form::Chirp(chirp, 0), duration, [amplitude.abs(), fastest])
    }

    /// Noise of this root mean square in a band of frequencies, up to `duration`, 0 after: the sum of 128 sines
    /// of equal amplitudes, one at a random frequency in each of as many equal parts of the band, with random
    /// phases; the same on every machine for a seed.
    pub fn noise(rms: f64, [low, high]: [f64; 2], seed: u64, duration: f64) -> Waveform {
        let mut state = seed;
        let mut random = || next_uniform(&mut state);
        let (part, amplitude) = (
            (high - low) / NOISE_LINES as f64,
            rms * (2.0 / NOISE_LINES as f64).sqrt(),
        );
        let sines = (0..NOISE_LINES).map(|i| {
            let frequency = low + part * (i as f64 + random());
            [amplitude, 2.0 * PI * frequency, 2.0 * PI * random()]
        });
        sum_of_sines(
            sines.collect(),
            duration,
            [3.0 * rms.abs(), 2.0 * PI * high],
        )
    }

    /// The spline of degree five through values at rising times. Before and after them it is 0.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for fewer than six values, times that do not rise, and values that are not finite.
    pub fn through(times: &[f64], values: &[f64]) -> Result<Waveform> {
        let spline = Spline::through(times, values)?;
        let first = values.first().copied().unwrap_or(0.0);
        Ok(of_spline(spline, first))
    }

    /// The integral from 0 on, which stays as it is when the waveform is over: the displacement that belongs to a
    /// velocity.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for the integral of a chirp.
    pub fn integral(&self) -> Result<Waveform> {
        let size = [self.size / self.fastest, self.fastest];
        let integrated = |form| ended(form, self.span[1], size).held();
        match &*self.form {
            Form::Sines { sines, .. } => {
                let sines = sines.iter().filter(|[_, w, _]| *w != 0.0);
                let sines = sines.map(|[a, w, phase]| [a / w, *w, phase - 0.5 * PI]);
                let sines: Vec<[f64; 3]> = sines.collect();
                let offset: f64 = sines.iter().map(|[a, _, phase]| -a * phase.sin()).sum();
                Ok(integrated(Form::Sines { offset, sines }))
            }
            Form::Chirp(chirp, 0) => Ok(integrated(Form::Chirp(*chirp, -1))),
            Form::Chirp(..) => {
                let expected = "a waveform that is no integral of a chirp already";
                Err(Error::request("drive", expected, "one"))
            }
            Form::Spline(spline) => Ok(of_spline(spline.integral(), 0.0).held()),
        }
    }

    /// The same, which stays as it is at its ends: a displacement.
    #[must_use]
    pub fn held(mut self) -> Waveform {
        if let Form::Spline(_) = &*self.form {
            self.outside[0] = self.form.derivative(0, self.span[0]);
        }
        if self.span[1].is_finite() {
            self.outside[1] = self.form.derivative(0, self.span[1]);
        }
        self
    }

    /// Value at time t.
    pub fn at(&self, t: f64) -> f64 {
        self.derivative(0, t)
    }

    /// Derivative in time at time t.
    pub fn rate_at(&self, t: f64) -> f64 {
        self.derivative(1, t)
    }

    /// Second derivative in time at time t.
    pub fn acceleration_at(&self, t: f64) -> f64 {
        self.derivative(2, t)
    }

    fn derivative(&self, order: usize, t: f64) -> f64 {
        let outside = |value: f64| if order == 0 { value } else { 0.0 };
        match self.span {
            [start, _] if t < start => outside(self.outside[0]),
            [_, end] if t > end => outside(self.outside[1]),
            _ => self.form.derivative(order, t),
        }
    }

    /// The time at which the waveform ends; infinite for a sine.
    pub fn end(&self) -> f64 {
        self.span[1]
    }

    /// The times after 0 at which it, or a derivative, jumps.
    pub(crate) fn kinks(&self) -> impl Iterator<Item = f64> {
        let ends = self.span.into_iter();
        ends.filter(|t| *t > 0.0 && t.is_finite())
    }

    /// The largest jump of its rate before time `end`, time 0 apart.
    pub(crate) fn largest_jump(&self, end: f64) -> f64 {
        let kinks = self.kinks().filter(|t| *t < end);
        let jump = |t: f64| {
            let before = self.onward(t.next_down()).0.rate_at(t);
            (self.onward(t).0.rate_at(t) - before).abs()
        };
        kinks.map(jump).fold(0.0, f64::max)
    }

    /// What it is from time t on, smooth beyond its next kink, and when that is; `None` once it is over.
    /// A step that ends at a kink sees its own side of it.
    pub(crate) fn onward(&self, t: f64) -> (Waveform, Option<f64>) {
        match self.span {
            [start, _] if t < start => (constant(self.outside[0]), Some(start)),
            [_, end] if t < end => {
                let mut smooth = self.clone();
                smooth.span = [f64::NEG_INFINITY, f64::INFINITY];
                (smooth, Some(end))
            }
            _ => (constant(self.outside[1]), None),
        }
    }

    /// The angular frequency of its fastest part.
    pub fn angular_frequency(&self) -> f64 {
        self.fastest
    }

    /// Its largest magnitude; of noise three times its root mean square.
    pub fn amplitude(&self) -> f64 {
        self.size
    }
}

fn one_sine(amplitude: f64, w: f64, end: f64) -> Waveform {
    sum_of_sines(vec![[amplitude, w, 0.0]], end, [amplitude.abs(), w])
}

fn sum_of_sines(sines: Vec<[f64; 3]>, end: f64, size: [f64; 2]) -> Waveform {
    ended(Form::Sines { offset: 0.0, sines }, end, size)
}

/// From time 0 to its end, of this largest magnitude and fastest angular frequency.
fn ended(form: Form, end: f64, [size, fastest]: [f64; 2]) -> Waveform {
    Waveform {
        form: Arc::new(form),
        span: [f64::NEG_INFINITY, end],
        outside: [0.0; 2],
        size,
        fastest,
    }
}

fn of_spline(spline: Spline, first: f64) -> Waveform {
    let span = spline.span();
    let [size, rate, bend] = spline.largest(first);
    // Of a spline that is constant nothing is fast.
    let length = span[1] - span[0];
    let fastest = match size > 0.0 {
        true => (rate / size).max((bend / size).sqrt()),
        false => 0.0,
    };
    Waveform {
        form: Arc::new(Form::Spline(spline)),
        span,
        outside: [0.0; 2],
        size: size.max(first.abs()),
        fastest: fastest.max(PI / length),
    }
}

fn constant(value: f64) -> Waveform {
    let form = Form::Sines {
        offset: value,
        sines: Vec::new(),
    };
    ended(form, f64::INFINITY, [value.abs(), 0.0])
}

/// What is driven, and how.
#[derive(Debug, Clone, PartialEq)]
pub enum Drive {
    /// A force on site 0, whose end is free, positive towards +x.
    Force(Waveform),
    /// The displacement of the wall before site 0, positive towards +x.
    Wall(Waveform),
    /// A force on the body of this index, positive towards +x.
    Body(usize, Waveform),
    /// The displacement of the body of this index, positive towards +x, whatever pushes it.
    Motion(usize, Waveform),
}

impl Drive {
    /// With another waveform.
    pub(crate) fn with(&self, waveform: Waveform) -> Drive {
        match self {
            Drive::Force(_) => Drive::Force(waveform),
            Drive::Wall(_) => Drive::Wall(waveform),
            Drive::Body(site, _) => Drive::Body(*site, waveform),
            Drive::Motion(site, _) => Drive::Motion(*site, waveform),
        }
    }

    pub fn waveform(&self) -> &Waveform {
        match self {
            Drive::Force(waveform)
            | Drive::Wall(waveform)
            | Drive::Body(_, waveform)
            | Drive::Motion(_, waveform) => waveform,
        }
    }

    /// The body that is pushed or moved, or that touches the wall that is moved.
    pub fn site(&self) -> usize {
        match self {
            Drive::Body(site, _) | Drive::Motion(site, _) => *site,
            Drive::Force(_) | Drive::Wall(_) => 0,
        }
    }

    /// The body whose motion is prescribed, and its displacement.
    pub(crate) fn motion(&self) -> Option<(usize, &Waveform)> {
        match self {
            Drive::Motion(site, waveform) => Some((*site, waveform)),
            _ => None,
        }
    }

    /// The force from outside on [`Drive::site`] at time t, where forces of `inner` from the chain give it without a
    /// drive this mass times its acceleration.
    pub(crate) fn push_at(&self, t: f64, mass: f64, inner: impl FnOnce() -> f64) -> f64 {
        match self {
            Drive::Force(waveform) | Drive::Body(_, waveform) => waveform.at(t),
            Drive::Motion(_, waveform) => mass * waveform.acceleration_at(t) - inner(),
            Drive::Wall(_) => 0.0,
        }
    }
}
