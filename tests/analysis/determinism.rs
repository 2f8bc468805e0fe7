//! The same bits from any number of threads and any size of blocks.

use ndarray::Array2;
use test_support::changed;
use test_support::fields::{TEMPORAL, asking, segments};
use wavecascade::analyze::{Analysis, Request, plan};
use wavecascade::arrays::{Arrays, Precision};
use wavecascade::plot::{Format, Style};
use wavecascade::prepare::{Detrend, Gaps, Window};
use wavecascade::report::{Provenance, sheet_html};
use wavecascade::sheet::Describe;
use wavecascade::{Field, analyze};

fn field() -> Field {
    field_of((301, 53))
}

fn field_of(shape: (usize, usize)) -> Field {
    let values = Array2::from_shape_fn(shape, |(n, j)| {
        let (t, x) = (n as f64, j as f64);
        if (n, j) == (100, 20) || (n > 250 && j == 7) {
            f64::NAN
        } else {
            (0.31 * t - 0.7 * x).sin() * (-0.001 * (t - 3.0 * x).powi(2)).exp() + 1e-3 * x
        }
    });
    Field::from_array(values)
}

fn requests() -> Vec<Request> {
    let plain = asking(|it| it.gaps = Gaps::Interpolate);
    let welch = Request {
        gaps: Gaps::Mask,
        detrend_field_mean: true,
        detrend_space: Detrend::Linear,
        detrend_time: Detrend::Linear,
        window_time: Window::Hann,
        window_space: Window::Hann,
        welch: Some(segments(64, 32)),
        ..Request::default()
    };
    let single = changed(plain.clone(), |it| it.precision = Precision::F32);
    vec![plain, welch, single]
}

fn bits(spectra: &Arrays, analysis: &Analysis) -> Vec<u64> {
    let large = spectra.values().flatten().copied();
    let sheet = analysis.describe();
    let small = sheet.variables.iter().flat_map(|of| of.values.iter());
    let d = analysis.direction.map(|d| [d.toward_plus_x, d.undirected]);
    let p = analysis.parseval;
    let scalars = d
        .into_iter()
        .flatten()
        .chain(p.time)
        .chain(p.space)
        .chain(p.spacetime);
    large
        .chain(small.copied())
        .chain(scalars)
        .map(f64::to_bits)
        .collect()
}

/// Also where the field is read ahead, and the transforms between the halves of the space-time
/// spectrum go through a scratch file: in stripes of sites, the last of them narrower, and in
/// several pieces of frequencies.
#[test]
fn one_block_and_many_agree_bit_for_bit() -> Result<(), wavecascade::Error> {
    let (n_times, n_sites) = (1201, 701);
    let field = field_of((n_times, n_sites));
    for request in requests() {
        let run = |memory| -> Result<(Vec<u64>, wavecascade::analyze::Plan), wavecascade::Error> {
            let request = Request {
                memory: Some(memory),
                threads: Some(2),
                ..request.clone()
            };
            let made = plan(&field, &request)?;
            let (a, s) = analyze(&field, &request)?;
            Ok((bits(&s, &a), made))
        };
        let (whole, made) = run(4 << 30)?;
        assert_eq!(made.blocks().sites, n_sites);
        assert!(!made.streams() && made.scratch_file == 0);
        let (blocks, made) = in_least_memory(run)?;
        assert!(made.blocks().sites < n_sites / 2 && made.blocks().times < n_times / 2);
        assert!(made.streams() && made.scratch_file > 0);
        assert!(whole == blocks);
        // What is half as large needs no scratch file in as much memory.
        if request.precision == Precision::F32 {
            continue;
        }
        // Several blocks of frequencies are read from the scratch file together.
        let least = made.memory_allowed;
        let more = (1..1280).map(|i| least + (i << 14)).find(|&memory| {
            let request = Request {
                memory: Some(memory),
                threads: Some(2),
                ..request.clone()
            };
            let blocks = plan(&field, &request).unwrap().blocks();
            blocks.frequencies < blocks.scratch && blocks.sites < n_sites
        });
        let (blocks, made) = run(more.unwrap())?;
        assert!(made.streams() && made.blocks().sites < n_sites);
        assert!(made.blocks().scratch < bins(&request, n_times));
        assert!(whole == blocks);
    }
    Ok(())
}

fn bins(request: &Request, n_times: usize) -> usize {
    request.welch.as_ref().map_or(n_times, |w| w.segment) / 2 + 1
}

/// In the smallest memory that is accepted.
fn in_least_memory<R>(
    run: impl Fn(u64) -> Result<R, wavecascade::Error>,
) -> Result<R, wavecascade::Error> {
    let mut allowed = 1;
    loop {
        match run(allowed) {
            Err(wavecascade::Error::Memory { needed, .. }) => {
                assert!(needed > allowed, "what is said to be needed is enough");
                allowed = needed;
            }
            done => return done,
        }
    }
}

/// Several short records are read ahead at once, and a long one in parts.
#[test]
fn the_order_of_samples_that_are_read_ahead_does_not_matter() -> Result<(), wavecascade::Error> {
    for (n_times, n_sites) in [(301, 53), (300_000, 2)] {
        let value = |(n, j): (usize, usize)| (0.01 * (n * (j + 1)) as f64).sin();
        let by_time = Array2::from_shape_fn((n_times, n_sites), value);
        let by_site = Array2::from_shape_fn((n_sites, n_times), |(j, n)| value((n, j)));
        let request = |memory| Request {
            results: TEMPORAL,
            memory: Some(memory),
            threads: Some(16),
            ..Request::default()
        };
        let found = [by_time, by_site.reversed_axes()].map(|values| {
            let field = Field::from_array(values);
            let run = |memory| analyze(&field, &request(memory)).map(|(a, s)| bits(&s, &a));
            Ok([run(4 << 30)?, in_least_memory(run)?])
        });
        let [by_time, by_site]: [Result<[Vec<u64>; 2], wavecascade::Error>; 2] = found;
        let [[by_time, first], [by_site, second]] = [by_time?, by_site?];
        assert!(by_time == first && by_time == by_site && by_time == second);
    }
    Ok(())
}

/// Maps are for the eye: without them the same numbers, a report and the figures of what is left.
#[test]
fn without_maps_all_else_is_the_same_bit_for_bit() -> Result<(), wavecascade::Error> {
    for request in requests() {
        let run = |maps| {
            let request = changed(request.clone(), |it| it.maps = maps);
            analyze(&field(), &request)
        };
        let (with, of_with) = run(true)?;
        let (without, of_without) = run(false)?;
        assert_eq!(bits(&of_with, &with), bits(&of_without, &without));
        assert_eq!([with.maps.len(), without.maps.len()], [5, 0]);
        let pages = [&with, &without].map(|analysis| {
            let provenance = Provenance::new(Vec::new(), None, None);
            let (sheet, style) = (analysis.words(), Style::default());
            sheet_html(analysis, &sheet, &analysis.name, &provenance, &style).unwrap()
        });
        assert!(pages[1].contains("</html>") && pages[1].len() < pages[0].len());
        let folder = tempfile::tempdir().unwrap();
        let drawn = |analysis| {
            let figures = test_support::figures::drawn(analysis, &Style::default());
            wavecascade::plot::save_all(&figures, folder.path(), &[Format::Svg])
                .map(|files| files.len())
        };
        let (all, rest) = (drawn(&with).unwrap(), drawn(&without).unwrap());
        assert!(0 < rest && rest < all, "{rest} of {all} figures");
    }
    Ok(())
}
