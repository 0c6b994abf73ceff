//! The light tree of a pixel, from its history.

pub use crate::program::light_tree::*;

use super::units::{Units, decimals};
use super::{Trace, TraceRow};
use crate::program::Program;
use crate::scene_data::SceneData;

impl LightTree {
    /// From a pixel's rows, as far as they go; `None` if the program casts no rays to lights with these options, if a kernel
    /// follows whole paths, or if no ray has begun.
    #[must_use]
    pub fn of(rows: &[TraceRow], program: &Program, data: &SceneData) -> Option<Self> {
        let rays = program.rays?;
        let grow = rays.tree.filter(|_| !data.features.whole_paths)?;
        let mut grower = Grower::new(data);
        let mut before = (rays.decode)(&|_| None);
        for (row, TraceRow { pass, after, .. }) in rows.iter().enumerate() {
            grower.go_to(Step { row, pass: *pass });
            grow(&mut grower, data, &before, after);
            before = *after;
        }
        grower.finish()
    }
}

/// A vertex in words and numbers, for tables.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// The vertex.
    pub vertex: usize,
    /// How deep in the tree it is.
    pub level: usize,
    /// Its name: `light 2`. Of several samples, a camera's has that of the sample.
    pub name: String,
    /// The passes from the one that cast its ray to the one that decided its fate.
    pub passes: String,
    /// Its point, or the direction in which it is infinitely far away.
    pub place: String,
    /// [`Vertex::arrives`]; empty without any.
    pub arrives: String,
    /// What it and everything below it adds to the pixel.
    pub adds: String,
    /// [`Vertex::why`].
    pub why: String,
}

impl LightTree {
    /// The vertices in [order](Self::in_order), in the units of a history.
    #[must_use]
    pub fn lines(&self, life: &Trace, units: Units) -> Vec<Line> {
        let largest = |values: &mut dyn Iterator<Item = f64>| decimals(values.map(f64::abs).fold(0.0, f64::max));
        let points = self.vertices.iter().filter_map(|vertex| point(vertex, life, units));
        let of_place = largest(&mut points.flatten()).saturating_sub(1);
        let brought = self.vertices.iter().filter_map(|vertex| vertex.arrives);
        let of_light = largest(&mut brought.flatten().map(f64::from)).clamp(5, 9) - 2;
        let branches = self.branches();
        let of_sum = largest(&mut branches.iter().flatten().copied()).clamp(5, 9) - 2;
        let three = |of: [f64; 3], digits: usize| of.map(|c| format!("{c:.digits$}")).join(" ");
        let line = |(i, level): (usize, usize)| {
            let vertex = &self.vertices[i];
            let name = match vertex.kind {
                VertexKind::Camera if self.samples > 1 => {
                    format!("camera, sample {} of {}", vertex.sample + 1, self.samples)
                }
                _ => vertex.name(),
            };
            Line {
                vertex: i,
                level,
                name,
                passes: vertex.passes(),
                place: match (vertex.place, point(vertex, life, units)) {
                    (Place::Direction(direction), _) => format!("direction {}", three(direction, 3)),
                    (_, Some(point)) => three(point, of_place),
                    (_, None) => String::new(),
                },
                arrives: vertex.arrives.map_or_else(String::new, |rgb| three(rgb.map(f64::from), of_light)),
                adds: three(branches[i], of_sum),
                why: vertex.why.clone(),
            }
        };
        self.in_order().into_iter().map(line).collect()
    }

    /// What the rays of a sample did, in a sentence.
    #[must_use]
    pub fn sentence(&self, sample: u32) -> String {
        /// More rays than this are counted.
        const MOST: usize = 8;
        let rays = self.vertices.iter().filter(|vertex| vertex.sample == sample && vertex.parent.is_some());
        let cast: Vec<&Vertex> = rays.filter(|vertex| vertex.fate != Fate::NotCast).collect();
        let to = |vertex: &Vertex| {
            let how = if vertex.is_sent_on() { format!("{} ", vertex.ray) } else { String::new() };
            format!("{how}to {}", vertex.object())
        };
        let told = cast.iter().take(MOST).map(|vertex| match vertex.fate {
            Fate::Occluded { triangle, .. } => format!("{}, occluded by triangle {triangle}", to(vertex)),
            Fate::Open => format!("{}, on its way", to(vertex)),
            Fate::Reached | Fate::NotCast => to(vertex),
        });
        let mut told: Vec<String> = told.collect();
        if let more @ 1.. = cast.len().saturating_sub(MOST) {
            told.push(format!("and {more} more"));
        }
        if told.is_empty() { "no ray has arrived".into() } else { format!("rays {}", told.join("; ")) }
    }
}

impl Vertex {
    /// The passes from the one that cast its ray to the one that decided its fate, in words.
    #[must_use]
    pub fn passes(&self) -> String {
        let text = |step: Step| step.pass.map_or_else(|| "last".into(), |pass| pass.to_string());
        match self.decided {
            None => format!("{}–", text(self.cast)),
            Some(decided) if decided.row == self.cast.row => text(decided),
            Some(decided) => format!("{}–{}", text(self.cast), text(decided)),
        }
    }
}

/// The point of a vertex, in the units of a history.
fn point(vertex: &Vertex, life: &Trace, units: Units) -> Option<[f64; 3]> {
    match (vertex.place, units) {
        (Place::Point(point), Units::Scene) => Some(point),
        (Place::Point(point), Units::Traced) => Some(life.traced(point)),
        (Place::Direction(_), _) => None,
    }
}

#[cfg(test)]
mod tests;
