//! What the lessons say, and what they set up.

use raystep_kernels::{Accelerator, GridSize, Numerics, ScheduleKind};

use super::{Do, LessonText, Step};
use crate::settings::{DeviceKind, Settings};
use crate::ui::command::Command;
use crate::ui::pane::PaneKind;

/// The Cornell box in its automatic grid.
fn in_grid() -> Settings {
    Settings { size: [256, 256], device: DeviceKind::Auto, ..Settings::default() }
}

/// As the paper launches it: every pass works on every ray.
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

/// A pixel whose ray sees the short block after passing through empty cells, and past a hit in a later cell.
const SEES_BLOCK: [u32; 2] = [96, 180];

/// A pixel whose ray runs along a face of the 20 × 20 × 20 grid.
const AT_FACE: [u32; 2] = [256, 4];

pub(super) const LESSONS: [LessonText; 3] = [
    LessonText {
        command: Command::LessonRay,
        title: "How one ray finds its triangle",
        steps: &[
            Step {
                text: "Every pixel has one ray, and a ray is a **texel**: its numbers lie at the same place in every \
                       stream. The first pass, `generate`, has just made all of them. The square in the picture is \
                       the ray that this lesson follows; the panel on the right has a row for every pass that \
                       works on it.",
                set_up: &[Do::Open(in_grid, SEES_BLOCK, 1)],
            },
            Step {
                text: "`setup` finds the **cell** of the grid in which the ray starts, and `tmax`: for each axis \
                       the t at which the ray leaves that cell. The smallest of the three says which face it will \
                       leave through.",
                set_up: &[Do::Go(2), Do::Show(PaneKind::Walk3d)],
            },
            Step {
                text: "The cell lists no triangle, so `intersect` has nothing to do: the state goes to `TRAV`. \
                       `traverse_grid` then takes the **smallest tmax**, steps one cell along that axis and moves \
                       this tmax one cell width on. Six empty cells go by like this. F11 goes from event to event.",
                set_up: &[Do::Go(14)],
            },
            Step {
                text: "Here the cell lists five triangles. `intersect` tests **one a pass**; why it misses is in the \
                       row: a barycentric coordinate is below 0.",
                set_up: &[Do::Go(17)],
            },
            Step {
                text: "Triangle 17 is hit, at t 0.812. But the ray leaves this cell at t 0.774: the hit lies **beyond \
                       the exit**, in another cell, where something nearer may be listed. The hit is kept, and the \
                       ray goes on.",
                set_up: &[Do::Go(35)],
            },
            Step {
                text: "In the next cell the list ends with t 0.812 still the nearest, and the exit is at 0.819: \
                       accepted. Note that triangle 17 was tested again: it lies in both cells. `mailboxing` would \
                       save that test.",
                set_up: &[Do::Go(45)],
            },
            Step {
                text: "`shade` colours the ray from its triangle, u and v. Click any other pixel, and read its life.",
                set_up: &[Do::End],
            },
        ],
    },
    LessonText {
        command: Command::LessonGrid,
        title: "Why the grid lost in 2004",
        steps: &[
            Step {
                text: "The paper's Table 3 is a surprise: **without** a grid, testing every triangle, the Cornell box \
                       was faster than with one. The run that you see is the paper's second schedule with a grid.",
                set_up: &[Do::Open(second, SEES_BLOCK, 0), Do::End, Do::Show(PaneKind::Timeline)],
            },
            Step {
                text: "The timeline has a column a pass: how many rays were in which state. A pass of 2004 drew a \
                       quad over the **whole image**: rays whose state was not the kernel's were discarded, but were \
                       launched and read all the same. Look at how few rays walk in the last third.",
                set_up: &[Do::Go(40)],
            },
            Step {
                text: "Rays also **diverge**: while some test triangles, others traverse, and a pass serves one kind. \
                       The cost panel shows how many of 32 neighbouring lanes had work in a pass.",
                set_up: &[Do::Show(PaneKind::Cost)],
            },
            Step {
                text: "Without a grid every ray does the same in every pass: 26 passes of `intersect`, all lanes \
                       busy until the end. A few triangles more per ray were cheaper than idle passes.",
                set_up: &[Do::Open(without, SEES_BLOCK, 0), Do::End],
            },
            Step {
                text: "What changed: the **compact** schedule launches only rays that have work, from lists that the \
                       kernels append to themselves, and takes several steps a pass. The same box, the same grid; \
                       compare the bars in the timings. `docs/performance.md` has the measurements.",
                set_up: &[Do::Open(in_grid, SEES_BLOCK, 0), Do::End, Do::Show(PaneKind::Timings)],
            },
        ],
    },
    LessonText {
        command: Command::LessonCrack,
        title: "A crack at a voxel face",
        steps: &[
            Step {
                text: "This is the Cornell box by the paper's rules in a grid of 20 × 20 × 20 cells. Look at the middle \
                       column: some rays there hit **nothing**, although the box is closed. Scroll into the picture.",
                set_up: &[Do::Open(cracked, AT_FACE, 0), Do::End],
            },
            Step {
                text: "Follow one of them. It runs along a **face** between two cells. The paper accepts a hit only \
                       if the hit point lies in the voxel that lists the triangle, and computes that point with \
                       rounding: the hit falls just outside of the cell in which it was found, and in the next cell \
                       just outside of that one.",
                set_up: &[Do::Show(PaneKind::Walk2d), Do::Events(1)],
            },
            Step {
                text: "The accumulated tMax is a second reason: adding tDelta again and again grows the rounding error \
                       with every step of the walk, so the cell that the ray is said to be in drifts from the one \
                       that it is in.",
                set_up: &[],
            },
            Step {
                text: "The robust rules keep the **nearest** hit whichever cell it lies in, accept it once t is not \
                       beyond the exit, compute each tMax from the cell's own plane, and grow every cell's list by the \
                       bound of what rounding can do. The same ray now hits.",
                set_up: &[Do::Open(mended, AT_FACE, 0), Do::End],
            },
            Step {
                text: "Set both side by side: run A by the robust rules, run B by the paper's (choose `paper` and the \
                       grid for B). `raystep stability` does this for 47 extreme cases.",
                set_up: &[Do::Perform(Command::Compare)],
            },
        ],
    },
];
