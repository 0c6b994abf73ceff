//! Columns of options.

use std::sync::LazyLock;

use raystep_kernels::options::rows::{ROWS, Row, Values};

use super::{Column, Kind};

/// Options that are columns of `passes.csv`, by their rows.
pub(super) static OF_OPTIONS: LazyLock<Vec<Column>> = LazyLock::new(|| {
    let column = |row: &Row| {
        let kind = match row.values {
            Values::Names(_) | Values::Cells => Kind::Text,
            Values::Whole(..) => Kind::Integer,
            Values::Switch => Kind::Boolean,
        };
        // Made once, for as long as the program runs.
        Column { name: row.key().leak(), kind, what: row.help }
    };
    ROWS.iter().filter(|row| row.is_column).map(column).collect()
});
