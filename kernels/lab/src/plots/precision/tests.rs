use super::*;
use crate::plots::Scale;
use crate::plots::picture::Element;

fn choice(x: f64, wrong: f64) -> Choice {
    Choice {
        label: format!("<{x}>"),
        x,
        x_ends: Some((0.9 * x, 1.1 * x)),
        wrong,
        wrong_ends: (wrong > 0.0).then_some((0.5 * wrong, 2.0 * wrong)),
        undecided: 3.0,
        color: 0,
        shape: Mark::Dot,
        is_hollow: false,
        is_front: true,
        is_recommended: false,
    }
}

fn legend(heading: &str, names: &[&str]) -> Legend {
    let sign = |name: &&str| Sign { name: (*name).into(), color: Some(0), shape: Mark::Dot, is_hollow: false };
    Legend { heading: heading.into(), signs: names.iter().map(sign).collect() }
}

fn of(choices: Vec<Choice>) -> Precision {
    Precision {
        title: "time & wrong".into(),
        x: Axis::new("ns per ray", Scale::Log),
        y: Axis::new("wrong per million", Scale::Log),
        at_most: Some(81.26),
        legend: vec![legend("structure", &["grid"])],
        from: None,
        choices,
    }
}

fn drawn(diagram: &Precision, format: Format) -> Picture {
    diagram.picture(format).expect("a diagram")
}

#[test]
fn none_wrong_has_a_line_of_its_own_and_every_choice_a_name() {
    assert_eq!(of(Vec::new()).picture(Format::Screen), None);
    let choices = of(vec![choice(100.0, 0.0), choice(50.0, 30.0), choice(200.0, 0.0)]);
    let text = drawn(&choices, Format::Screen).svg();
    assert!(text.contains("&lt;100&gt;") && text.contains("&lt;50&gt;"));
    assert!(text.contains("at most 82 per million"), "a bound is rounded up");
    assert!(text.contains("wrong per million"));
    // Three choices and the legend's mark.
    assert_eq!(text.matches("<circle").count(), 4);
    let arrows = Precision { from: Some(1.0), ..of(vec![choice(2.0, 0.0)]) };
    let heads = |diagram: &Precision| drawn(diagram, Format::Screen).svg().matches("<polygon").count();
    assert_eq!(heads(&arrows), heads(&Precision { from: None, ..arrows.clone() }) + 1);
}

fn texts(picture: &Picture) -> Vec<&str> {
    fn text(element: &Element) -> Option<&str> {
        if let Form::Text { text, .. } = &element.form { Some(text) } else { None }
    }
    picture.elements.iter().filter_map(text).collect()
}

#[test]
fn names_that_have_no_room_have_numbers_with_a_key() {
    let long = |x: f64, wrong: f64| Choice { label: format!("a rather long name, {x}"), ..choice(x, wrong) };
    // Intervals from one side to the other leave no room beside the mark.
    let wide = |x: f64, wrong: f64| Choice { x_ends: Some((20.0, 900.0)), ..long(x, wrong) };
    let all = vec![long(100.0, 1e6), long(100.5, 1e6), wide(101.0, 9e5), wide(880.0, 1e6), wide(50.0, 0.0)];
    let diagram = of(all);
    for format in [Format::Screen, Format::OneColumn, Format::TwoColumns] {
        let picture = drawn(&diagram, format);
        for choice in &diagram.choices {
            let has_name = texts(&picture).iter().any(|text| text.ends_with(&choice.label));
            assert!(has_name, "{}: {:?}", choice.label, texts(&picture));
        }
        let count = |wanted: &str| texts(&picture).iter().filter(|text| **text == wanted).count();
        assert_eq!((count("1M"), count("1e6"), count("2M")), (1, 0, 0), "no more than all rays are wrong");
    }
    let numbered = drawn(&of(vec![Choice { label: "x".repeat(80), ..choice(3.0, 7.0) }]), Format::OneColumn);
    let key = format!("1 {}", "x".repeat(80));
    assert!(texts(&numbered).contains(&"1") && texts(&numbered).concat().ends_with(&key.replace(' ', "")));
}

#[test]
fn groups_of_the_legend_have_headings_if_they_have_entries() {
    let rows = |format| {
        let groups =
            [("structure", &["grid", "irregular", "bvh"][..]), ("schedule", &["second", "fused"]), ("rules", &[])];
        let legend = groups.map(|(heading, names)| legend(heading, names)).into();
        let picture = drawn(&Precision { legend, ..of(vec![choice(1.0, 0.0)]) }, format);
        let place = |element: &Element| match &element.form {
            Form::Text { text, at, .. } => Some((text.clone(), *at)),
            _ => None,
        };
        picture.elements.iter().filter_map(place).collect::<Vec<(String, Point)>>()
    };
    for format in [Format::Screen, Format::OneColumn, Format::TwoColumns] {
        let texts = rows(format);
        let at = |wanted: &str| texts.iter().find(|(text, _)| text == wanted).map(|(_, at)| *at);
        let [structure, grid, schedule, second, fused] =
            ["structure:", "grid", "schedule:", "second", "fused"].map(|text| at(text).expect(text));
        assert!(at("rules:").is_none(), "a group without entries: {texts:?}");
        assert!(structure.1 == grid.1 && schedule.1 == second.1 && second.1 == fused.1, "{texts:?}");
        // Beside each other where both fit; otherwise below each other, with their entries aligned.
        match format {
            Format::OneColumn => assert!(schedule.1 > structure.1 && second.0 == grid.0, "{texts:?}"),
            _ => assert!(schedule.1 == structure.1 && schedule.0 > grid.0, "{texts:?}"),
        }
    }
}

#[test]
fn the_recommended_choice_has_a_ring_in_the_diagram_and_in_the_legend() {
    let rings = |is_recommended: bool| {
        let choices = vec![Choice { is_recommended, ..choice(2.0, 0.0) }, choice(3.0, 0.0), choice(4.0, 7.0)];
        let picture = drawn(&of(choices), Format::OneColumn);
        let ring = |element: &&Element| match element.form {
            Form::Circle { outline: Some(_), .. } => element.color == BLACK,
            _ => false,
        };
        (picture.elements.iter().filter(ring).count(), texts(&picture).contains(&"recommended"))
    };
    assert_eq!([rings(true), rings(false)], [(2, true), (0, false)]);
}
