//! Writes `steepening.npy` and its sidecar: random waves that steepen as they travel towards +x.
//!
//! Run from the repository's root: `cargo run --release --example steepening_noise -- out`.
//! A simple wave `v(t, x) = g(t - x + x v)`, times at each site taken from the arrival of weak waves on, of random
//! `g` with frequencies 0.02 to 0.05 and standard deviation 1, up to nine tenths of the distance at which the steepest
//! flank would break. It solves `v_x = v v_t` exactly. Each site has noise of its own, of standard deviation 0.02.

use std::f64::consts::TAU;
use std::fs;
use std::io::{self, Write};
use std::path::Path;

const TIMES: usize = 16_384;
const SITES: usize = 40;
/// Frequencies of `g`, in multiples of `1 / TIMES`.
const BAND: std::ops::Range<usize> = 328..820;
const NOISE: f64 = 0.02;

/// SplitMix64.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    /// The sum of twelve uniform numbers: nearly normal, of variance 1.
    fn normal(&mut self) -> f64 {
        let uniform = |bits: u64| (bits >> 11) as f64 / (1_u64 << 53) as f64;
        (0..12).map(|_| uniform(self.bits()) - 0.5).sum()
    }
}

/// `g` and its derivative on even times, as cubic pieces.
struct Wave {
    value: Vec<f64>,
    slope: Vec<f64>,
}

impl Wave {
    fn new(random: &mut Random) -> Wave {
        let size = 1.0 / (BAND.len() as f64).sqrt();
        let lines: Vec<(usize, f64, f64)> = BAND
            .map(|m| (m, size * random.normal(), size * random.normal()))
            .collect();
        let mut wave = Wave {
            value: vec![0.0; TIMES],
            slope: vec![0.0; TIMES],
        };
        let turns: Vec<(f64, f64)> = (0..TIMES)
            .map(|n| (TAU * n as f64 / TIMES as f64).sin_cos())
            .collect();
        for n in 0..TIMES {
            for (m, a, b) in &lines {
                let (sin, cos) = turns[n * m % TIMES];
                wave.value[n] += a * cos + b * sin;
                wave.slope[n] += (b * cos - a * sin) * TAU * *m as f64 / TIMES as f64;
            }
        }
        wave
    }

    /// The value and the derivative at a time.
    fn at(&self, time: f64) -> (f64, f64) {
        let floor = time.floor();
        let (n, s) = (
            (floor as i64).rem_euclid(TIMES as i64) as usize,
            time - floor,
        );
        let next = (n + 1) % TIMES;
        let (a, b, da, db) = (
            self.value[n],
            self.value[next],
            self.slope[n],
            self.slope[next],
        );
        let (c, d) = (3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db);
        let value = a + s * (da + s * (c + s * d));
        (value, da + s * (2.0 * c + s * 3.0 * d))
    }

    /// `v = g(time + x v)`, by Newton's method.
    fn steepened(&self, time: f64, x: f64) -> f64 {
        let mut v = self.at(time).0;
        for _ in 0..50 {
            let (value, slope) = self.at(time + x * v);
            let step = (v - value) / (1.0 - x * slope);
            v -= step;
            if step.abs() < 1e-14 {
                break;
            }
        }
        v
    }
}

fn main() -> io::Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "out".into());
    let folder = Path::new(&folder);
    fs::create_dir_all(folder)?;
    let mut random = Random(1);
    let wave = Wave::new(&mut random);
    let steepest = wave.slope.iter().fold(0.0, |m: f64, s| m.max(*s));
    let step = 0.9 / steepest / (SITES - 1) as f64;
    let mut samples = vec![0.0; TIMES * SITES];
    for n in 0..TIMES {
        for j in 0..SITES {
            let v = wave.steepened(n as f64, step * j as f64);
            samples[n * SITES + j] = v + NOISE * random.normal();
        }
    }
    write_npy(&folder.join("steepening.npy"), &samples)?;
    let sidecar = format!(
        "layout = \"time-site\"\ndt = 1.0\ntime_unit = \"s\"\ndx = {step}\nspace_unit = \"m\"\nquantity = \
         \"velocity\"\nunit = \"m/s\"\n"
    );
    fs::write(folder.join("steepening.toml"), sidecar)
}

/// NumPy's format 1.0, little-endian f64: a header padded to 64 bytes, the samples.
fn write_npy(path: &Path, samples: &[f64]) -> io::Result<()> {
    let dict = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({TIMES}, {SITES}), }}");
    let padding = 63 - (10 + dict.len()) % 64;
    let header = format!("{dict}{:padding$}\n", "");
    let mut file = io::BufWriter::new(fs::File::create(path)?);
    file.write_all(b"\x93NUMPY\x01\x00")?;
    file.write_all(&(header.len() as u16).to_le_bytes())?;
    file.write_all(header.as_bytes())?;
    for sample in samples {
        file.write_all(&sample.to_le_bytes())?;
    }
    file.flush()
}
