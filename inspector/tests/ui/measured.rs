//! What the inspector's measurement of choices answers in tests.

use std::sync::Arc;
use std::time::Instant;

use raystep_inspector::session::measure::{Measure, Measurement};
use raystep_kernels::let_others_run;
use raystep_lab::plots::precision::{Choice, Legend, Precision, Sign};
use raystep_lab::plots::{Axis, Draw as _, Format, Mark, Scale};
use raystep_lab::report::Answer;
use raystep_lab::reporter::Reporter;

use crate::ui::stage::PATIENCE;

/// An answer that is the same every time; a thorough one takes 30 s unless it is cancelled.
pub(crate) fn measured() -> Measure {
    Arc::new(|measurement, reporter| Box::pin(answer(measurement, reporter)))
}

async fn answer(measurement: Measurement, reporter: &dyn Reporter) -> Result<Answer, String> {
    if !measurement.extent.is_quick {
        (measurement.ready)(Answer {
            columns: vec!["choice", "time per ray, one run"],
            rows: vec![["bvh fused robust", "120 ns"].map(str::to_owned).to_vec()],
            ..Answer::default()
        });
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE / 8 {
            reporter.part("timing", 1, 3);
            if reporter.is_cancelled() {
                return Err("cancelled".into());
            }
            let_others_run().await;
        }
    }
    let choice = |label: &str, x: f64, wrong: f64, color| Choice {
        label: label.into(),
        x,
        x_ends: Some((0.9 * x, 1.1 * x)),
        wrong,
        wrong_ends: Some((0.5 * wrong, 2.0 * wrong + 81.0)),
        undecided: 30.0,
        color,
        shape: Mark::Dot,
        is_hollow: wrong > 0.0,
        is_front: true,
        is_recommended: wrong <= 0.0,
    };
    let diagram = |title: &str, from| {
        let diagram = Precision {
            title: title.into(),
            x: Axis::new("time a ray, ns", Scale::Log),
            y: Axis::new("wrong rays per million", Scale::Log),
            at_most: Some(81.0),
            legend: vec![Legend {
                heading: "structure".into(),
                signs: vec![Sign { name: "grid".into(), color: Some(0), shape: Mark::Dot, is_hollow: false }],
            }],
            from,
            choices: vec![choice("bvh, fused", 120.0, 0.0, 1), choice("grid, fused, paper", 90.0, 300.0, 0)],
        };
        diagram.picture(Format::OneColumn).expect("it has choices")
    };
    let name = measurement.subject.scene.name;
    let rows = [["bvh, fused, robust", "120 ns", "0 of 4,096"], ["grid, fused, paper", "90 ns", "12 of 4,096"]];
    Ok(Answer {
        sentences: vec![vec![
            (format!("{name}, CPU: bvh, fused, robust is fastest: 120 ns a ray."), true),
            (" Not distinguishable in time: grid, fused, robust.".into(), false),
        ]],
        figures: vec![
            (diagram("Time against wrong rays", None), "What the first diagram shows.".into()),
            (diagram("Without one rule", Some(100.0)), "What the second diagram shows.".into()),
        ],
        columns: vec!["choice", "time a ray", "wrong"],
        rows: rows.map(|row| row.map(str::to_owned).to_vec()).to_vec(),
        notes: vec!["none: testing every triangle takes too long".into()],
        files: vec![("choices.csv".into(), b"schema_version\n".to_vec())],
    })
}
