//! Flux of energy and its loss against a run's own energy, and against waves of a lossy beam in closed form.

use std::f64::consts::{PI, TAU};

use ndarray::{Array2, s};
use test_support::changed;
use wavecascade::Field;
use wavecascade::analyze::{Constants, Dispersion};
use wavecascade::chain::{Chain, EndTime, Ends, Law, Losses, OnSite, Simulation};
use wavecascade::flux::{Flux, FluxRequest, GroupVelocity, Known, NoFlux, flux};
use wavecascade::observer::Silent;
use wavecascade::reference::Grid;
use wavecascade::transform::Travelling;

fn found(field: &Field, change: impl FnOnce(&mut FluxRequest)) -> Flux {
    flux(&[field], &changed(FluxRequest::default(), change), &Silent).unwrap()
}

/// A packet that passes a chain of linear springs: the energy that the run says passed a contact.
#[test]
fn val_energy_that_passes_a_chain() {
    let law = Law::Spring {
        alpha: 0.0,
        beta: 0.0,
    };
    let chain = Chain {
        mass: vec![1.0; 320],
        coefficient: vec![1.0; 319],
        law: law.into(),
        ends: Ends::Free,
        precompression: 0.0,
        losses: Losses::default(),
        on_site: OnSite::default(),
    };
    let (mut displacement, mut velocity) = (vec![0.0; 320], vec![0.0; 320]);
    for n in 1..200 {
        let k = PI * f64::from(n) / 200.0;
        let (amplitude, omega) = (
            (-0.5 * ((k - 0.7) / 0.1).powi(2)).exp(),
            2.0 * (0.5 * k).sin(),
        );
        for j in 0..320 {
            let phase = k * (j as f64 - 60.0);
            displacement[j] += amplitude * phase.cos();
            velocity[j] += amplitude * omega * phase.sin();
        }
    }
    let run = Simulation {
        displacement,
        velocity,
        end_time: EndTime::At(255.5),
        ..Simulation::impact(chain, 1.0, 255.5, 512)
    };
    let run = run.run(&Silent).unwrap();
    let passed = run.energy_passed.as_ref().unwrap();
    let passed = passed[[511, 120]];
    let mut field = Field::from_array(run.velocity.slice(s![.., 120..160]).to_owned());
    field.time.step = 0.5;
    let law = Dispersion::parse("2*abs(sin(k/2)); c=1", &Constants::new()).unwrap();
    let measured = found(&field, |_| {});
    let stated = found(&field, |request| {
        request.group_velocity = GroupVelocity::Of(law);
        request.towards = Travelling::TowardPlusX;
    });
    for (flux, within) in [(&measured, 1e-3), (&stated, 1e-6)] {
        let total = flux.total[0][0];
        println!(
            "{total:?} of {passed}, {:?}, stated {}",
            flux.total[1][0], flux.stated
        );
        assert!(
            (total.value / passed - 1.0).abs() < within,
            "{total:?} of {passed}"
        );
        assert!((total.value - passed).abs() <= total.half + 1e-6 * passed);
    }
}

/// Bending waves `2 pi f = c k^2` with a loss factor, random and Gaussian, of unit spectral density in a band, both ways.
#[derive(Clone, Copy)]
struct Beam {
    seed: u64,
    loss: f64,
    reflected: f64,
    gains: f64,
    noise: f64,
    stiffness: f64,
}

const BEAM: Beam = Beam {
    stiffness: 50.0,
    seed: 1,
    loss: 0.04,
    reflected: 0.0,
    gains: 0.0,
    noise: 0.0,
};
const GRID: Grid = Grid {
    n_times: 4096,
    n_sites: 40,
    dt: 1e-4,
    dx: 0.04,
};
const BAND: [f64; 2] = [600.0, 3200.0];
const WAVES: usize = 400;

impl Beam {
    fn wavenumber(&self, f: f64) -> f64 {
        (TAU * f / self.stiffness).sqrt()
    }

    fn group_velocity(&self, f: f64) -> f64 {
        2.0 * (TAU * f * self.stiffness).sqrt()
    }

