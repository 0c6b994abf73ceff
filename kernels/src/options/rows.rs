//! Every option of a run that people choose, in one table: what reads an option from a command line, a link or a panel, or
//! writes it to one of them, reads its row here and names no option.

#[macro_use]
mod macros;

mod light;
mod photons;
mod sampling;

use super::keep::Keep;
use super::mapping::{Cull, Fragment, Mapping, MappingName, Targets, Until, Update, fault_of};
pub use super::row::{Refusal, Row, Value, Values};
use super::row::{parse, text, whole};
use super::scene_data::SceneDataKind;
use super::{
    Accelerator, BuiltBy, Choices, GridSize, MOST_ELEMENTS, Numerics, Order, ProgramName, ScheduleKind, Skip, Traversal,
};

/// Most steps of a ray in one pass.
pub const MOST_STEPS: u32 = 4096;

/// The row of a choice of the fragment mapping: `$implies` is what goes with it, unless it is chosen too.
macro_rules! fragment {
    ($name:literal, $type:ident, $field:ident, $implies:expr, $help:literal) => {
        Row::new(
            $name,
            Values::Names(names!($type)),
            |c| c.mapping.fragment().map_or(Value::Nothing, |how| text(how.$field)),
            |c, value| {
                let mut choice = $type::default();
                parse(value, &mut choice)?;
                if let Mapping::Fragment(how) = &mut c.mapping {
                    how.$field = choice;
                    let implies: fn(&mut Fragment) = $implies;
                    implies(how);
                }
                Ok(())
            },
            $help,
        )
        .applies(|c| c.mapping != Mapping::Compute)
        .refused(|c| {
            let Some(how) = c.mapping.fragment() else {
                let why = concat!("--", $name, " is for fragment programs: omit it, or add --mapping fragment");
                return Some(Refusal::Idle(why.into()));
            };
            how.fault().filter(|_| how.faulty() == $name).map(impossible)
        })
        .in_tables(None)
    };
}

