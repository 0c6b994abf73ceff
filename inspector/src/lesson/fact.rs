//! The values that a text can show, by name.

/// Defines names with their descriptions.
macro_rules! table {
    ($(#[$about:meta])* $kind:ident $all:ident { $($name:ident $text:literal $summary:literal;)* }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $kind {
            $(#[doc = $summary] $name,)*
        }

        /// Every one, with its name and what it is.
        pub const $all: &[($kind, &str, &str)] = &[$(($kind::$name, $text, $summary)),*];
    };
}

table! {
    /// A value of the run, of the selected ray, of the row of its history that is current, of its light or candidates.
    Fact FACTS {
        Scene "scene" "name of the scene";
        Triangles "triangles" "triangles of the scene";
        Device "device" "name of the device";
        Rays "rays" "rays of the run";
        Passes "passes" "passes of the whole run";
        Pass "pass" "index of the last pass that ran";
        Kernel "kernel" "its kernel";
        Useful "useful" "rays that it worked on";
        Launched "launched" "threads that a GPU launches for it";
        Misses "misses" "rays that hit nothing";
        Cells "cells" "cells of the grid along x, y and z";
        RayPixel "ray.pixel" "pixel of the ray";
        RayPasses "ray.passes" "passes that work on the ray";
        RayTriangle "ray.triangle" "triangle that it hits";
        RayT "ray.t" "t of the hit";
        RayCells "ray.cells" "cells or nodes that it visits";
        RayTests "ray.tests" "triangles tested against it";
        RayRepeats "ray.repeats" "tests of a triangle that was tested before";
        RayLeaps "ray.leaps" "leaps over empty cells";
        RayLeapt "ray.leapt" "cells that it leaps over, without visiting them";
        RowPass "row.pass" "pass of the current row of the ray's history";
        RowKernel "row.kernel" "its kernel";
        RowCell "row.cell" "cell that it works in";
        RowWhy "row.why" "what happened, in words";
        RowTriangle "row.triangle" "triangle that it tests";
        RowListed "row.listed" "triangles in the list of its cell";
        RowT "row.t" "t at which the ray meets that triangle";
        RowExit "row.exit" "t at which the ray leaves the cell";
        RowAxis "row.axis" "axis of the plane through which it leaves, or beyond which the hit lies";
        RowHit "row.hit" "coordinate of the hit along that axis";
        RowPlane "row.plane" "coordinate of that plane";
        RowBeyond "row.beyond" "how far the hit lies beyond it: along the axis if the paper's rule refuses the hit, else in t";
        RowUlps "row.ulps" "the same, in units in the last place (f32) of the hit's largest coordinate, or of t";
        RowLeapt "row.leapt" "cells that this pass leaps over";
        LightAdds "light.adds" "what all vertices of the pixel's light tree add to it: linear light, the mean of r, g and b";
        LightRays "light.rays" "rays of the tree";
        LightShadows "light.shadows" "shadow rays among them";
        LightReached "light.reached" "those that reach their light";
        LightDepth "light.depth" "largest depth of a ray";
        LightMost "light.most" "percentage of it that comes from the vertex that adds the most";
        VertexName "vertex.name" "vertex of the light tree that the current row decides, or else belongs to";
        VertexSample "vertex.sample" "its sample of the pixel, from 1";
        VertexDepth "vertex.depth" "its depth";
        VertexAdds "vertex.adds" "what it adds to the pixel: linear light, the mean of r, g and b, divided by the number of samples";
        VertexArrives "vertex.arrives" "light that the ray to it brings to where it began";
        VertexThroughput "vertex.throughput" "share of that light that reaches the pixel: the throughput of the path there";
        VertexPdf "vertex.pdf" "pdf of the direction in which the path found it, per steradian";
        VertexLightPdf "vertex.light-pdf" "pdf by which the same point is found when a light is picked, per steradian";
        VertexWeight "vertex.weight" "weight of the light of a surface that glows: 1, or by both pdfs";
        StepFrom "step.from" "cell that the ray leaves in its next step from cell to cell, or in the one that the current row made";
        StepTo "step.to" "cell that this step enters";
        StepAxis "step.axis" "axis of the step";
        StepSign "step.sign" "its direction: +1 or -1";
        StepTMax "step.tmax" "tMax of that axis before the step";
        StepTMaxX "step.tmax.x" "tMax of x before the step";
        StepTMaxY "step.tmax.y" "tMax of y before the step";
        StepTMaxZ "step.tmax.z" "tMax of z before the step";
        StepNew "step.new" "tMax of that axis after the step";
        StepSum "step.sum" "tMax plus tDelta of that axis, in f32: what the paper's rule makes of it";
        StepChanged "step.changed" "axes whose tMax the step changes";
        StepTDelta "step.tdelta" "tDelta of that axis: the t between two of its planes";
        StepTDeltaX "step.tdelta.x" "tDelta of x";
        StepTDeltaY "step.tdelta.y" "tDelta of y";
        StepTDeltaZ "step.tdelta.z" "tDelta of z";
        StepWidth "step.width" "width of a cell along that axis";
        StepPlane "step.plane" "coordinate of the plane that the step crosses, from the grid's corner";
        StepOrigin "step.origin" "the ray's origin along that axis, from the grid's corner";
        StepDirection "step.direction" "the ray's direction along that axis";
        StepListed "step.listed" "triangles in the list of the new cell";
        TieCount "tie.count" "triangles that the ray may hit within the error of f32";
        TieHits "tie.hits" "how many of them the kernels' test in f32 hits";
        TieFirst "tie.first" "the one with the smallest index";
        TieFirstT "tie.first.t" "its t in f32";
        TieFirstExact "tie.first.t64" "its t in f64";
        TieFirstWeight "tie.first.weight" "its smallest barycentric weight in f64: below 0, the ray passes beside it";
        TieSecond "tie.second" "the next one";
        TieSecondT "tie.second.t" "its t in f32";
        TieSecondExact "tie.second.t64" "its t in f64";
        TieSecondWeight "tie.second.weight" "its smallest barycentric weight in f64";
        TieGap "tie.gap" "difference of the two t in f64";
        TieBound "tie.bound" "sum of the bounds on f32's error of both t";
        TieWeightBound "tie.weight-bound" "bound on f32's error of the weights";
    }
}

table! {
    /// A value of a measured run: `NAME.passes`, with the name that `measure` gave it.
    Field FIELDS {
        Passes "passes" "passes";
        Launched "launched" "threads that a GPU launches for all passes, or fragment programs that it runs";
        Useful "useful" "those that had a ray to work on";
        Draws "draws" "draws of kernels and of depths, if kernels are fragment programs";
        Copied "copied" "bytes of streams that are copied between draws";
        Share "share" "useful threads as a percentage of those launched";
        Misses "misses" "rays that hit nothing";
        Time "time" "time of all passes: by the device's clock, or the host's where that is not valid, and then it says so";
        DeviceTime "device-time" "the same by the device's clock only; an error where that is not valid";
    }
}

/// The name of a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Name {
    /// Of the run or the ray.
    Fact(Fact),
    /// Of a measured run.
    Measured(String, Field),
}

