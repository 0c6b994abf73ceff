//! The acceleration structures, in the order of figures and texts.

/// Their names, with their colours in figures.
pub(crate) const STRUCTURES: [(&str, usize); 4] = [("grid", 0), ("irregular", 4), ("bvh", 1), ("none", 2)];

/// The structures without `none`, which tests every triangle.
pub(crate) fn accelerating() -> impl Iterator<Item = &'static str> {
    STRUCTURES.into_iter().map(|(name, _)| name).filter(|name| *name != "none")
}

/// The colour of a structure.
pub(crate) fn color(accelerator: &str) -> usize {
    STRUCTURES.iter().find(|(name, _)| *name == accelerator).map_or(2, |(_, color)| *color)
}