/// Every option, in the order in which they are read: a later one may change what goes with an earlier one.
pub static ROWS: &[Row] = &[
    named!(
        "program",
        ProgramName,
        program,
        "The stream program: trace rays (closest-hit), or build the grid that they would be traced through, uniform or \
         irregular (grid-build), or sort keys (sort)"
    )
    .in_tables(None),
    whole!("elements", 1, MOST_ELEMENTS, elements, "How many elements a program without a scene works on: of sort, keys").in_tables(None),
    light::INTEGRATOR,
    light::MAX_DEPTH,
    light::STRATEGY,
    light::ENVIRONMENT,
    photons::PHOTONS,
    photons::SORT,
    photons::NEIGHBOURS,
    photons::GATHER,
    photons::NEAREST,
    photons::RADIUS,
    named!(
        "accelerator",
        Accelerator,
        accelerator,
        "Acceleration structure: a uniform grid (grid), an irregular grid with cells of many sizes (irregular), a \
         bounding volume hierarchy (bvh), none, or auto, the fastest as measured: none for up to six triangles, on a GPU \
         the grid if triangles fill the scene evenly, otherwise the BVH"
    )
    .column()
    .panel("accelerator", "acceleration structure")
    .refused(|c| {
        let has_no_rules = c.accelerator == Accelerator::Irregular && c.numerics == Numerics::Paper;
        has_no_rules.then(|| {
            impossible(
                "--accelerator irregular: the paper has no rules for it; use --numerics robust, or --accelerator grid",
            )
        })
    }),
    Row::new(
        "mapping",
        Values::Names(names!(MappingName)),
        |c| text(c.mapping.name()),
        |c, value| {
            let mut name = MappingName::default();
            parse(value, &mut name)?;
            c.mapping = match name {
                MappingName::Compute => Mapping::Compute,
                MappingName::Fragment => Mapping::Fragment(Fragment::default()),
            };
            if name == MappingName::Fragment && fault_of(c.schedule).is_some() {
                c.schedule = ScheduleKind::Second;
            }
            Ok(())
        },
        "How kernels run on a GPU: as compute shaders (compute), or as fragment programs that draw into streams, as on \
         GPUs before 2006 (fragment); fragment takes --schedule second or first",
    )
    .panel(
        "mapping",
        "how kernels run: as compute shaders, or as fragment programs that draw into streams, as on GPUs before 2006",
    )
    .column()
    .in_tables(Some(|c| text(c.mapping)))
    .refused(|c| {
        let is_drawn = c.mapping != Mapping::Compute && c.program != ProgramName::ClosestHit;
        is_drawn.then(|| impossible("--mapping fragment traces rays: no other program can be drawn"))
    }),
    fragment!(
        "targets",
        Targets,
        targets,
        |_| {},
        "Streams that a draw writes: one, so that a kernel is drawn once for each of its outputs, or as many as the \
         adapter allows (many) [default: one]"
    )
    .panel("targets", "streams that a draw writes"),
    fragment!(
        "update",
        Update,
        update,
        |how| {
            if how.update == Update::Swap {
                (how.cull, how.until) = (Cull::None, Until::Count);
            }
        },
        "How a kernel reads a stream that it also writes: from a copy made before (copy), or from one of two textures \
         that take turns (swap) [default: copy]"
    )
    .panel("update", "how a kernel reads a stream that it also writes"),
    fragment!(
        "cull",
        Cull,
        cull,
        |how| {
            if how.cull == Cull::None {
                how.until = Until::Count;
            }
        },
        "How a kernel avoids rays in other states: not at all, so that every fragment runs and writes (none); each \
         fragment runs, and discards itself (discard); or a depth test excludes it first (early-z) [default: discard; \
         none with --update swap]"
    )
    .panel("cull", "how a kernel avoids rays in other states"),
    fragment!(
        "until",
        Until,
        until,
        |_| {},
        "What ends the loops of the schedule: occlusion queries (query), or the numbers of rays in each state, counted \
         by a compute shader (count) [default: query; count with --cull none]"
    )
    .panel("until", "what ends the loops of the schedule"),
    named!(
        "scene-data",
        SceneDataKind,
        scene_data,
        "Where kernels on a GPU read the lists of a scene: in storage buffers (buffers), or in square textures, as in \
         Mølhave's paper (textures); with --mapping fragment, kernels then need no storage buffer, and run on OpenGL ES 3"
    )
    .column()
    .panel("scene data", "where kernels read the lists of a scene: in storage buffers, or in textures as in the paper"),
    named!(
        "schedule",
        ScheduleKind,
        schedule,
        "How the walk of a ray is divided into passes: intersect until no ray is active there, then traverse once \
         (first); intersect and traverse alternately (second); several steps per pass, for active rays only (compact); \
         the whole walk in one pass, and with --integrator path the whole path (fused)"
    )
    .column()
    .panel("schedule", "the order in which kernels run")
    .refused(|c| c.mapping.fragment().and(fault_of(c.schedule)).map(impossible)),
    named!(
        "numerics",
        Numerics,
        numerics,
        "Numerical rules: robust (no missed or wrong hit, except where f32 cannot decide between two triangles), or \
         those of Mølhave's paper (paper), for comparison; with a grid, the paper's can lose rays that start outside it"
    )
    .column()
    .panel("numerics", "the rules for planes, steps and hits"),
    named!(
        "order",
        Order,
        order,
        "Which of several hits is the nearest: by t as f32 has it (rounded), or by exact t (exact), so that a ray hits the \
         same triangle whatever the structure, schedule and device; integers decide what rounding leaves open, which \
         takes longer on a GPU"
    )
    .panel("order", "which of several hits is the nearest: by t as f32 has it, or by exact t")
    .applies(|c| c.program == ProgramName::ClosestHit)
    .refused(|c| {
        if c.order == Order::Exact && c.program != ProgramName::ClosestHit {
            return Some(Refusal::Idle("--order is for rays: omit it, or use --program closest-hit".into()));
        }
        c.order.fault(c.numerics, c.mapping).map(|why| impossible(&format!("--order exact: {why}")))
    }),
    named!(
        "traversal",
        Traversal,
        traversal,
        "How rays walk through a uniform grid with --numerics paper: by the smallest tMax (amanatides-woo), or by \
         control terms along a driving axis, the walk of Fujimoto, Tanaka and Iwata (3d-dda)"
    )
    .column()
    .panel(
        "traversal",
        "how rays walk through the grid: by the smallest tMax, or by control terms along a driving axis",
    )
    .applies(can_choose_traversal)
    .refused(|c| {
        let has_none = c.traversal == Traversal::Dda3d && !can_choose_traversal(c);
        has_none.then(|| impossible(
                "--traversal 3d-dda walks through a uniform grid with the paper's rules: add --accelerator grid --numerics \
                 paper",
            ))
    }),
    Row::new(
        "grid",
        Values::Cells,
        |c| Value::Text(c.grid.to_string()),
        |c, value| value.parse().map(|grid| c.grid = grid),
        "Number of grid cells along each axis, or along x, y and z; auto chooses it, and gives cells that list very \
         many triangles a finer grid each, unless --skip is on or off [default: auto]",
    )
    .panel("cells", "cells of the grid along x, y and z")
    .applies(has_grid)
    .refused(|c| if c.grid == GridSize::Auto { None } else { idle_without_grid("--grid", c) }),
    named!(
        "skip",
        Skip,
        skip,
        "Skip over empty cells of the grid: if most cells are empty (auto), always (on) or never (off)"
    )
    .panel("skip empty space", "whether rays skip over empty cells")
    .applies(has_grid)
    .refused(|c| match (c.skip, c.numerics) {
        (Skip::On, Numerics::Paper) if has_grid(c) => {
            Some(Refusal::Idle("--skip on: the paper's rules visit every cell; use --numerics robust".into()))
        }
        (Skip::On, _) => idle_without_grid("--skip on", c),
        _ => None,
    }),
    whole!(
        "steps-per-pass",
        1,
        MOST_STEPS,
        steps_per_pass,
        "Maximum steps per ray and pass with schedule compact [default: 8; for trace and dump 1, as in the paper]"
    )
    .panel("steps per pass", "1 shows one cell, node or triangle per pass")
    .applies(|c| c.schedule == ScheduleKind::Compact)
    .in_tables(Some(|c| match c.schedule {
        ScheduleKind::Compact => Value::Number(c.steps_per_pass),
        ScheduleKind::First | ScheduleKind::Second => Value::Number(1),
        ScheduleKind::Fused => Value::Nothing,
    }))
    .refused(|c| {
        let (steps, schedule) = (c.steps_per_pass, c.schedule);
        (steps > 1 && schedule != ScheduleKind::Compact).then(|| {
            Refusal::Idle(format!(
                "--steps-per-pass {steps} applies to schedule compact, not to {schedule}: omit it, or use --schedule \
                 compact"
            ))
        })
    }),
    named!(
        "build",
        BuiltBy,
        build,
        "Where to build the grid (--accelerator grid or irregular): on the host, or on the device that traces the rays; \
         the result is the same. auto uses a GPU for irregular grids of at least 200,000 triangles, otherwise the host"
    )
    .in_tables(None)
    .refused(|c| {
        let has_none = !matches!(c.accelerator, Accelerator::Grid | Accelerator::Irregular);
        (c.build == BuiltBy::Device && has_none)
            .then(|| Refusal::Idle("--build device builds grids: use --accelerator grid or irregular".into()))
    })
    // Whoever builds it, the grid is the same.
    .unlinked(),
    Row::new(
        "keep-all",
        Values::Switch,
        |c| Value::Flag(c.keep == Keep::ALL),
        |c, value| {
            c.keep = Keep::all_if(value.parse().map_err(|_| "expected true or false")?);
            Ok(())
        },
        "Include everything in the plan, to measure what omitting saves",
    )
    .panel(
        "keep what is not needed",
        "also run kernels and keep streams that the result does not need, as --keep-all does",
    ),
    sampling::SPP,
    sampling::SAMPLER,
    sampling::SEED,
];

