use std::collections::BTreeSet;
use std::io::Read as _;

use super::picture::{Element, Form};
use super::precision::{Choice, Legend, Precision, Sign};
use super::*;

const FORMATS: [Format; 3] = [Format::Screen, Format::OneColumn, Format::TwoColumns];

fn plot(points: Vec<(f64, f64)>, scale: Scale) -> Plot {
    let axis = |label: &str| Axis::new(label, scale);
    let series = vec![Series::line("a & b", 0, points)];
    Plot::new("t < 1", axis("time, ms"), axis("rays"), series)
}

#[test]
fn what_cannot_be_shown_is_left_out_and_nothing_is_no_plot() {
    let none = [plot(vec![], Scale::Log), plot(vec![(0.0, 1.0), (f64::NAN, 2.0), (1.0, -1.0)], Scale::Log)];
    for plot in none {
        assert!(plot.inline().is_none() && plot.files("x").is_empty());
    }
    let svg = plot(vec![(1.0, 2.0), (10.0, 0.0), (1e30, 3.0)], Scale::Log).inline().expect("a plot");
    assert!(svg.starts_with("<svg") && svg.contains("a &amp; b") && svg.contains("t &lt; 1"), "{svg}");
    assert!(svg.contains("role=\"img\"") && !svg.contains("xmlns"), "{svg}");
    // Two points, and the legend's.
    assert_eq!(svg.matches("<circle").count(), 3);
    let empty = Bars { title: String::new(), x: String::new(), legend: Vec::new(), bars: Vec::new() };
    assert!(empty.inline().is_none());
}

#[test]
fn zero_has_a_place_where_the_axis_is_one_of_counts() {
    let svg = plot(vec![(1.0, 0.0), (10.0, 300.0)], Scale::LogWithZero).inline().expect("a plot");
    assert_eq!(svg.matches("<circle").count(), 3);
}

fn texts(picture: &Picture) -> Vec<(&str, Frame)> {
    fn text(element: &Element) -> Option<(&str, Frame)> {
        let Form::Text { text, .. } = &element.form else { return None };
        Some((text, element.form.text_box()?))
    }
    picture.elements.iter().filter_map(text).collect()
}

/// What no text may cover: marks, and the lines of axes and borders.
fn obstacles(picture: &Picture) -> Vec<Frame> {
    let of = |element: &Element| -> Vec<Frame> {
        match &element.form {
            Form::Circle { center, radius, .. } => vec![Frame::around(*center, *radius)],
            Form::Polygon { points, outline } => {
                let frame = Frame::along(points, 0.0);
                let is_small = frame.right - frame.left < 12.0 && frame.bottom - frame.top < 12.0;
                match outline {
                    _ if element.color == WHITE => Vec::new(),
                    // A mark that is not pale.
                    _ if is_small && element.opacity > 0.5 => vec![frame],
                    Some(_) => {
                        [[0, 1], [1, 2], [2, 3], [3, 0]].map(|side| Frame::along(&side.map(|i| points[i]), 0.4)).into()
                    }
                    None => Vec::new(),
                }
            }
            _ => Vec::new(),
        }
    };
    picture.elements.iter().flat_map(of).collect()
}

