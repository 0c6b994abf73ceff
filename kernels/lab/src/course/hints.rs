//! What a student could look at, by what differs. The first that fits is told: none of them says what to write.

use raystep_kernels::shared::constants::INF;

use super::Hint;
use crate::check_kernel::Difference;

/// Where a hint is that is about the number of passes.
pub(super) const SLOW: &str = "slow";
/// Where a hint is that is about rays that are not done.
pub(super) const FAILS: &str = "fails";
/// Where a hint is that is about rays between triangles.
pub(super) const LEAK: &str = "leak";

const fn at(at: &'static str, text: &'static str) -> Hint {
    Hint { at, when: |_| true, text }
}

const fn if_(at: &'static str, when: fn(&Difference) -> bool, text: &'static str) -> Hint {
    Hint { at, when, text }
}

impl Hint {
    /// Whether it is about this difference.
    pub(super) fn fits(&self, difference: &Difference) -> bool {
        let place = format!("{}.{}", difference.stream, difference.layer);
        let is_there = self.at.is_empty() || self.at == difference.stream || self.at == place;
        is_there && (self.when)(difference)
    }
}

/// The value and what was expected, if both are numbers.
fn numbers(difference: &Difference) -> Option<[f64; 2]> {
    // `parse` would take the constant for an infinity.
    let number = |text: &str| match text {
        "INF" => Some(f64::from(INF)),
        "-INF" => Some(-f64::from(INF)),
        text => text.parse().ok(),
    };
    Some([number(&difference.value)?, number(&difference.expected)?])
}

/// Far more than any t of a scene, as INF is.
const FAR: f64 = 1e30;

fn is_not_finite(d: &Difference) -> bool {
    numbers(d).is_some_and(|[value, _]| !value.is_finite())
}

fn is_far(d: &Difference) -> bool {
    numbers(d).is_some_and(|[value, expected]| value >= FAR && expected < FAR)
}

fn is_expected_far(d: &Difference) -> bool {
    numbers(d).is_some_and(|[value, expected]| value < FAR && expected >= FAR)
}

fn is_too_small(d: &Difference) -> bool {
    numbers(d).is_some_and(|[value, expected]| value < expected)
}

fn is_negative(d: &Difference) -> bool {
    numbers(d).is_some_and(|[value, expected]| value < 0.0 && expected >= 0.0)
}

fn is_zero(d: &Difference) -> bool {
    numbers(d).is_some_and(|[value, expected]| value == 0.0 && expected != 0.0)
}

/// Nearly right, as from another point of the same surface.
fn is_close(d: &Difference) -> bool {
    numbers(d).is_some_and(|[value, expected]| (value - expected).abs() <= 1e-3 * (1.0 + expected.abs()))
}

/// Whether another value of this ray differs, too: of this stream, or this layer of it.
fn and(d: &Difference, also: &str) -> bool {
    d.also.iter().any(|name| name == also || name.split_once('.').is_some_and(|(stream, _)| stream == also))
}

/// Of an index.
fn is_neighbour(d: &Difference) -> bool {
    d.cells.is_some_and(|[value, expected]| (0..3).map(|axis| value[axis].abs_diff(expected[axis])).sum::<u32>() == 1)
}

/// Of a state.
fn is_expected(d: &Difference, state: &str) -> bool {
    d.expected == state
}

pub(super) const TMAX: &[Hint] = &[
    if_(
        "tmax",
        is_not_finite,
        "What is a division by 0? The page says what tMax is along an axis that the ray never goes along.",
    ),
    if_("tmax", is_expected_far, "The ray does not go along this axis at all. When does it cross a plane there?"),
    if_("tmax", is_far, "The ray goes along this axis, so it does cross a plane. INF is only for a ray that does not."),
    if_(
        "tmax",
        is_negative,
        "A negative t is behind the ray. Which of the cell's two faces is ahead, if the ray goes towards smaller coordinates?",
    ),
    at(
        "tmax",
        "Which plane of this axis is ahead of the ray, and how many times the direction is it away? Compute one ray by hand.",
    ),
    at("", "Only first_tmax is to be written: is the rest of the file as it was?"),
];

pub(super) const STEP: &[Hint] = &[
    at(
        "state.cell",
        "The ray goes to another cell. Along which axis does it cross a plane first, and where does it go where two are equal?",
    ),
    if_("tmax", is_not_finite, "Along an axis that the ray does not go along, tMax stays as it is."),
    if_(
        "tmax",
        is_too_small,
        "tMax of the axis that is crossed has to grow: by how much is the next plane further away?",
    ),
    at("tmax", "Only one component of tMax changes in a step. Which one, and by how much?"),
    at("state.tag", "The ray leaves the grid too early or too late: it has gone to another cell than expected."),
    at("", "Only next_step is to be written: is the rest of the file as it was?"),
];

