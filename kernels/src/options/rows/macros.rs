//! Rows of options of the usual kinds.

/// The names of a type's values.
macro_rules! names {
    ($type:ident) => {
        || $type::ALL.iter().map(|value| value.name()).collect()
    };
}

/// The row of an option whose values have names.
macro_rules! named {
    ($name:literal, $type:ident, $($field:ident).+, $help:literal) => {
        Row::new(
            $name,
            Values::Names(names!($type)),
            |c| text(c.$($field).+),
            |c, value| parse(value, &mut c.$($field).+),
            $help,
        )
    };
}

/// The row of an option that is an integer.
macro_rules! whole {
    ($name:literal, $least:expr, $most:expr, $($field:ident).+, $help:literal) => {
        Row::new(
            $name,
            Values::Whole($least, $most),
            |c| Value::Number(c.$($field).+),
            |c, value| whole(value, $least, $most).map(|number| c.$($field).+ = number),
            $help,
        )
    };
}