impl Fact {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        FACTS.iter().find(|(fact, ..)| *fact == self).map_or("?", |(_, name, _)| name)
    }
}

impl Name {
    /// Whether it is of the triangles that a ray may hit, see the command `candidates`.
    #[must_use]
    pub fn is_of_tie(&self) -> bool {
        matches!(self, Self::Fact(fact) if fact.name().starts_with("tie."))
    }

    /// The value of this name; `None` if there is none.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        if let Some((fact, ..)) = FACTS.iter().find(|(_, name, _)| *name == text) {
            return Some(Self::Fact(*fact));
        }
        let (of, field) = text.rsplit_once('.')?;
        let (field, ..) = FIELDS.iter().find(|(_, name, _)| *name == field)?;
        is_label(of).then(|| Self::Measured(of.to_owned(), *field))
    }
}

impl std::fmt::Display for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Fact(fact) => f.write_str(fact.name()),
            Self::Measured(of, field) => {
                let name = FIELDS.iter().find(|(other, ..)| other == field).map_or("?", |(_, name, _)| name);
                write!(f, "{of}.{name}")
            }
        }
    }
}

/// Whether a text can name a measurement: a lower-case letter, then letters, digits and hyphens.
#[must_use]
pub(super) fn is_label(text: &str) -> bool {
    let is_inner = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    text.starts_with(|c: char| c.is_ascii_lowercase()) && text.chars().all(is_inner) && !is_taken(text)
}

/// Whether a name would be confused with the first part of a fact.
fn is_taken(text: &str) -> bool {
    FACTS.iter().any(|(_, name, _)| name.split('.').next() == Some(text))
}

/// All names, for errors.
pub(super) fn names() -> String {
    let facts = FACTS.iter().map(|(_, name, _)| (*name).to_owned());
    facts.chain(FIELDS.iter().map(|(_, name, _)| format!("NAME.{name}"))).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for (fact, name, _) in FACTS {
            assert_eq!(Name::parse(name), Some(Name::Fact(*fact)));
            assert_eq!(fact.name(), *name);
        }
        for (field, name, _) in FIELDS {
            let text = format!("with-grid2.{name}");
            assert_eq!(Name::parse(&text), Some(Name::Measured("with-grid2".into(), *field)));
            assert_eq!(Name::parse(&text).map(|name| name.to_string()), Some(text));
        }
        for wrong in ["", "ray", "ray.", "ray.passes.time", "Grid.time", "grid.speed", ".time", "a b.time"] {
            assert_eq!(Name::parse(wrong), None, "{wrong}");
        }
    }
}