pub(super) const TRIANGLE: &[Hint] = &[
    if_("hit.u", is_zero, "u is the weight of corner b. Where in the triangle is the point?"),
    at(
        "hit.u",
        "u is the weight of corner b, v that of corner c: are they exchanged, or one of them divided by something else?",
    ),
    at("hit.v", "v is the weight of corner c: how much of the edge from a to c is in the vector from a to the point?"),
    if_("state.t", is_negative, "A triangle behind the origin is no hit."),
    if_(
        "state.t",
        |d| and(d, "hit.triangle") && numbers(d).is_some_and(|[value, expected]| value < FAR && value > expected),
        "The ray hits a nearer triangle, and your test says that it misses this one, or that it is farther away. Is it seen from behind? Both sides count.",
    ),
    if_(
        "state.t",
        |d| and(d, "hit.triangle") && is_too_small(d),
        "Your test says that the ray hits a triangle which it does not hit. Which of the conditions is missing?",
    ),
    if_(
        "state.t",
        is_far,
        "The ray hits this triangle, and your test says that it does not. Is it seen from behind? Both sides count.",
    ),
    at("state.t", "t is in multiples of the direction vector, whose length is not 1."),
    if_(
        "state.tag",
        |d| is_expected(d, "ISECT_NO_HIT") || is_expected(d, "TRAV"),
        "The ray passes beside this triangle, or the triangle is behind it, and your test says that it hits. Which of the conditions is missing?",
    ),
    at(
        "state.tag",
        "The ray hits this triangle, and your test says that it does not. Is it seen from behind? Both sides count.",
    ),
    at(
        "",
        "Another triangle is hit than expected. Which conditions make a point of the plane a point of the triangle?",
    ),
];

pub(super) const LIST_END: &[Hint] = &[
    if_(
        "state.tag",
        |d| is_expected(d, "TRAV") && d.value == "SHADE",
        "The hit lies beyond this cell: its t is larger than the t at which the ray leaves the cell. What if a cell in between lists a nearer triangle?",
    ),
    if_(
        "state.tag",
        |d| is_expected(d, "TRAV"),
        "Nothing is decided yet: the next cell may list a triangle that the ray hits.",
    ),
    if_(
        "state.tag",
        |d| is_expected(d, "SHADE"),
        "The ray leaves this cell behind its hit, so no cell further on can have a nearer one. Where does it leave the cell: at which of the three tMax?",
    ),
    at("", "Only list_ended is to be written: is the rest of the file as it was?"),
];

pub(super) const RESOLUTION: &[Hint] = &[
    if_(
        "state.cell",
        |d| !and(d, "tmax"),
        "tMax is right, so your cell_of finds the cell, and your index_of gives it another index. How long is a row, and how many cells has a layer?",
    ),
    if_(
        "state.cell",
        |d| d.cells.is_none(),
        "tMax differs, too, so your cell_of finds another cell. The grid has no cell with this index: where is a point on a face of the grid, or beyond it by a rounding error?",
    ),
    if_(
        "state.cell",
        is_neighbour,
        "tMax differs, too, so your cell_of finds another cell, a neighbour: is the point's place, in cells, rounded down? And where is a point on the upper face of the grid?",
    ),
    at(
        "state.cell",
        "tMax differs, too, so your cell_of finds another cell: along each axis, a cell's width is the grid's size there divided by its number of cells there.",
    ),
    at("tmax", "tMax follows from the cell: your cell_of finds another one, along this axis."),
    at("", "Only cell_of and index_of are to be written: is the rest of the file as it was?"),
];

pub(super) const CRACK: &[Hint] = &[
    at(
        LEAK,
        "This ray passes near an edge that two triangles share, or through it exactly: what is the weight then? Each triangle says that it passes on the other side. Both should compute the same number from the edge: in which order, and from which corners?",
    ),
    at(
        "hit.u",
        "A weight belongs to the corner that is opposite of its edge: u to b, v to c. By their sum they are 1.",
    ),
    at(
        "hit.v",
        "A weight belongs to the corner that is opposite of its edge: u to b, v to c. By their sum they are 1.",
    ),
    if_(
        "state.tag",
        |d| is_expected(d, "ISECT_NO_HIT") || is_expected(d, "TRAV"),
        "The ray passes beside this triangle, by more than rounding can be wrong. A tolerance makes triangles larger; it does not close cracks.",
    ),
    at(
        "state.tag",
        "The ray hits this triangle, and your test says that it does not. Triangles are seen from both sides: all three weights may be negative.",
    ),
    at(
        "state.t",
        "The ray hits this triangle at another t, or not at all. Do the weights still have the right signs and proportions?",
    ),
    at("", "Another triangle is hit than expected, and rounding cannot be the reason."),
];

pub(super) const SHADOW: &[Hint] = &[
    if_(
        "state.t",
        |d| is_close(d) && and(d, "shadow_direction"),
        "The direction differs, too, and the end follows from it. From which point does the direction lead to the light, and how long is it?",
    ),
    if_("state.t", is_far, "A surface behind the light keeps nothing off. At which t is the light?"),
    if_("state.t", is_expected_far, "This light is infinitely far away: the ray has no end."),
    at("state.t", "The ray ends just before the light, in multiples of its direction: what is t at the light?"),
    if_(
        "shadow_direction",
        is_close,
        "The direction is nearly right: it leads to the light from the origin of the shadow ray, which is not start.point.",
    ),
    at(
        "shadow_direction",
        "From the surface to the light, not the other way, and for each kind of light: one has a position, the other only a direction in which its light travels.",
    ),
    at("shadow_origin", "The ray begins at the surface, off it by the error of rounding: start and leaving have that."),
    at(
        "state.tag",
        "Is the ray cast where the light is on the side from which the surface is seen, and only there? Where does its direction lead?",
    ),
    at(
        "light",
        "Is the ray cast where the light is on the side from which the surface is seen, and only there? Where does its direction lead?",
    ),
    at(
        "color",
        "Is the ray cast where the light is on the side from which the surface is seen, and only there? Where does its direction lead?",
    ),
    at("", "Only shadow_ray is to be written: is the rest of the file as it was?"),
];

/// Of exercise 5.
pub(super) const SCHEDULE: &[Hint] = &[
    at(SLOW, "Rays wait for another one that tests a long list: who could go on meanwhile?"),
    at(FAILS, "Rays are left on their way: as long as there are any, which kernels do they wait for?"),
];
