use super::*;

/// Every value of an option, or some of many.
fn values(row: &Row) -> Vec<String> {
    match row.values {
        Values::Names(names) => names().into_iter().map(String::from).collect(),
        Values::Whole(least, most) => vec![least.to_string(), most.to_string()],
        Values::Switch => vec!["false".into(), "true".into()],
        Values::Cells => vec!["auto".into(), "1,2,4096".into()],
    }
}

#[test]
fn every_value_of_every_option_is_read_back() {
    for row in ROWS {
        let mut choices = Choices::default();
        if !(row.applies)(&choices) {
            let mapping = Row::named("mapping").expect("a row");
            mapping.set(&mut choices, "fragment").expect("a value");
        }
        let mut seen = Vec::new();
        for value in values(row) {
            row.set(&mut choices, &value).unwrap_or_else(|e| panic!("{} {value}: {e}", row.name));
            assert_eq!(row.get(&choices).to_string(), value, "{}", row.name);
            seen.push(choices);
        }
        seen.dedup();
        assert!(seen.len() > 1, "{} changes nothing", row.name);
        let mut after = choices;
        let mut wrong = ["", "-1", "tree", "1,2", "4294967296", "0,1,1", "1,1,4097"].map(String::from).to_vec();
        if let Values::Whole(least, most) = row.values {
            wrong.extend(least.checked_sub(1).into_iter().chain(most.checked_add(1)).map(|number| number.to_string()));
        }
        for wrong in &wrong {
            assert!(row.set(&mut after, wrong).is_err(), "{} {wrong}", row.name);
            assert_eq!(after, choices, "{} {wrong}", row.name);
        }
    }
}

#[test]
fn names_are_distinct_and_the_default_is_refused_nowhere() {
    let mut names: Vec<_> = ROWS.iter().map(|row| row.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), ROWS.len());
    for &schedule in ScheduleKind::ALL {
        let choices = Choices { schedule, ..Choices::default() };
        assert_eq!(choices.settled(None), choices);
    }
}

#[test]
fn what_does_not_go_together_gives_way_to_what_is_chosen() {
    let chosen = |values: &[(&str, &str)]| {
        values.iter().fold(Choices::stepped(), |mut choices, (name, value)| {
            let row = Row::named(name).expect("a row");
            row.set(&mut choices, value).expect("a value");
            choices.settled(Some(row))
        })
    };
    let dda = chosen(&[("numerics", "paper"), ("traversal", "3d-dda")]);
    assert_eq!((dda.numerics, dda.traversal), (Numerics::Paper, Traversal::Dda3d));
    let bvh = chosen(&[("numerics", "paper"), ("traversal", "3d-dda"), ("accelerator", "bvh")]);
    assert_eq!((bvh.accelerator, bvh.traversal), (Accelerator::Bvh, Traversal::AmanatidesWoo));
    let drawn = chosen(&[("spp", "4"), ("mapping", "fragment"), ("update", "swap")]);
    let swap = Fragment::of(None, Some(Update::Swap), None, None);
    assert_eq!((drawn.samples.count, drawn.schedule), (1, ScheduleKind::Second));
    assert_eq!(drawn.mapping, Mapping::Fragment(swap));
    let early = chosen(&[("mapping", "fragment"), ("update", "swap"), ("cull", "early-z")]);
    assert_eq!(early.mapping.fragment().map(|how| (how.update, how.cull)), Some((Update::Copy, Cull::EarlyZ)));
    let compact = Choices { mapping: Mapping::Fragment(Fragment::default()), ..Choices::stepped() };
    assert_eq!(compact.settled(None).schedule, ScheduleKind::Second);
}

/// As the command line and links choose them, one after the other.
#[test]
fn every_mapping_is_reached_by_its_rows() {
    for how in Fragment::all() {
        let mut choices = Choices::default();
        let values = [how.update.name(), how.cull.name(), how.until.name(), how.targets.name()];
        for (name, value) in
            ["mapping", "update", "cull", "until", "targets"].into_iter().zip(["fragment"].into_iter().chain(values))
        {
            Row::named(name).expect("a row").set(&mut choices, value).expect("a value");
        }
        assert_eq!(choices.mapping, Mapping::Fragment(how));
        let implied = Fragment::of(None, Some(how.update), None, None);
        let mut fewer = Choices::default();
        for (name, value) in [("mapping", "fragment"), ("update", how.update.name())] {
            Row::named(name).expect("a row").set(&mut fewer, value).expect("a value");
        }
        assert_eq!(fewer.mapping, Mapping::Fragment(implied), "what goes with an update is the same everywhere");
    }
}
