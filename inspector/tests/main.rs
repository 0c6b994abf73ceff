//! Tests of the inspector's data and of its window.

mod data;
mod ui;