    fn attenuation(&self, f: f64) -> f64 {
        self.loss * PI * f / self.group_velocity(f)
    }

    /// Power towards +x at a distance from the first site, of one unit of mass per length.
    fn power(&self, x: f64) -> f64 {
        let width = (BAND[1] - BAND[0]) / 1000.0;
        let all = (0..1000).map(|n| BAND[0] + (f64::from(n) + 0.5) * width);
        let parts = all.map(|f| self.group_velocity(f) * (-2.0 * self.attenuation(f) * x).exp());
        parts.sum::<f64>() * width
    }

    fn field(&self) -> Field {
        let mut state = self.seed;
        let mut uniform = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut gaussian = || (-2.0 * (1.0 - uniform()).ln()).sqrt() * (TAU * uniform()).cos();
        let (n_times, n_sites) = (GRID.n_times, GRID.n_sites);
        let mut values = vec![0.0; n_times * n_sites];
        let width = (BAND[1] - BAND[0]) / WAVES as f64;
        for n in 0..WAVES {
            let f = BAND[0] + (n as f64 + 0.5 + 0.3 * gaussian().clamp(-1.0, 1.0)) * width;
            let (a, k) = (self.attenuation(f), self.wavenumber(f));
            let [re, im] = [gaussian(), gaussian()].map(|part| part * width.sqrt());
            // The amplitude of each site as its real and imaginary part.
            let wave = |x: f64, share: f64| {
                let (size, phase) = (share * (-a * x).exp(), k * x);
                [
                    re * phase.cos() + im * phase.sin(),
                    im * phase.cos() - re * phase.sin(),
                ]
                .map(|part| size * part)
            };
            let last = (n_sites - 1) as f64 * GRID.dx;
            let sites: Vec<[f64; 2]> = (0..n_sites)
                .map(|j| {
                    let x = j as f64 * GRID.dx;
                    let [there, back] = [wave(x, 1.0), wave(2.0 * last + 0.1 - x, self.reflected)];
                    [there[0] + back[0], there[1] + back[1]]
                })
                .collect();
            for (t, row) in values.chunks_exact_mut(n_sites).enumerate() {
                let (sine, cosine) = (TAU * (f * GRID.dt * t as f64).fract()).sin_cos();
                let cells = row.iter_mut().zip(&sites);
                cells.for_each(|(v, [re, im])| *v += re * cosine - im * sine);
            }
        }
        let gains: Vec<f64> = (0..n_sites)
            .map(|_| 1.0 + self.gains * gaussian())
            .collect();
        let noise =
            self.noise * (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
        for (i, v) in values.iter_mut().enumerate() {
            *v = *v * gains[i % n_sites] + noise * gaussian();
        }
        GRID.sample("beam", |n, j| values[n * n_sites + j])
    }
}

/// Deviations of what is found from the truth, in halves of their intervals: the total at both ends, attenuation, loss
/// factor and group velocity of each band.
fn deviations(beam: &Beam, flux: &Flux) -> [Vec<f64>; 4] {
    let over = |known: Known, truth: f64| (known.value - truth) / known.half;
    let last = GRID.n_sites - 1;
    let ends = [0, last].map(|j| over(flux.total[0][j], beam.power(j as f64 * GRID.dx)));
    let inside = |band: &&wavecascade::flux::FluxBand| {
        band.reason.is_none() && band.from > BAND[0] && band.to < BAND[1]
    };
    let bands: Vec<_> = flux.bands.iter().filter(inside).collect();
    let of = |truth: &dyn Fn(f64) -> f64, known: fn(&wavecascade::flux::FluxBand) -> Known| {
        bands
            .iter()
            .map(|band| over(known(band), truth(band.frequency)))
            .collect()
    };
    [
        ends.to_vec(),
        of(&|f| beam.attenuation(f), |band| band.attenuation),
        of(&|_| beam.loss, |band| band.loss_factor),
        of(&|f| beam.group_velocity(f), |band| band.group_velocity),
    ]
}

const CASES: [Beam; 4] = [
    BEAM,
    Beam {
        reflected: 0.9,
        ..BEAM
    },
    Beam {
        gains: 0.05,
        noise: 0.2,
        ..BEAM
    },
    Beam {
        reflected: 0.9,
        gains: 0.05,
        noise: 0.2,
        ..BEAM
    },
];

#[test]
fn val_lossy_beam_both_ways() {
    for beam in CASES {
        let flux = found(&beam.field(), |_| {});
        let all = deviations(&beam, &flux);
        let factors = flux.bands.iter().map(|band| band.loss_factor.value);
        let mut factors: Vec<f64> = factors.filter(|value| value.is_finite()).collect();
        factors.sort_by(f64::total_cmp);
        let median = factors[factors.len() / 2];
        println!(
            "median {median} of {}, stated {}, {all:.2?}",
            factors.len(),
            flux.stated
        );
        assert!(flux.stated > 0.97 && factors.len() >= 18);
        let share = if beam.gains > 0.0 { 0.2 } else { 0.01 };
        assert!((median / beam.loss - 1.0).abs() < share);
        let outside = all.iter().flatten().filter(|z| !(z.abs() < 2.0)).count();
        assert!(outside <= 3, "{all:.2?}");
        // As much comes back as is left of it.
        let (back, last) = (flux.total[1][GRID.n_sites - 1], GRID.n_sites - 1);
        let returned = beam.reflected.powi(2) * beam.power((last as f64) * GRID.dx + 0.1);
        assert!(
            (back.value - returned).abs() < 2.0 * back.half + 1e-3 * returned,
            "{back:?} of {returned}"
        );
    }
}

/// Shares of intervals that hold over many fields.
#[test]
#[ignore = "slow: a survey of 120 fields"]
fn survey_of_intervals() {
    let mut held = [[0usize; 2]; 4];
    for seed in 0..120 {
        let beam = Beam {
            seed: 1000 + seed,
            ..CASES[seed as usize % 4]
        };
        let all = deviations(&beam, &found(&beam.field(), |_| {}));
        for (held, all) in held.iter_mut().zip(&all) {
            held[0] += all.iter().filter(|z| z.abs() < 1.0).count();
            held[1] += all.len();
        }
    }
    let shares = held.map(|[held, all]| held as f64 / all as f64);
    println!("total, attenuation, loss factor, group velocity: {shares:.3?} of {held:?}");
    assert!(
        shares.iter().all(|share| (0.92..0.99).contains(share)),
        "{shares:?}"
    );
}

#[test]
fn val_no_flux_is_stated_of_what_is_no_wave_of_one_branch() {
    let samples = |beam: Beam| {
        let (field, mut samples) = (beam.field(), Array2::zeros((GRID.n_times, GRID.n_sites)));
        let all = samples.as_slice_mut().unwrap();
        field.read_time_major(0..GRID.n_times, 0..GRID.n_sites, all);
        samples
    };
    let noise = wavecascade::reference::WhiteNoise {
        grid: GRID,
        deviation: 1.0,
        seed: 5,
    }
    .field();
    let both = samples(BEAM)
        + samples(Beam {
            seed: 2,
            stiffness: 450.0,
            ..BEAM
        });
    let two = GRID.sample("two", |n, j| both[[n, j]]);
    let lossy = Beam { loss: 1.5, ..BEAM }.field();
    let lone = |flux: &Flux, reason| flux.bands.iter().all(|band| band.reason == Some(reason));
    let noise = found(&noise, |_| {});
    assert!(noise.bands.is_empty() || lone(&noise, NoFlux::NoWave));
    let [two, lossy] = [&two, &lossy].map(|field| found(field, |_| {}));
    println!("{:?}, {:?}", two.stated, lossy.stated);
    assert!(
        two.bands
            .iter()
            .any(|band| band.reason == Some(NoFlux::SeveralWaves))
    );
    assert!(two.stated < 0.3 && lossy.stated < 0.3);
}