impl Row {
    /// The row of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        ROWS.iter().find(|row| row.name == name || row.alias == Some(name))
    }
}

/// Serializes options as members of an object.
///
/// # Errors
/// If the serializer fails.
#[cfg(feature = "serde")]
pub fn serialize<S: serde::Serializer>(choices: &Choices, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(ROWS.iter().filter_map(|row| Some((row.key(), row.recorded(choices)?))))
}

/// Serializes those that are columns of `passes.csv`.
///
/// # Errors
/// If the serializer fails.
#[cfg(feature = "serde")]
pub fn serialize_columns<S: serde::Serializer>(choices: &Choices, serializer: S) -> Result<S::Ok, S::Error> {
    let columns = ROWS.iter().filter(|row| row.is_column);
    serializer.collect_map(columns.filter_map(|row| Some((row.key(), row.recorded(choices)?))))
}

fn impossible(why: &str) -> Refusal {
    Refusal::Impossible(why.into())
}

fn has_grid(c: &Choices) -> bool {
    c.accelerator == Accelerator::Grid
}

fn can_choose_traversal(c: &Choices) -> bool {
    has_grid(c) && c.numerics == Numerics::Paper
}

/// An option of a uniform grid, where there is none.
fn idle_without_grid(option: &str, c: &Choices) -> Option<Refusal> {
    let why = match c.accelerator {
        Accelerator::Grid => return None,
        Accelerator::Auto => "accelerator auto chooses its own".to_owned(),
        other => format!("accelerator {other} has no such grid"),
    };
    let why = format!("{option} applies to a uniform grid, and {why}: omit it, or use --accelerator grid");
    Some(Refusal::Idle(why))
}

#[cfg(test)]
mod tests;
