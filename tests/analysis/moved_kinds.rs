//! What moved: kinds of fields of which something else was said than is so, each known by construction.

use ndarray::Array2;
use wavecascade::Field;
use wavecascade::analyze::{Analysis, Request, Results};
use wavecascade::moved::{Reason, Verdict};
use wavecascade::reference::GrowingHarmonic;

use test_support::changed;
use test_support::fields::{analyzed, noise};

pub fn request() -> Request {
    Request {
        results: Results {
            flux_surrogate: false,
            short_time: false,
            ..Results::ALL
        },
        maps: false,
        ..Request::default()
    }
}

pub fn analysis_of(values: Array2<f64>) -> Analysis {
    analyzed(&Field::from_array(values), &request())
}

/// Noise at twelve sites that follow each other in nothing, white and of slow frequencies: at most one of 40 fields moves, and none has
/// a direction.
#[test]
fn val_noise_moves_nothing() {
    let white = noise(1500, 40 * 12);
    let mut moves = [0, 0];
    for k in 0..40 {
        let mut values = Array2::from_shape_fn((1500, 12), |(n, j)| white[[n, 12 * k + j]]);
        for slow in moves.iter_mut() {
            let analysis = analysis_of(values.clone());
            let moved = &analysis.answer.as_ref().unwrap().frequency;
            *slow += usize::from(moved.moves());
            let is_noise = matches!(analysis.undirected, Some(Reason::Noise { .. }));
            assert!(is_noise || k >= 5, "{k}: {:?}", analysis.undirected);
            for n in 1..1500 {
                for j in 0..12 {
                    values[[n, j]] += 0.8 * values[[n - 1, j]];
                }
            }
        }
    }
    assert!(moves[0] <= 1 && moves[1] <= 3, "{moves:?}");
}

/// A second harmonic that grows is a move up in both, where the sites tell its wavenumber; where they do not, it
/// folds to a longer wave, and in time nothing is told.
#[test]
fn val_armstrong_a_growing_harmonic_moves_up_unless_it_folds() {
    for (dx, n_sites, folds) in [(0.008, 96, false), (0.02, 48, true)] {
        let example = GrowingHarmonic::EXAMPLE;
        let grid = changed(example.grid, |it| (it.dx, it.n_sites) = (dx, n_sites));
        let field = GrowingHarmonic { grid, ..example }.field();
        let found = analyzed(&field, &request()).answer.unwrap();
        assert_eq!(found.frequency.verdict, Verdict::Up);
        // 0.02 m: the harmonic's 251 rad/m appear as 63, below the fundamental's 126.
        let moved = &found.wavenumber;
        assert_eq!(moved.verdict == Verdict::Up, !folds, "{moved:?}");
        let reason = folds.then_some(Reason::Aperture { folds });
        assert_eq!(moved.reason, reason, "{moved:?}");
    }
}
