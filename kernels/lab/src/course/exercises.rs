//! The exercises, in the order of the course.

use super::files::{CRACK, file};
use super::hints;
use super::{Exercise, SCHEDULE, Source, Task, View};
use crate::subject::Size;

const CORNELL_BOX: Source = Source::Generated("cornell-box");
const SOUP: Source = Source::Generated("soup");
const BALL: Source = Source::Generated("icosphere");

const fn view(scene: Source, side: u32, why: &'static str) -> View {
    View { scene, camera: None, size: Size { width: side, height: side }, grid: None, why }
}

impl View {
    const fn from(self, eye: [f64; 3], target: [f64; 3], fov: f64) -> Self {
        Self { camera: Some((eye, target, fov)), ..self }
    }

    const fn grid(self, cells: &'static str) -> Self {
        Self { grid: Some(cells), ..self }
    }
}

/// As in the paper, from the open side of the box.
const BOX: View = view(CORNELL_BOX, 16, "the camera is inside the grid and looks along -z");
/// From its back.
const BOX_FROM_BEHIND: View = view(CORNELL_BOX, 16, "rays go towards larger x, y and z, and triangles are behind them")
    .from([-0.83, -0.71, -0.64], [0.9, 0.8, 2.6], 70.0);
/// With an odd number of pixels, so that rays are parallel to planes.
const BOX_STRAIGHT: View = view(
    CORNELL_BOX,
    15,
    "some rays are parallel to an axis: a component of their direction is 0",
)
.from([0.13, 0.07, 3.2], [0.13, 0.07, -1.0], 40.0);
const BALL_OUTSIDE: View = view(BALL, 20, "the camera is outside of the grid");

/// The ball's grid is the same along y and z, and so are the eye and the middle row of an odd number.
const BALL_DIAGONAL: View = view(
    BALL,
    15,
    "tMax of y and of z are equal, and that of x is larger, for the rays in the middle row",
)
.from([0.13, 0.0625, 0.0625], [0.13, 0.5625, 0.5625], 40.0);

/// All of them.
pub static EXERCISES: [Exercise; 8] = [
    Exercise {
        number: 1,
        name: "1-tmax",
        title: "tMax at the start",
        task: Task {
            kernel: "setup",
            hole: file!("1-tmax.wgsl").text,
            options: &[],
            views: &[BOX, BOX_FROM_BEHIND, BOX_STRAIGHT, BALL_OUTSIDE],
            may_round: false,
            is_watertight: false,
            hints: hints::TMAX,
        },
    },
    Exercise {
        number: 2,
        name: "2-step",
        title: "one step",
        task: Task {
            kernel: "traverse_grid",
            hole: file!("2-step.wgsl").text,
            options: &[("numerics", "paper")],
            views: &[
                BOX.grid("5"),
                BOX_FROM_BEHIND,
                BOX_STRAIGHT,
                view(SOUP, 16, "cells with many triangles, and rays in all directions").from(
                    [0.52, 0.47, 0.55],
                    [0.1, 0.9, 0.2],
                    90.0,
                ),
                BALL_DIAGONAL.grid("5"),
            ],
            may_round: false,
            is_watertight: false,
            hints: hints::STEP,
        },
    },
    Exercise {
        number: 3,
        name: "3-triangle",
        title: "the triangle test",
        task: Task {
            kernel: "intersect",
            hole: file!("3-triangle.wgsl").text,
            options: &[],
            views: &[
                BOX,
                view(SOUP, 20, "triangles from both sides, and some edge-on"),
                BOX_FROM_BEHIND.grid("2"),
                view(BALL, 20, "triangles from behind").from([0.2, 0.1, 0.3], [1.0, 0.4, 0.0], 80.0),
            ],
            may_round: true,
            is_watertight: false,
            hints: hints::TRIANGLE,
        },
    },
    Exercise {
        number: 4,
        name: "4-list-end",
        title: "the list's end",
        task: Task {
            kernel: "intersect",
            hole: file!("4-list-end.wgsl").text,
            options: &[],
            views: &[
                BOX,
                BOX_FROM_BEHIND.grid("5"),
                view(SOUP, 12, "cells whose triangles reach far beyond them").grid("6"),
                BALL_OUTSIDE,
            ],
            may_round: false,
            is_watertight: false,
            hints: hints::LIST_END,
        },
    },
    Exercise {
        number: 5,
        name: "5-schedule",
        title: "the second schedule",
        task: Task {
            kernel: SCHEDULE,
            hole: file!("5-schedule.toml").text,
            options: &[],
            views: &[
                BOX,
                BOX_FROM_BEHIND.grid("5"),
                view(SOUP, 12, "cells with lists of many lengths").grid("6"),
                BALL_OUTSIDE,
            ],
            may_round: false,
            is_watertight: false,
            hints: hints::SCHEDULE,
        },
    },
    Exercise {
        number: 6,
        name: "6-resolution",
        title: "a resolution",
        task: Task {
            kernel: "setup",
            hole: file!("6-resolution.wgsl").text,
            options: &[],
            views: &[
                BOX.grid("5"),
                view(CORNELL_BOX, 16, "other numbers of cells along each axis").grid("7,5,11"),
                BOX_FROM_BEHIND,
                BALL_OUTSIDE,
                view(SOUP, 16, "rays that enter the grid through its upper faces").from(
                    [2.6, 2.9, 2.3],
                    [0.5, 0.5, 0.5],
                    30.0,
                ),
                // Rounding puts about every tenth of their first points below 0.
                view(SOUP, 16, "rays that enter the grid through its lower faces").from(
                    [-1.6, -1.9, -1.3],
                    [0.5, 0.5, 0.5],
                    30.0,
                ),
            ],
            may_round: false,
            is_watertight: false,
            hints: hints::RESOLUTION,
        },
    },
    Exercise {
        number: 7,
        name: "7-crack",
        title: "a crack and its repair",
        task: Task {
            kernel: "intersect",
            hole: file!("7-crack.wgsl").text,
            options: &[],
            views: &[
                BOX,
                view(SOUP, 16, "triangles that share no edges"),
                view(Source::File(CRACK), 64, "a wall without gaps, and many rays that pass its edges").from(
                    [0.0; 3],
                    [0.0, 0.0, -1.0],
                    90.0,
                ),
                view(Source::File(CRACK), 24, "one edge of the wall, very much enlarged").from(
                    [0.0; 3],
                    [0.015625, 0.3, -1.0],
                    0.002,
                ),
                view(BALL, 16, "a closed ball from inside").from([0.0; 3], [0.0, 0.0, -1.0], 90.0),
            ],
            may_round: true,
            is_watertight: true,
            hints: hints::CRACK,
        },
    },
    Exercise {
        number: 8,
        name: "8-shadow",
        title: "a shadow ray",
        task: Task {
            kernel: "illuminate",
            hole: file!("8-shadow.wgsl").text,
            options: &[("integrator", "shadows")],
            views: &[
                view(CORNELL_BOX, 20, "one light, inside the scene"),
                view(SOUP, 14, "a light at a point, and one that is infinitely far away"),
                view(BALL, 20, "two lights, on different sides"),
            ],
            may_round: false,
            is_watertight: false,
            hints: hints::SHADOW,
        },
    },
];
