//! Scenes that say too little, too much, or what cannot be: each fault names file, line and key.

use std::fs;
use std::process::Output;

use assert_cmd::Command;

/// A good scene of two lines.
const GOOD: &str = "sites = 8\nend_time = 4.0\n";
/// A good one in SI, of six lines.
const SI: &str = "sites = 8\nmaterial = 'quartz'\nradius = '9 mm'\nlength = '18 mm'\nangle = 30\n\
                  striker_velocity = 0.88\n";

/// Base, lines after it, line at fault (0: none, the key is missing), key, words of the message.
const FAULTS: &[(&str, &str, usize, &str, &str)] = &[
    // Missing.
    ("", "end_time = 1.0", 0, "sites", "found nothing"),
    (GOOD, "law = 'power'", 0, "exponent", "found nothing"),
    (
        GOOD,
        "scheme = 'velocity-verlet'",
        0,
        "step",
        "found nothing",
    ),
    (GOOD, "mode = 2", 0, "mode_amplitude", "found nothing"),
    (
        GOOD,
        "drive = 'force'",
        0,
        "drive_amplitude",
        "found nothing",
    ),
    (
        GOOD,
        "drive = 'force'\ndrive_amplitude = 1.0",
        0,
        "drive_frequency",
        "found nothing",
    ),
    (GOOD, "units = 'si'", 0, "coefficient_cell", "SI"),
    (GOOD, "material = 'steel'", 0, "radius", "found nothing"),
    (
        GOOD,
        "material = 'steel'\nradius = 1",
        0,
        "angle",
        "found nothing",
    ),
    (
        GOOD,
        "material = 'steel'\nradius = 1\nangle = 9",
        0,
        "length",
        "found nothing",
    ),
    (
        GOOD,
        "material = 'steel'\nshape = 'sphere'\nradius = 1",
        0,
        "striker_velocity",
        "speed",
    ),
    (GOOD, "young = 1e9\nradius = 1", 0, "poisson", "material"),
    (SI, "wall_material = 'steel'", 0, "wall_radius", "cylinder"),
    (
        "sites = 8\nends = 'periodic'",
        "",
        0,
        "end_time",
        "no front",
    ),
    // Unknown.
    (
        GOOD,
        "stifness_ratio = 2.0",
        3,
        "stifness_ratio",
        "`stiffness_ratio`?",
    ),
    (GOOD, "nonsense = 2.0", 3, "nonsense", "a key of scenes"),
    (GOOD, "friction = 0.1", 3, "friction", "not modelled"),
    (GOOD, "thermostat = 0.1", 3, "thermostat", "`mode_energy`"),
    (
        GOOD,
        "law = 'tanh(d)'\ngravity = 0.2",
        4,
        "gravity",
        "contact 5",
    ),
    (GOOD, "ground_cell = [0, 0]", 3, "ground_cell", "above 0"),
    (
        GOOD,
        "ends = 'periodic'\nmass_cell = [1, 2, 3]",
        4,
        "mass_cell",
        "the 8 sites",
    ),
    (GOOD, "ends = 'wal'", 3, "ends", "`periodic`"),
    (GOOD, "scheme = 'euler'", 3, "scheme", "`nystrom`"),
    (
        GOOD,
        "record = [\n'force',\n'momentum']",
        5,
        "record",
        "`energy_passed`",
    ),
    (GOOD, "material = 'unobtainium'", 3, "material", "`quartz`"),
    (
        SI,
        "striker_radius = 0.01\nstriker_material = 'glass'",
        8,
        "striker_material",
        "quartz",
    ),
    (
        GOOD,
        "[[defect]]\nsite = 1\nfaktor = 2.0",
        5,
        "defect",
        "`factor`",
    ),
    (GOOD, "\"a.b\" = 1", 3, "a.b", "a key of scenes"),
    (
        GOOD,
        "mass_taper = 1e300\nmasses = [1, 1, 1, 1, 1, 1, 1, 1e200]",
        3,
        "mass_taper",
        "finite",
    ),
    // Words that are nearly right, and those of other programs.
    (GOOD, "law = 'hertzz'", 3, "law", "(`hertz`?), or a formula"),
    (GOOD, "law = 'two-sided herz'", 3, "law", "`toda`"),
    (GOOD, "law = 'sprng alpha=1'", 3, "law", "(`spring`?)"),
    (GOOD, "law = 'k * d'", 3, "law", "a constant"),
    (
        GOOD,
        "laws = ['hertz', 'todda 1']",
        3,
        "laws[1]",
        "(`toda`?)",
    ),
    (
        GOOD,
        "law = 'toda 1'\nground_cell = 1\nground_law = 'linaer'",
        5,
        "ground_law",
        "`polynomial`",
    ),
    (
        GOOD,
        "[[defect]]\ncontact = 1\nlaw = 'herz'",
        5,
        "defect[0].law",
        "(`hertz`?)",
    ),
    (GOOD, "ends = 'perodic'", 3, "ends", "(`periodic`?)"),
    (GOOD, "units = 'SI'", 3, "units", "(`si`?)"),
    (GOOD, "record = ['forse']", 3, "record[0]", "(`force`?)"),
    (GOOD, "material = 'stell'", 3, "material", "(`steel`?)"),
    (
        GOOD,
        "[[defect]]\nsitee = 1",
        4,
        "defect[0].sitee",
        "(`site`?)",
    ),
    (GOOD, "dt = 0.1", 3, "dt", "`step`"),
    (GOOD, "Temperature = 0.1", 3, "Temperature", "not modelled"),
    // Cells that do not fit.
    (
        GOOD,
        "ground_cell = [1, 2, 3, 4, 5, 6, 7, 8, 9]",
        3,
        "ground_cell",
        "at most 8 values",
    ),
    (
        GOOD,
        "laws = ['d', 'd', 'd', 'd', 'd', 'd', 'd', 'd', 'd']",
        3,
        "laws",
        "one a contact",
    ),
    (
        GOOD,
        "ends = 'periodic'\nlaws = ['hertz', 'hertz', 'd']",
        4,
        "laws",
        "the 8 sites",
    ),
    (
        "sites = 7\nends = 'periodic'\nend_time = 1\n",
        "mass_ratio = 2",
        4,
        "mass_ratio",
        "the 7 sites",
    ),
    (
        "sites = 7\nends = 'periodic'\nend_time = 1\n",
        "stiffness_ratio = 2",
        4,
        "stiffness_ratio",
        "the 7 sites",
    ),
    // Of another type.
    ("sites = 8.5", "", 1, "sites", "a whole number"),
    ("sites = -3", "", 1, "sites", "a whole number"),
    ("sites = 'many'", "", 1, "sites", "found the text \"many\""),
    (
        GOOD,
        "stiffness_ratio = [1.0]",
        3,
        "stiffness_ratio",
        "a number",
    ),
    (GOOD, "masses = 3", 3, "masses", "a list"),
    (
        GOOD,
        "estimate_error = 'yes'",
        3,
        "estimate_error",
        "true or false",
    ),
    ("sites = 8\nend_time = 'soon'", "", 2, "end_time", "`auto`"),
    (SI, "striker_radius = '9 parsec'", 7, "striker_radius", "mm"),
    (
        SI,
        "striker_radius = '9 GPa'",
        7,
        "striker_radius",
        "a length",
    ),
    (GOOD, "defect = 3", 3, "defect", "a list"),
    // No TOML.
    (GOOD, "law = ", 3, "", ""),
    (GOOD, "sites = 9", 3, "", "duplicate"),
    (GOOD, "\n\nsamples = 1e", 5, "", ""),
    // Contradictory.
    (
        GOOD,
        "stiffness_ratio = 2\ncoefficient_cell = [1, 2]",
        4,
        "coefficient_cell",
        "(line 3)",
    ),
    (
        GOOD,
        "coefficient_cell = [1]\ncoefficients = [1]",
        4,
        "coefficients",
        "(line 3)",
    ),
    (SI, "angle_cell = [8, 90]", 7, "angle_cell", "(line 5)"),
    (SI, "stiffness_ratio = 3.0", 5, "angle", "(line 7)"),
    (
        GOOD,
        "mass_ratio = 2\nmass_cell = [1]",
        4,
        "mass_cell",
        "(line 3)",
    ),
    (
        SI,
        "masses = [1, 1, 1, 1, 1, 1, 1, 1]",
        4,
        "length",
        "(line 7)",
    ),
    (
        GOOD,
        "scheme = 'symplectic-4'\ntolerance = 1e-6",
        4,
        "tolerance",
        "`step`",
    ),
    (GOOD, "tolerance = 1e-6\nstep = 0.1", 4, "step", "(line 3)"),
    (
        GOOD,
        "step = 0.1\nestimate_error = true",
        4,
        "estimate_error",
        "`step`",
    ),
    (
        GOOD,
        "scheme = 'symplectic-6'\nstep = 0.1\ndrag = 0.1",
        3,
        "scheme",
        "`drag` (line 5)",
    ),
    (
        GOOD,
        "scheme = 'nystrom'\ndashpot = 0.1",
        3,
        "scheme",
        "runge-kutta",
    ),
    (GOOD, "angle = 30", 3, "angle", "`material`"),
    (
        GOOD,
        "first_contact = 'stiff'",
        3,
        "first_contact",
        "`stiffness_ratio`",
    ),
    (GOOD, "exponent = 2.0", 3, "exponent", "power"),
    (GOOD, "seed = 4", 3, "seed", "spread"),
    (
        GOOD,
        "law = 'polynomial 1 0 -0.3'\nprecompression = 0.8",
        4,
        "precompression",
        "can carry",
    ),
    (SI, "law = 'power'\nexponent = 2.0", 7, "law", "Hertz"),
    (SI, "units = 'none'", 7, "units", "material"),
    (
        GOOD,
        "striker_velocity = '1 m/s'",
        3,
        "striker_velocity",
        "not in SI",
    ),
    (
        "sites = 3\nend_time = '1 ms'",
        "",
        2,
        "end_time",
        "not in SI",
    ),
    (
        GOOD,
        "drive = 'wall'\ndrive_amplitude = 1\ndrive_frequency = 1",
        3,
        "drive",
        "fixed",
    ),
    (
        GOOD,
        "ends = 'fixed'\ndrive = 'wall'\ndrive_site = 2",
        5,
        "drive_site",
        "`displacement`",
    ),
    (
        GOOD,
        "drive = 'displacement'\ndrive_site = 2\ndrive_waveform = 'half-sine'\ndrive_amplitude = 1\ndrive_duration = 1",
        3,
        "drive",
        "does not jump",
    ),
    (
        GOOD,
        "striker_velocity = 2.0\ndrive = 'velocity'\ndrive_amplitude = 1\ndrive_frequency = 1",
        4,
        "drive",
        "no other velocity at time 0",
    ),
    (
        GOOD,
        "drive_amplitude = 1.0",
        3,
        "drive_amplitude",
        "`drive`",
    ),
    (
        GOOD,
        "ends = 'free'\nwall_coefficient = 2.0",
        4,
        "wall_coefficient",
        "wall",
    ),
    (
        GOOD,
        "left_wall_coefficient = 2.0",
        3,
        "left_wall_coefficient",
        "fixed",
    ),
    (
        GOOD,
        "ends = 'periodic'\nstriker_coefficient = 2",
        4,
        "striker_coefficient",
        "periodic",
    ),
    (
        GOOD,
        "striker_velocity = 1\nvelocities = [1, 1]",
        4,
        "velocities",
        "(line 3)",
    ),
    (
        GOOD,
        "[[defect]]\nsite = 1\ncontact = 1\nfactor = 2.0",
        3,
        "defect[0]",
        "both",
    ),
    (
        GOOD,
        "[[defect]]\nsite = 1\nfactor = 2\n[[defect]]\nsite = 1",
        6,
        "defect[1]",
        "neither",
    ),
    (
        "sites = 4\nvelocities = [0, 0, 0, 1]\nend_time = 'auto'",
        "",
        3,
        "end_time",
        "no front",
    ),
    (SI, "shape = 'sphere'", 4, "length", "cylinder"),
    // Not physical.
    ("sites = 0", "", 1, "sites", "1 or more"),
    ("sites = 2\nends = 'periodic'", "", 1, "sites", "3 or more"),
    (
        GOOD,
        "stiffness_ratio = 0.5",
        3,
        "stiffness_ratio",
        "1 or more",
    ),
    (
        GOOD,
        "stiffness_ratio = inf",
        3,
        "stiffness_ratio",
        "finite",
    ),
    (
        GOOD,
        "law = 'power'\nexponent = 0.9",
        4,
        "exponent",
        "1 or more",
    ),
    (
        GOOD,
        "law = 'power'\nexponent = 1e9\ntolerance = 1e-8",
        3,
        "law",
        "rounding",
    ),
    (
        GOOD,
        "mass_cell = [\n1.0,\n-2.0]",
        5,
        "mass_cell[1]",
        "above 0",
    ),
    (GOOD, "masses = [1, 2]", 3, "masses", "8 values"),
    (
        GOOD,
        "coefficients = [0, 1, 1, 1, 1, 1, 1, 1]",
        3,
        "coefficients[0]",
        "above 0",
    ),
    (GOOD, "mass_spread = 1.0", 3, "mass_spread", "below 1"),
    (
        GOOD,
        "precompression = -1",
        3,
        "precompression",
        "0 or more",
    ),
    (GOOD, "tolerance = 2.0", 3, "tolerance", "below 1"),
    (GOOD, "samples = 1", 3, "samples", "2 or more"),
    (
        GOOD,
        "striker_velocity = 0",
        3,
        "striker_velocity",
        "at rest",
    ),
    (GOOD, "velocities = [1, 2, 3]", 3, "velocities", "8 values"),
    (
        GOOD,
        "displacements = [1, 2, 3, 4, 5, 6, 7, nan]",
        3,
        "displacements[7]",
        "finite",
    ),
    (GOOD, "mode = 9\nmode_amplitude = 1", 3, "mode", "1 to 8"),
    (
        GOOD,
        "drive = 'force'\ndrive_amplitude = 0",
        4,
        "drive_amplitude",
        "other than 0",
    ),
    (
        GOOD,
        "[[defect]]\nsite = 8\nfactor = 2",
        4,
        "defect[0].site",
        "from 0 to 7",
    ),
    (
        GOOD,
        "[[defect]]\nsite = 7\nfactor = 0",
        5,
        "defect[0].factor",
        "above 0",
    ),
    (SI, "second_angle = 0", 7, "second_angle", "above 0"),
    (SI, "poisson = 0.9", 7, "poisson", "0.5"),
    (SI, "young = '-1 GPa'", 7, "young", "above 0"),
    // Found only by running.
    (
        GOOD,
        "samples = 2\nlaw = 'spring'\nscheme = 'velocity-verlet'\nstep = 4",
        6,
        "step",
        "stability",
    ),
    // Too large.
    ("sites = 1000000000000", "", 1, "sites", "of memory"),
    (
        GOOD,
        "samples = 1000000000000000",
        3,
        "samples",
        "of memory",
    ),
    (
        "sites = 9223372036854775807\nsamples = 9223372036854775807",
        "",
        1,
        "sites",
        "of memory",
    ),
    (
        GOOD,
        "samples = 100000\nmemory = '1 MB'",
        3,
        "samples",
        "of memory",
    ),
];

