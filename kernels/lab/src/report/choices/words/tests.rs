use super::super::COLUMNS;
use super::*;
use crate::html::plain;
use crate::rays::Random;

/// A choice with its time per ray and its ratio to the recommended one with its interval, and how many rays are wrong.
fn row(name: [&str; 3], ns: f64, ratio: Option<[f64; 3]>, wrong: u64) -> Row {
    let [accelerator, schedule, numerics] = name;
    Row::new(COLUMNS)
        .set("configuration", name.join("/"))
        .set("accelerator", accelerator)
        .set("schedule", schedule)
        .set("numerics", numerics)
        .set("rays", 36_864_u64)
        .set("judged_rays", 36_864_u64)
        .set("at_bound", 0_u64)
        .set("ns_per_ray", ns)
        .set("time_ratio", ratio.map(|[median, ..]| median))
        .set("time_ratio_low", ratio.map(|[_, low, _]| low))
        .set("time_ratio_high", ratio.map(|[.., high]| high))
        .set("wrong_rays", wrong)
        .set("most_wrong_per_million", MOST_WRONG)
        .set("is_accurate", wrong == 0)
}

fn best(row: Row) -> Row {
    row.set("is_recommended", true)
}

fn method(name: &str, ns: f64, ratio: Option<[f64; 3]>, wrong: u64) -> Row {
    row(["", "", ""], ns, ratio, wrong).set("method", name).set("rays", "").set("configuration", name)
}

const GRID: [&str; 3] = ["grid", "compact", "robust"];
const BVH: [&str; 3] = ["bvh", "fused", "robust"];
const PAPER: [&str; 3] = ["bvh", "fused", "paper"];

fn sentences_of(rows: &[Row], outside: Option<&str>) -> Vec<String> {
    answer("On box with 2 CPU cores", rows, outside).iter().map(|sentence| plain(sentence)).collect()
}

#[test]
fn it_says_what_to_use_then_what_cannot_be_told_from_it_then_what_the_papers_rules_change() {
    let slow = row(GRID, 700.0, Some([6.0, 5.0, 8.0]), 0);
    let paper = row(PAPER, 107.0, Some([0.66, 0.6, 0.7]), 0);
    let rows = [paper.clone(), best(row(BVH, 162.0, Some([1.0; 3]), 0)), slow.clone()];
    assert_eq!(
        sentences_of(&rows, None),
        [
            "Use --accelerator bvh --schedule fused (robust): 162 ns per ray, none of 36,864 rays wrong.",
            "On box with 2 CPU cores, no other robust choice is as fast.",
            "The paper's rules (bvh fused) take only 0.66 times as long (0.6 to 0.7, 95%), and get none of 36,864 rays wrong, \
             but can lose rays at edges.",
            "Accurate means: at most 100 wrong rays per million, with 95% confidence.",
        ]
    );
    let alike = row(["bvh", "compact", "robust"], 120.0, Some([1.1, 0.78, 1.63]), 0);
    let lossy = row(["grid", "fused", "robust"], 50.0, Some([0.3, 0.2, 0.4]), 92);
    let rows = [
        paper.set("wrong_rays", 92_u64).set("time_ratio_low", 0.21).set("time_ratio_high", 1.79),
        best(row(BVH, 162.0, Some([1.0; 3]), 0)),
        slow,
        alike,
        lossy,
        method("mine", 100.0, Some([0.6, 0.5, 0.7]), 0),
        method("theirs", 100.0, None, 0),
        method("sloppy", 900.0, Some([9.0, 8.0, 10.0]), 7),
    ];
    let sentences = sentences_of(&rows, Some("most"));
    assert_eq!(
        sentences[1..4],
        [
            "On box with 2 CPU cores, mine is faster in the runs that are compared; bvh compact cannot be told from it in \
             time; theirs is not compared: too few runs, or no interval; every other accurate robust choice is slower.",
            "Not accurate: grid fused (faster, but 92 of 36,864 wrong), sloppy (7 of 36,864 wrong).",
            "The paper's rules (bvh fused) are not distinguishable in time (ratio 0.21 to 1.79, 95%), and get 92 of \
             36,864 rays wrong. With a grid, they can lose rays that start outside it; here most rays start there.",
        ]
    );
}

