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
        for wrong in ["", "-1", "tree", "1,2", "4294967296", "0,1,1", "1,1,4097"] {
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
    for choices in [Choices::default(), Choices::stepped()] {
        assert!(ROWS.iter().all(|row| (row.refused)(&choices).is_none()));
    }
}