fn simulate(place: &std::path::Path, words: &[&str]) -> Output {
    let mut command = Command::cargo_bin("cascade").unwrap();
    command.current_dir(place).arg("simulate").args(words);
    command.output().unwrap()
}

#[test]
fn every_fault_is_named_with_file_line_and_key() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("scene.toml");
    let mut wrong = Vec::new();
    for (base, more, line, key, words) in FAULTS {
        let text = format!("{base}{more}\n");
        fs::write(&path, &text).unwrap();
        let output = simulate(place.path(), &["scene.toml", "--out", "run.npz"]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let line = match line {
            0 => String::new(),
            line => format!("{line}:"),
        };
        let start = format!("error: scene.toml:{line} {key}");
        // What follows the key ends it, or names a part of it.
        let rest = said.strip_prefix(&start);
        let named = rest.is_some_and(|rest| key.is_empty() || rest.starts_with([':', '[', '.']));
        let good = output.status.code() == Some(2) && named && said.contains(words);
        if !good || said.contains("panicked") {
            wrong.push(format!("{text}expected {start} ... {words}\nsaid {said}"));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} of {}:\n{}",
        wrong.len(),
        FAULTS.len(),
        wrong.join("\n")
    );
    let names: Vec<_> = fs::read_dir(place.path()).unwrap().collect();
    assert_eq!(names.len(), 1, "only the scene is there");
}