#[test]
fn without_an_accurate_choice_none_is_recommended_and_a_raised_limit_is_told() {
    let wrong = row(GRID, 50.0, None, 92);
    let sentences = sentences_of(&[wrong], None);
    let first = "No choice can be recommended. On box with 2 CPU cores, no robust one was shown to be accurate.";
    assert_eq!(sentences[..2], [first, "The paper's rules were not measured."]);
    let of_sample = best(row(BVH, 162.0, Some([1.0; 3]), 0));
    let of_sample = of_sample.set("judged_rays", 13_421_u64).set("most_wrong_per_million", 223.187);
    let sentences = sentences_of(&[of_sample], None);
    assert!(sentences[0].ends_with("none of 13,421 judged rays wrong (a sample of 36,864)."), "{sentences:?}");
    assert_eq!(sentences[1], "On box with 2 CPU cores, no other robust choice was measured.");
    let limit = "Accurate means: at most 230 wrong rays per million, with 95% confidence; 13,421 judged rays cannot \
                 show less.";
    assert_eq!(sentences.last().map(String::as_str), Some(limit));
    assert_eq!(sentences_of(&[], None).len(), 2);
}

/// A table of random choices: some are missing, have no interval, are wrong, or are methods of other programs.
fn random_table(random: &mut Random) -> Vec<Row> {
    let mut rows = Vec::new();
    let ratio = |random: &mut Random| {
        let median = [1.0, 1.0, 1.0 + 0.1 * random.unit(), 0.3 + 1.5 * random.unit()][random.below(4)];
        let width = [0.001, 0.02, 0.3, 1.0][random.below(4)] * random.unit();
        (random.below(5) > 0).then_some([median, median / (1.0 + width), median * (1.0 + width)])
    };
    for accelerator in ["grid", "irregular", "bvh", "none"] {
        for schedule in ["first", "second", "compact", "fused"] {
            for numerics in ["robust", "paper"] {
                if random.below(3) > 0 {
                    let wrong = if random.below(3) == 0 { 1 + random.below(500) as u64 } else { 0 };
                    rows.push(row([accelerator, schedule, numerics], 100.0 * random.unit(), ratio(random), wrong));
                }
            }
        }
    }
    for name in ["mine", "theirs"].into_iter().take(random.below(3)) {
        rows.push(method(name, 100.0 * random.unit(), ratio(random), random.below(2) as u64));
    }
    random.shuffle(&mut rows);
    let accurate = |row: &&mut Row| is_accurate(row) && is_robust(row);
    if let Some(first) = rows.iter_mut().find(accurate).filter(|_| random.below(10) > 0) {
        *first = best(first.clone()).set("time_ratio", 1.0).set("time_ratio_low", 1.0).set("time_ratio_high", 1.0);
    }
    rows
}

/// A row's interval, told in the test's own words.
fn is(row: &Row, what: &str) -> bool {
    let ends = row.number("time_ratio_low").zip(row.number("time_ratio_high"));
    match (ends, what) {
        (None, _) => what == "unknown",
        (Some((_, high)), "faster") => high < 1.0,
        (Some((low, _)), "slower") => low > 1.0,
        (Some((low, high)), "as fast") => low <= 1.0 && high >= 1.0 && low >= 1.0 / 1.05 && high <= 1.05,
        (Some((low, high)), "not distinguishable") => low <= 1.0 && high >= 1.0 && (low < 1.0 / 1.05 || high > 1.05),
        _ => false,
    }
}

/// The choices that a list names, and how many more it counts.
fn named<'a>(rows: &'a [Row], list: &str) -> (Vec<&'a Row>, usize) {
    let (list, more) = match list.split_once(" and ") {
        Some((list, more)) => (list, more.trim_end_matches(" more").parse().expect("a number")),
        None => (list, 0),
    };
    let find = |name: &str| {
        let of = |row: &&Row| {
            let ours = format!("{} {}", row.get("accelerator"), row.get("schedule"));
            row.get("method") == name || (row.get("numerics") == "robust" && ours == name)
        };
        rows.iter().find(of).unwrap_or_else(|| panic!("no choice {name}"))
    };
    (list.split(", ").map(find).collect(), more)
}

/// The phrases of the second sentence, with what they say of the choices before them.
const PHRASES: [(&str, &str); 9] = [
    (" is faster in the runs that are compared", "faster"),
    (" are faster in the runs that are compared", "faster"),
    (" is as fast, within 5%", "as fast"),
    (" are as fast, within 5%", "as fast"),
    (" cannot be told from it in time", "not distinguishable"),
    (" is not compared: too few runs, or no interval", "unknown"),
    (" are not compared: too few runs, or no interval", "unknown"),
    (" is slower", "slower"),
    (" are slower", "slower"),
];

