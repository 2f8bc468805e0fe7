//! What cannot be fitted is refused, and says why.

use wavecascade::chain::scene::SceneSource;
use wavecascade::observer::Silent;

use super::made::Measurement;

const SCENE: &str = "sites = 6\nstiffness_ratio = 2.0";

fn refused(
    change: impl FnOnce(&mut Measurement, &mut wavecascade::fit::FitRequest, &mut wavecascade::Field),
) -> String {
    let mut made = Measurement::of(&[1, 4], 100, 8.0);
    let mut field = made.measured(SCENE);
    let mut request = made.request(&["stiffness_ratio"]);
    change(&mut made, &mut request, &mut field);
    let error = request
        .run(&field, &SceneSource::new(None, SCENE), &Silent)
        .unwrap_err();
    assert!(error.is_usage(), "{error}");
    error.to_string()
}

#[test]
fn what_is_wrong_is_named() {
    let said = refused(|_, request, _| request.free = vec!["sites".into()]);
    assert!(said.contains("sweep"), "{said}");
    let said = refused(|_, request, _| request.free.clear());
    assert!(said.contains("a key to fit"), "{said}");
    let said = refused(|_, request, _| request.bodies = Some(vec![1, 9]));
    assert!(
        said.contains("a body of the chain, 0 to 5") && said.contains('9'),
        "{said}"
    );
    let said = refused(|_, request, _| request.bodies = Some(vec![1]));
    assert!(said.contains("one for each site"), "{said}");
    let said = refused(|_, _, field| field.time.origin = -100.0);
    assert!(said.contains("after time 0"), "{said}");
    let said = refused(|_, request, field| {
        request.bodies = None;
        field.space.step = 0.3;
    });
    assert!(said.contains("--bodies"), "{said}");
    let said = refused(|_, request, _| request.instruments.gain_error = Some(0.0));
    assert!(said.contains("a share above 0"), "{said}");
    for size in [0.0, 1e155, 1e200] {
        let said = refused(|_, _, field| {
            *field = wavecascade::Field::from_array(ndarray::Array2::from_elem((100, 2), size))
        });
        assert!(said.contains("of which the largest is"), "{size}: {said}");
    }
    let said = refused(|_, _, field| *field = field_of(3));
    assert!(said.contains("samples or more"), "{said}");
}

fn field_of(samples: usize) -> wavecascade::Field {
    Measurement::of(&[1, 4], samples, 8.0).measured(SCENE)
}