#[test]
fn a_fault_of_an_option_is_named_by_the_option() {
    let place = tempfile::tempdir().unwrap();
    fs::write(
        place.path().join("scene.toml"),
        "sites = 8\nstiffness_ratio = 2.0\n",
    )
    .unwrap();
    for (words, expected) in [
        (
            &["--stiffness-ratio", "0.5"][..],
            "--stiffness-ratio: expected a finite number of 1 or more",
        ),
        (&["--sites", "x"], "--sites: expected a whole number"),
        (
            &["--coefficient-cell", "1,2"],
            "--coefficient-cell: expected one key",
        ),
        (
            &["--defect", "site=7"],
            "--defect: expected a factor or a value",
        ),
        (&["--defect", "site"], "--defect: expected a table"),
        (&["--record", "force,heat"], "--record: expected"),
        (
            &[
                "--scheme",
                "symplectic-4",
                "--step",
                "0.1",
                "--tolerance",
                "1e-3",
            ],
            "--step: ",
        ),
    ] {
        let mut all = vec!["scene.toml", "--end-time", "3"];
        all.extend(words);
        let output = simulate(place.path(), &all);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{words:?}: {said}");
        assert!(
            said.starts_with(&format!("error: {expected}")),
            "{words:?}: {said}"
        );
    }
    // Without a file, what is missing is an option.
    let said = String::from_utf8(simulate(place.path(), &[]).stderr).unwrap();
    assert!(
        said.starts_with("error: --sites: expected the number of sites"),
        "{said}"
    );
}

#[test]
fn files_that_are_no_scenes_are_refused() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(place.path().join(name), bytes).unwrap();
    write("binary.toml", &[0xff, 0xfe, 0, 1]);
    write("empty.toml", b"");
    write(
        "deep.toml",
        format!("a = {}", "[".repeat(100_000)).as_bytes(),
    );
    write(
        "dots.toml",
        format!("{}b = 1", "a.".repeat(100_000)).as_bytes(),
    );
    write("long.toml", "# comment\n".repeat(1_000_000).as_bytes());
    fs::create_dir(place.path().join("folder.toml")).unwrap();
    for (name, code) in [
        ("binary.toml", 2),
        ("empty.toml", 2),
        ("deep.toml", 2),
        ("dots.toml", 2),
        ("long.toml", 2),
        ("folder.toml", 1),
        ("absent.toml", 1),
    ] {
        let output = simulate(place.path(), &[name]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{name}: {said}");
        assert!(said.starts_with("error: "), "{name}: {said}");
        assert!(said.contains(name) && said.len() < 1000, "{name}: {said}");
    }
}
