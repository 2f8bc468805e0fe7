//! Figures at the sizes they are printed at: letters that can be read, nothing outside, nothing over
//! another, files as large as they say.

use test_support::changed;
use wavecascade::attenuation::{
    AttenuationRequest, Curves, Followed, Measured, Named, TransmissionRequest,
};
use wavecascade::budget::{Budget, BudgetRequest, ComparedBudgets, Motion, budget};
use wavecascade::chain::scene::SceneSource;
use wavecascade::chain::{Chain, Simulation};
use wavecascade::localized::{Family, Profile};
use wavecascade::observer::Silent;
use wavecascade::plot::{Colormap, Depth, Figure, Format, Style, figures_of, sans};
use wavecascade::sheet::Describe;

const POINT: f64 = 25.4 / 72.0;

fn small_budget(ratio: f64) -> Budget {
    let simulation = Simulation::impact(Chain::dimer(60, ratio), 1.0, 40.0, 257);
    let run = simulation.run(&Silent).unwrap();
    let motion = Motion::of(&run).unwrap();
    budget(&motion, &BudgetRequest::default()).unwrap().0
}

fn named(ratio: f64) -> Named {
    Named {
        name: format!("stiffness ratio {ratio}"),
        scene: SceneSource::new(None, format!("sites = 9\nstiffness_ratio = {ratio:?}")),
    }
}

fn drawn(found: &dyn Describe, style: &Style) -> Vec<Figure> {
    let sheet = found.describe();
    figures_of(found, &sheet, "chains", sheet.name, style)
}

/// What the figures of all commands are drawn from.
struct Results {
    budgets: [Budget; 2],
    attenuation: Followed,
    transmission: Followed,
    wave: Profile,
    journey: wavecascade::localized::Journey,
}

impl Results {
    fn compute() -> Results {
        let request = AttenuationRequest {
            chains: vec![named(2.5), named(4.9)],
            length: 8,
            ..AttenuationRequest::default()
        };
        let scene = SceneSource::new(None, "sites = 6");
        let over = "stiffness_ratio=1:20:6log".to_owned();
        let wave = Family::default().search(3).unwrap().wave(3).unwrap();
        Results {
            budgets: [small_budget(4.9272), small_budget(2.398)],
            attenuation: Followed::new(
                Curves::Length(request.run(None, &Silent).unwrap()),
                Measured::default(),
            ),
            transmission: Followed::new(
                Curves::Key(
                    TransmissionRequest::new(scene, over)
                        .run(None, &Silent)
                        .unwrap(),
                ),
                Measured::default(),
            ),
            journey: wave.journey(20, &Silent).unwrap(),
            wave: Profile::of(wave, 200),
        }
    }

    fn figures(&self, style: &Style) -> Vec<Figure> {
        let analysis = test_support::figures::full();
        let mut figures = test_support::figures::drawn(&analysis, style);
        assert_eq!(figures.len(), 9);
        let [first, second] = &self.budgets;
        let compared = ComparedBudgets {
            both: [
                ("localized".into(), first.clone()),
                ("dispersive".into(), second.clone()),
            ],
            summaries: [first, second].map(|budget| budget.describe(None).numbers.into()),
        };
        let others: [&dyn Describe; 6] = [
            first,
            &compared,
            &self.attenuation,
            &self.transmission,
            &self.wave,
            &self.journey,
        ];
        figures.extend(others.iter().flat_map(|found| drawn(*found, style)));
        figures
    }
}

/// A text of an SVG file with its box: left, top, right, bottom.
#[derive(Debug)]
struct Placed {
    text: String,
    size: f64,
    place: [f64; 4],
}

fn svg(figure: &Figure) -> String {
    String::from_utf8(figure.encode(Format::Svg).unwrap()).unwrap()
}

fn attribute<'a>(line: &'a str, name: &str) -> &'a str {
    let rest = line.split(&format!("{name}=\"")).nth(1);
    rest.and_then(|rest| rest.split('"').next())
        .unwrap_or_else(|| panic!("no {name} in {line}"))
}

fn number(text: &str) -> f64 {
    text.parse().unwrap_or_else(|_| panic!("{text}"))
}

fn unescaped(text: &str) -> String {
    let pairs = [
        ("&lt;", "<"),
        ("&gt;", ">"),
        ("&quot;", "\""),
        ("&amp;", "&"),
    ];
    pairs
        .iter()
        .fold(text.to_owned(), |text, (from, to)| text.replace(from, to))
}

/// Height of the letters over the em, by which `plotters` measures, times the units of a pixel, over its size of an em.
const MEASURED: f64 = 1.24 / 1.164 * 10.0;

fn texts(svg: &str) -> Vec<Placed> {
    let lines = svg.lines().filter(|line| line.starts_with("<text"));
    lines
        .map(|line| {
            let text = unescaped(
                line.split('>')
                    .nth(1)
                    .unwrap()
                    .split("</text")
                    .next()
                    .unwrap(),
            );
            let size = number(attribute(line, "font-size"));
            let width = f64::from(sans(size).box_size(&text).unwrap().0) / MEASURED;
            let before = match attribute(line, "text-anchor") {
                "start" => 0.0,
                "middle" => width / 2.0,
                _ => width,
            };
            let transform = attribute(line, "transform");
            let place = transform.split(['(', ')', ' ']).collect::<Vec<_>>();
            let (x, y) = (number(place[1]), number(place[2]));
            let half = 0.4 * size;
            Placed {
                place: match transform.contains("rotate(-90)") {
                    true => [x - half, y + before - width, x + half, y + before],
                    false => [x - before, y - half, x - before + width, y + half],
                },
                text,
                size,
            }
        })
        .collect()
}

