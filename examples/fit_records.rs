//! Measured records and the chain that explains them: four keys of a scene are fitted, each with its interval.

use std::path::Path;

use wavecascade::Field;
use wavecascade::chain::scene::SceneSource;
use wavecascade::field::OpenOptions;
use wavecascade::fit::FitRequest;
use wavecascade::observer::Silent;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data");
    let records = Field::open(data.join("impact_records.csv"), &OpenOptions::default())?;
    let scene = SceneSource::read(&data.join("impact_scene.toml"))?;
    let keys = [
        "young=60GPa..85GPa",
        "striker_velocity",
        "tangent=0..5us",
        "angle",
    ];
    let request = FitRequest {
        free: keys.map(str::to_owned).to_vec(),
        ..FitRequest::default()
    };

    let fitted = request.run(&records, &scene, &Silent)?;

    for value in &fitted.values {
        let unit = &value.unit;
        println!(
            "{} = {:.4} {unit}, {:.4} to {:.4}",
            value.name, value.value, value.low, value.high
        );
    }
    Ok(())
}