fn check_others(rows: &[Row], sentence: &str) {
    let others: Vec<&Row> =
        rows.iter().filter(|r| is_accurate(r) && !is_papers(r) && r.get("is_recommended") != "true").collect();
    let parts = sentence.strip_prefix("On box with 2 CPU cores, ").and_then(|s| s.strip_suffix('.')).expect("a place");
    let mut told: Vec<String> = Vec::new();
    let mut count = 0;
    for part in parts.split("; ") {
        if let Some((which, _)) =
            part.split_once(" choice ").filter(|(w, _)| w.starts_with("no other") || w.starts_with("every other"))
        {
            // What it speaks of are ours that are not named before.
            let is_all = !which.contains("accurate");
            let spoken =
                rows.iter().filter(|r| is_robust(r) && r.get("is_recommended") != "true" && (is_all || is_accurate(r)));
            let spoken: Vec<&Row> = spoken.filter(|r| !told.contains(&r.get("configuration").to_owned())).collect();
            let hidden = spoken.iter().filter(|row| !is(row, "slower")).count();
            if part.ends_with("measured") {
                assert!(spoken.is_empty(), "{sentence}");
            } else {
                // A list names few, and counts the others.
                assert!(hidden <= count, "{sentence}");
            }
            continue;
        }
        let (phrase, what) = PHRASES.iter().find(|(phrase, _)| part.ends_with(phrase)).expect(part);
        let (those, more) = named(rows, part.strip_suffix(phrase).expect("its end"));
        for row in &those {
            assert!(is(row, what) && is_accurate(row) && row.get("is_recommended") != "true", "{sentence}: {row:?}");
            told.push(row.get("configuration").to_owned());
        }
        count += more;
        let all = others.iter().filter(|row| is(row, what) && (*what != "slower" || is_own(row))).count();
        assert_eq!(those.len() + more, all, "{sentence}");
    }
}

fn check_papers(rows: &[Row], sentence: &str) {
    let Some(rest) = sentence.strip_prefix("The paper's rules (") else {
        assert!(sentence.starts_with("The paper's rules were not measured") && !rows.iter().any(is_papers));
        return;
    };
    let (name, said) = rest.split_once(") ").expect("a name");
    let row = rows.iter().find(|r| is_papers(r) && format!("{} {}", r.get("accelerator"), r.get("schedule")) == name);
    let row = row.expect(sentence);
    let what = match said {
        s if s.starts_with("take only ") => "faster",
        s if s.starts_with("are as fast") => "as fast",
        s if s.starts_with("are not distinguishable") => "not distinguishable",
        s if s.starts_with("have too few runs") => "unknown",
        s if s.contains(" per ray, and ") => return,
        _ => "slower",
    };
    assert!(is(row, what), "{sentence}: {row:?}");
    assert_eq!(said.contains("none of"), row.get("wrong_rays") == "0", "{sentence}");
}

#[test]
fn no_sentence_contradicts_an_interval_in_random_tables() {
    let mut random = Random::new(2007);
    let mut recommended = 0;
    for _ in 0..400 {
        let rows = random_table(&mut random);
        let sentences = sentences_of(&rows, None);
        let papers = sentences.iter().find(|s| s.starts_with("The paper's rules")).expect("a sentence");
        check_papers(&rows, papers);
        if let Some(list) = sentences.iter().find_map(|s| s.strip_prefix("Not accurate: ")) {
            for part in list.trim_end_matches('.').split("), ") {
                let (name, said) = part.split_once(" (").expect("what is wrong");
                let row = named(&rows, name).0[0];
                assert!(!is_accurate(row) && said.starts_with("faster") == is(row, "faster"), "{list}");
            }
        }
        let Some(best) = rows.iter().find(is_recommended) else {
            assert!(sentences[0].starts_with("No choice can be recommended"), "{sentences:?}");
            continue;
        };
        recommended += 1;
        let [accelerator, schedule] = ["accelerator", "schedule"].map(|column| best.get(column));
        let first = format!("Use --accelerator {accelerator} --schedule {schedule} (robust): ");
        assert!(sentences[0].starts_with(&first) && is_accurate(best), "{sentences:?}");
        check_others(&rows, &sentences[1]);
    }
    assert!(recommended > 200, "only {recommended} tables had a choice to recommend");
}