/// Everything that a reader would see at once.
fn check(plot: &dyn Draw, names: &[&str]) {
    for format in FORMATS {
        let Some(picture) = plot.picture(format) else { continue };
        let sheet = Frame { left: 0.0, right: picture.size.0, top: 0.0, bottom: picture.size.1 };
        let (texts, obstacles) = (texts(&picture), obstacles(&picture));
        for (i, (text, frame)) in texts.iter().enumerate() {
            assert!(sheet.holds(*frame), "{format:?}: {text} leaves the picture: {frame:?}\n{plot:#?}");
            for (other, of) in &texts[..i] {
                assert!(!of.meets(*frame), "{format:?}: {text} meets {other}: {frame:?} {of:?}\n{plot:#?}");
            }
            let met = obstacles.iter().find(|o| o.meets(*frame));
            assert!(met.is_none(), "{format:?}: {text} meets a mark or a border: {frame:?} {met:?}\n{plot:#?}");
        }
        for element in &picture.elements {
            let Form::Text { size, .. } = &element.form else { continue };
            let points = size * picture.point;
            assert!(format == Format::Screen || (7.0..=9.0).contains(&points), "{points} pt");
        }
        // Names may be broken into lines.
        let all: String = texts.iter().flat_map(|(text, _)| text.chars()).filter(|c| !c.is_whitespace()).collect();
        for name in names {
            let name: String = name.chars().filter(|c| !c.is_whitespace()).collect();
            assert!(all.contains(&name), "{format:?}: {name} is missing\n{plot:#?}");
        }
    }
}

const WORDS: [&str; 12] = [
    "grid",
    "irregular",
    "bvh",
    "compact",
    "fused,",
    "paper",
    "Embree-4.3.3",
    "optix_prime_with_watertight_edges",
    "ours",
    "ÜberTrace²",
    "(8-wide, SAH)",
    "W",
];

fn name(random: &mut fastrand::Rng) -> String {
    let count = random.usize(1..=8);
    (0..count).map(|_| WORDS[random.usize(..WORDS.len())]).collect::<Vec<_>>().join(" ")
}

/// A value from 1 to 10⁴, most of them in one of few clusters.
fn value(random: &mut fastrand::Rng, clusters: usize) -> f64 {
    let cluster = random.usize(0..clusters) as f64;
    10f64.powf(4.0 * (cluster + 0.5) / clusters as f64 + random.f64() * [0.0, 0.02, 1.0][random.usize(0..3)])
}

fn choice(random: &mut fastrand::Rng, clusters: usize) -> Choice {
    let [x, wrong] = [0; 2].map(|_| value(random, clusters));
    let wrong = if random.bool() { 0.0 } else { wrong };
    let factor = 1.0 + random.f64() * [0.01, 0.3, 30.0][random.usize(0..3)];
    Choice {
        label: name(random),
        x,
        x_ends: random.bool().then_some((x / factor, x * factor)),
        wrong,
        wrong_ends: (wrong > 0.0).then_some((wrong / factor, (wrong * factor).min(1e6))),
        undecided: if random.bool() { 0.0 } else { value(random, clusters) },
        color: random.usize(0..6),
        shape: [Mark::Dot, Mark::Square, Mark::Triangle, Mark::Down][random.usize(0..4)],
        is_hollow: random.bool(),
        is_front: random.bool(),
        is_recommended: random.u8(..) < 64,
    }
}

/// A group of a legend: mostly short, as ours are, so that some share a row.
fn legend(random: &mut fastrand::Rng) -> Legend {
    let is_short = random.bool();
    let word = |random: &mut fastrand::Rng| WORDS[random.usize(..WORDS.len())].to_owned();
    let signs = (0..random.usize(0..5)).map(|i| Sign {
        name: if is_short { word(random) } else { name(random) },
        color: random.bool().then_some(i),
        shape: [Mark::Dot, Mark::Square, Mark::Triangle, Mark::Down][random.usize(0..4)],
        is_hollow: random.bool(),
    });
    let signs = signs.collect();
    let heading = if is_short { word(random) } else { [word(random), word(random)].join(" ") };
    Legend { heading, signs }
}

