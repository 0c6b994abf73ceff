//! The inspector's data and its window.

mod data;
mod ui;
