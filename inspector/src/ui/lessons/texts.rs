//! The texts of the lessons, and what their steps set up.

use raystep_kernels::{Accelerator, GridSize, Numerics, ScheduleKind};

use super::{Do, LessonText, Step};
use crate::settings::{DeviceKind, Settings};
use crate::ui::command::Command;
use crate::ui::pane::PaneKind;

/// The Cornell box in its automatic grid.
fn in_grid() -> Settings {
    Settings { size: [256, 256], device: DeviceKind::Auto, ..Settings::default() }
}

/// As in the paper: every pass launches every ray.
fn second() -> Settings {
    Settings { schedule: ScheduleKind::Second, ..in_grid() }
}

/// The paper's Table 3.
fn without() -> Settings {
    Settings { accelerator: Accelerator::None, ..second() }
}

fn cracked() -> Settings {
    Settings { size: [512, 512], grid: GridSize::Cells([20; 3]), numerics: Numerics::Paper, ..in_grid() }
}

fn mended() -> Settings {
    Settings { numerics: Numerics::Robust, ..cracked() }
}

/// A pixel whose ray crosses empty cells, finds a hit beyond its current cell, and accepts it in the next: the short block.
const SEES_BLOCK: [u32; 2] = [96, 180];

/// A pixel whose ray runs along a face of the 20 × 20 × 20 grid.
const AT_FACE: [u32; 2] = [256, 4];

pub(super) const LESSONS: [LessonText; 3] = [
    LessonText {
        command: Command::LessonRay,
        title: "How one ray finds its triangle",
        steps: &[
            Step {
                text: "Every pixel has one ray, and every ray is a **texel**: its values are stored at the same \
                       position in every stream. The first pass, `generate`, has just created all rays. The square in \
                       the picture marks the ray that this lesson follows; the panel on the right has one row for \
                       every pass that processes it.",
                set_up: &[Do::Open(in_grid, SEES_BLOCK, 1)],
            },
            Step {
                text: "`setup` finds the **cell** of the grid in which the ray starts, and `tmax`: for each axis, the \
                       t at which the ray leaves that cell. The smallest of the three determines the face through \
                       which it leaves.",
                set_up: &[Do::Go(2), Do::Show(PaneKind::Walk3d)],
            },
            Step {
                text: "The cell lists no triangle, so `intersect` has nothing to do and sets the state to `TRAV`. \
                       `traverse_grid` then takes the **smallest tmax**, steps one cell along that axis and increases \
                       this tmax by one cell width. The ray crosses six empty cells in this way. F11 goes from event \
                       to event.",
                set_up: &[Do::Go(14)],
            },
            Step {
                text: "This cell lists five triangles. `intersect` tests **one per pass**; the row shows why the ray \
                       misses: a barycentric coordinate is below 0.",
                set_up: &[Do::Go(17)],
            },
            Step {
                text: "Triangle 17 is hit at t 0.812. But the ray leaves this cell at t 0.774, so the hit lies \
                       **beyond the exit**, in another cell, which may list a nearer triangle. The hit is kept, and \
                       the ray continues.",
                set_up: &[Do::Go(35)],
            },
            Step {
                text: "At the end of the next cell's list, t 0.812 is still the nearest hit, and the exit is at 0.819: \
                       the hit is accepted. Triangle 17 was tested twice, because both cells list it. `mailboxing` \
                       would avoid the second test.",
                set_up: &[Do::Go(45)],
            },
            Step {
                text: "`shade` computes the colour from the triangle, u and v. Click another pixel to see its ray's \
                       history.",
                set_up: &[Do::End],
            },
        ],
    },
    LessonText {
        command: Command::LessonGrid,
        title: "Why the grid lost in 2004",
        steps: &[
            Step {
                text: "The paper's Table 3 is surprising: the Cornell box was faster **without** a grid, testing every \
                       triangle, than with one. This run uses the paper's second schedule with a grid.",
                set_up: &[Do::Open(second, SEES_BLOCK, 0), Do::End, Do::Show(PaneKind::Timeline)],
            },
            Step {
                text: "The timeline has one column per pass, which shows how many rays were in each state. In 2004, a \
                       pass drew a quad over the **whole image**: rays in another kernel's state were discarded, but \
                       they were launched and their state was read all the same. Note how few rays are active in the \
                       last third.",
                set_up: &[Do::Go(40)],
            },
            Step {
                text: "Rays also **diverge**: some test triangles while others traverse, and a pass serves only one \
                       kind. The cost panel shows how many of 32 neighbouring lanes had work in a pass.",
                set_up: &[Do::Show(PaneKind::Cost)],
            },
            Step {
                text: "Without a grid, every ray does the same thing in every pass: 26 passes of `intersect`, with all \
                       lanes busy until the end. A few more triangle tests per ray were cheaper than idle threads.",
                set_up: &[Do::Open(without, SEES_BLOCK, 0), Do::End],
            },
            Step {
                text: "The **compact** schedule changes this: it launches only rays that have work, from lists that \
                       the kernels themselves append to, and takes several steps per pass. The scene and the grid are \
                       the same; compare the bars in the timings. `docs/performance.md` has measurements.",
                set_up: &[Do::Open(in_grid, SEES_BLOCK, 0), Do::End, Do::Show(PaneKind::Timings)],
            },
        ],
    },
    LessonText {
        command: Command::LessonCrack,
        title: "A crack at a voxel face",
        steps: &[
            Step {
                text: "This is the Cornell box with the paper's numerics in a grid of 20 × 20 × 20 cells. In the \
                       middle column, some rays hit **nothing**, although the box is closed. Zoom in to see them.",
                set_up: &[Do::Open(cracked, AT_FACE, 0), Do::End],
            },
            Step {
                text: "Follow one of them. It runs along a **face** between two cells. The paper accepts a hit only if \
                       the hit point lies in the voxel that lists the triangle, and the computed point is rounded: it \
                       falls just outside the cell in which it was found, and in the next cell just outside that one.",
                set_up: &[Do::Show(PaneKind::Walk2d), Do::Events(1)],
            },
            Step {
                text: "A second cause is the accumulated tMax: with every addition of tDelta the rounding error grows, \
                       so that the cell that the ray is assumed to be in drifts away from its true cell.",
                set_up: &[],
            },
            Step {
                text: "Robust numerics keep the **nearest** hit in whichever cell it lies, accept it once t is not \
                       beyond the exit, compute each tMax from the cell's own plane, and grow every cell by a bound on \
                       the rounding error before its list is made. The same ray now hits.",
                set_up: &[Do::Open(mended, AT_FACE, 0), Do::End],
            },
            Step {
                text: "Compare both: run A with robust numerics, run B with the paper's (choose `paper` and the grid \
                       for B). `raystep stability` does this for 47 extreme cases.",
                set_up: &[Do::Perform(Command::Compare)],
            },
        ],
    },
];