fn overlap(a: &[f64; 4], b: &[f64; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Frames of panels: closed outlines that are not tiny.
fn frames(svg: &str) -> Vec<[f64; 4]> {
    let outlines = svg
        .lines()
        .filter(|line| line.starts_with("<polyline") && line.contains("fill=\"none\""));
    outlines
        .filter_map(|line| {
            let points: Vec<f64> = attribute(line, "points")
                .split([' ', ','])
                .map(number)
                .collect();
            let is_closed = points.len() == 10 && points[..2] == points[8..];
            let place = [points[0], points[1], *points.get(4)?, *points.get(5)?];
            (is_closed && place[2] - place[0] > 60.0 && place[3] - place[1] > 60.0).then_some(place)
        })
        .collect()
}

#[test]
fn letters_are_legible_and_apart_at_every_size() {
    let results = Results::compute();
    let mut faults = Vec::new();
    let sized = changed(Style::paper(), |it| it.height = Some(60.0));
    for style in [Style::paper(), sized, Style::paper_wide(), Style::screen()] {
        for figure in results.figures(&style) {
            let svg = svg(&figure);
            let name = format!("{} at {} mm", figure.name(), style.width);
            let header = svg.lines().next().unwrap();
            let page: Vec<f64> = attribute(header, "viewBox")
                .split(' ')
                .map(number)
                .collect();
            let unit = style.width / page[2];
            let frames = frames(&svg);
            assert!(!frames.is_empty(), "{name} has no frame");
            let texts = texts(&svg);
            for (index, one) in texts.iter().enumerate() {
                let [left, top, right, bottom] = one.place;
                let points = one.size * unit / POINT;
                if points < 6.999 {
                    faults.push(format!("{name}: {:?} has {points:.2} pt", one.text));
                }
                if left < 0.0 || top < 0.0 || right > page[2] || bottom > page[3] {
                    faults.push(format!(
                        "{name}: {:?} is outside: {:?}",
                        one.text, one.place
                    ));
                }
                let over = texts[index + 1..].iter();
                for other in over.filter(|other| overlap(&one.place, &other.place)) {
                    faults.push(format!("{name}: {:?} is over {:?}", one.text, other.text));
                }
                let on_data = frames.iter().any(|frame| overlap(&one.place, frame));
                if on_data && !["band edge", "verdict"].contains(&one.text.as_str()) {
                    faults.push(format!("{name}: {:?} is over a plot", one.text));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn files_are_as_large_as_the_style_says() {
    let analysis = test_support::figures::full();
    for (style, width, height) in [
        (Style::paper(), 86.0, None),
        (
            Style {
                height: Some(70.0),
                dpi: 600,
                ..Style::paper_wide()
            },
            178.0,
            Some(70.0),
        ),
        (Style::screen(), 317.5, None),
    ] {
        let figure = test_support::figures::figure(&analysis, "space-time", &style);
        let bytes = figure.encode(Format::Png).unwrap();
        let reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let info = reader.info();
        let per_mm = f64::from(style.dpi) / 25.4;
        assert!((f64::from(info.width) - width * per_mm).abs() < 1.0);
        if let Some(height) = height {
            assert!((f64::from(info.height) - height * per_mm).abs() < 1.0);
        }
        let dims = info.pixel_dims.expect("the PNG states its resolution");
        assert_eq!(dims.unit, png::Unit::Meter);
        assert_eq!(dims.xppu, (1e3 * per_mm).round() as u32);

        let sides = svg(&figure);
        let side = |name: &str| -> f64 {
            let text = sides.split(&format!(" {name}=\"")).nth(1).unwrap();
            text.split("mm\"").next().unwrap().parse().unwrap()
        };
        assert!((side("width") - width).abs() < 0.1);
        if let Some(height) = height {
            assert!((side("height") - height).abs() < 0.1);
        }
    }
}

#[test]
fn colour_bars_follow_depth_and_map() {
    let analysis = test_support::figures::full();
    let drawn = |style: &Style| {
        svg(&test_support::figures::figure(
            &analysis,
            "temporal-spectrum",
            style,
        ))
    };
    let of = |depth: Depth| drawn(&changed(Style::screen(), |it| it.depth = depth));
    assert!(of(Depth::Fitted).contains("log scale over 8 decades"));
    assert!(of(Depth::Decades(4.0)).contains("log scale over 4 decades"));
    let decibels = of(Depth::Decibels(50.0));
    assert!(decibels.contains("dB re") && decibels.contains(">≤ −50<") && decibels.contains(">0<"));
    let gray = drawn(&changed(Style::screen(), |it| it.colormap = Colormap::Gray));
    assert_ne!(gray, drawn(&Style::screen()));
}

#[test]
fn styles_that_cannot_be_drawn_are_refused() {
    let small = changed(Style::screen(), |it| it.width = 86.0);
    let flat = changed(Style::paper(), |it| it.height = Some(10.0));
    let huge = changed(Style::paper(), |it| it.dpi = 100_000);
    let shallow = changed(Style::paper(), |it| it.depth = Depth::Decades(0.0));
    let coarse = changed(Style::paper(), |it| it.dpi = 3);
    for style in [small, flat, huge, shallow, coarse] {
        let error = style.check().unwrap_err();
        assert!(matches!(error, wavecascade::Error::Request { .. }));
    }
    for style in [Style::screen(), Style::paper(), Style::paper_wide()] {
        style.check().unwrap();
    }
}