#[test]
fn no_text_of_a_precision_diagram_meets_another_or_a_mark_over_random_tables() {
    let mut random = fastrand::Rng::with_seed(44);
    for round in 0..100 {
        let (clusters, count) = (random.usize(1..6), random.usize(1..if round % 20 == 0 { 60 } else { 24 }));
        let choices: Vec<Choice> = (0..count).map(|_| choice(&mut random, clusters)).collect();
        let legend: Vec<_> = (0..random.usize(0..5)).map(|_| legend(&mut random)).collect();
        let of_legend = legend
            .iter()
            .filter(|group| !group.signs.is_empty())
            .flat_map(|group| group.signs.iter().map(|sign| sign.name.clone()).chain([format!("{}:", group.heading)]));
        let names: Vec<String> = choices.iter().map(|c| c.label.clone()).chain(of_legend).collect();
        let diagram = Precision {
            title: name(&mut random),
            x: Axis::new("time per ray, ns", [Scale::Log, Scale::Ratio][random.usize(0..2)]),
            y: Axis::new("wrong per million rays aimed at edges and cell faces", Scale::Log),
            at_most: random.bool().then(|| value(&mut random, 3)),
            legend,
            from: random.bool().then_some(1.0),
            choices,
        };
        check(&diagram, &names.iter().map(String::as_str).collect::<Vec<_>>());
    }
}

fn series(random: &mut fastrand::Rng, clusters: usize, rows: Option<usize>) -> Series {
    let count = random.usize(1..12);
    let points = (0..count).map(|_| {
        let x = value(random, clusters) * [1.0, 1e-9, 1e12][random.usize(0..3)];
        let y = match rows {
            None => value(random, clusters),
            Some(rows) => random.usize(0..rows) as f64,
        };
        (x, y)
    });
    let points: Vec<_> = points.collect();
    let whiskers = points.iter().map(|&(x, y)| if rows.is_some() { (0.9 * x, 1.2 * x) } else { (0.9 * y, 1.2 * y) });
    let whiskers = whiskers.collect();
    let color = random.usize(0..7);
    Series { whiskers, ..Series::line(name(random), color, points) }
}

#[test]
fn no_text_of_other_plots_meets_another_or_a_mark_over_random_tables() {
    let mut random = fastrand::Rng::with_seed(38);
    let scales = [Scale::Linear, Scale::Log, Scale::LogWithZero, Scale::Ratio];
    for _ in 0..100 {
        let random = &mut random;
        let (title, clusters) = (name(random), random.usize(1..6));
        let axis = |random: &mut fastrand::Rng| Axis::new(name(random), scales[random.usize(0..4)]);
        let (x, y) = (axis(random), axis(random));
        let places: Vec<_> = (0..random.usize(0..4)).map(|_| (value(random, clusters), name(random))).collect();
        let many = |random: &mut fastrand::Rng, rows| -> Vec<Series> {
            (0..random.usize(1..9)).map(|_| series(random, clusters, rows)).collect()
        };
        let names = |series: &[Series]| series.iter().map(|s| s.name.clone()).collect::<Vec<_>>();
        let check =
            |plot: &dyn Draw, names: Vec<String>| check(plot, &names.iter().map(String::as_str).collect::<Vec<_>>());
        let named = places.iter().map(|p| p.1.clone()).collect::<Vec<_>>();
        let lines = many(random, None);
        let of_plot = [names(&lines), named.clone()].concat();
        check(&Plot { places: places.clone(), ..Plot::new(title.clone(), x.clone(), y.clone(), lines) }, of_plot);
        let panels: Vec<Panel> =
            (0..2).map(|_| Panel { y: y.clone(), height: Some(90.0), series: many(random, None) }).collect();
        let of_panels = panels.iter().flat_map(|p| names(&p.series)).chain(named).collect();
        check(&Plot { title: title.clone(), x: x.clone(), panels, places }, of_panels);
        let rows: Vec<String> = (0..random.usize(1..9)).map(|_| name(random)).collect();
        let series = many(random, Some(rows.len()));
        let of_forest = [names(&series), rows.clone()].concat();
        check(&Forest { title: title.clone(), x, names: rows.clone(), neutral: 1.0, series }, of_forest);
        let bars = rows.iter().map(|name| (name.clone(), vec![(value(random, 2), 0), (value(random, 2), 1)])).collect();
        let legend = vec![name(random), name(random)];
        let of_bars = [legend.clone(), rows].concat();
        check(&Bars { title, x: "time, ms".into(), legend, bars }, of_bars);
    }
}

#[test]
fn every_colour_has_a_mark_of_its_own_beside_those_with_a_meaning() {
    let marks: BTreeSet<String> = (0..6).map(|color| format!("{:?}", Mark::Own.of(color))).collect();
    assert_eq!(marks.len(), 6);
    assert!(!marks.contains("Triangle"));
}

/// The number after a word of a PDF.
fn number_after(pdf: &[u8], word: &str) -> Option<usize> {
    let at = find(pdf, word.as_bytes())? + word.len();
    let digits = pdf[at..].iter().copied().skip_while(u8::is_ascii_whitespace).take_while(u8::is_ascii_digit);
    String::from_utf8(digits.collect()).ok()?.parse().ok()
}

fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes.windows(wanted.len()).position(|window| window == wanted)
}

#[test]
fn a_pdf_is_well_formed_of_the_columns_width_and_holds_paths_only() {
    let plot = plot(vec![(1.0, 2.0), (10.0, 7.0)], Scale::Log);
    let files = plot.files("error");
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    let of = |width: &str| ["pdf", "svg"].map(|kind| format!("error-{width}.{kind}"));
    assert_eq!(names, [of("one-column"), of("two-columns")].concat());
    for (name, pdf) in files.iter().filter(|(name, _)| name.ends_with(".pdf")) {
        assert!(pdf.starts_with(b"%PDF-1.") && pdf.trim_ascii_end().ends_with(b"%%EOF"), "{name}");
        let table = number_after(pdf, "startxref").expect("a place");
        assert!(pdf[table..].starts_with(b"xref\n0 6\n"), "{name}");
        for object in 1..6 {
            let line = &pdf[table + b"xref\n0 6\n".len() + 20 * object..][..20];
            let at: usize = std::str::from_utf8(&line[..10]).expect("digits").parse().expect("a number");
            assert!(pdf[at..].starts_with(format!("{object} 0 obj").as_bytes()), "{name}: object {object}");
        }
        // 84 mm are 238.11 points, 178 mm are 504.57.
        let width = if name.contains("one") { "[0 0 238.11" } else { "[0 0 504.56" };
        assert!(find(pdf, width.as_bytes()).is_some(), "{name}: {}", String::from_utf8_lossy(pdf));
        for foreign in ["/Font", "/XObject", "/Image", "/ExtGState"] {
            assert!(find(pdf, foreign.as_bytes()).is_none(), "{name}: {foreign}");
        }
        let length = number_after(pdf, "/Length").expect("a length");
        let begin = find(pdf, b"stream\n").expect("a stream") + b"stream\n".len();
        let mut content = String::new();
        flate2::read::ZlibDecoder::new(&pdf[begin..begin + length]).read_to_string(&mut content).expect("a drawing");
        let count = |operator: &str| content.lines().filter(|line| line.ends_with(operator)).count();
        assert_eq!(
            (count("q"), count("Q")),
            (count("Q"), texts(&plot.picture(Format::OneColumn).expect("a plot")).len())
        );
        assert!(count("c") > 50, "outlines of letters");
    }
}

#[test]
fn numbers_at_the_ends_of_what_there_is_are_drawn_or_left_out_in_no_time() {
    let ends = [f64::MAX, f64::MIN, f64::MIN_POSITIVE, 5e-324, 0.0, 1e16, 1e16 + 2.0, f64::INFINITY, f64::NAN];
    for scale in [Scale::Linear, Scale::Log, Scale::LogWithZero, Scale::Ratio] {
        for a in ends {
            for b in ends {
                check(&plot(vec![(a, b), (b, a), (a, a)], scale), &[]);
            }
        }
    }
}
