//! Configurations in which a scene can be traced, for comparisons and tests.

use std::fmt;

use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{
    Accelerator, Item, Keep, Numerics, Options, Plan, Ray, RaySource, Rule, ScheduleKind, Skip, Traversal,
};
use raystep_scenes::Scene;

/// A configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Way {
    /// The acceleration structure.
    pub accelerator: Accelerator,
    /// The schedule.
    pub schedule: ScheduleKind,
    /// Most steps of a ray in one pass of the compact schedule.
    pub steps: u32,
    /// Whether rays skip empty cells.
    pub skip: Skip,
    /// The numerics.
    pub numerics: Numerics,
    /// How rays walk through a uniform grid.
    pub traversal: Traversal,
    /// Whether boxes are grown for each ray in any scene.
    pub is_padded: bool,
}

impl Way {
    /// Robust numerics, without empty-space skipping.
    #[must_use]
    pub const fn new(accelerator: Accelerator, schedule: ScheduleKind, steps: u32) -> Self {
        Self {
            accelerator,
            schedule,
            steps,
            skip: Skip::Off,
            numerics: Numerics::Robust,
            traversal: Traversal::AmanatidesWoo,
            is_padded: false,
        }
    }

    /// The same with empty-space skipping.
    #[must_use]
    pub const fn leaping(self) -> Self {
        Self { skip: Skip::On, ..self }
    }

    /// The same with the paper's numerics.
    #[must_use]
    pub const fn paper(self) -> Self {
        Self { numerics: Numerics::Paper, ..self }
    }

    /// The same with the paper's numerics, by a 3D-DDA.
    #[must_use]
    pub const fn dda(self) -> Self {
        Self { numerics: Numerics::Paper, traversal: Traversal::Dda3d, ..self }
    }

    /// The same with boxes that are grown for each ray.
    #[must_use]
    pub const fn padded(self) -> Self {
        Self { is_padded: true, ..self }
    }

    /// Whether a ray's walk takes many passes.
    #[must_use]
    pub fn is_stepped(self) -> bool {
        self.schedule.is_stepped()
    }

    /// `options` with this configuration.
    #[must_use]
    pub fn of(self, options: &Options) -> Options {
        Options {
            accelerator: self.accelerator,
            schedule: self.schedule,
            steps_per_pass: self.steps,
            skip: self.skip,
            numerics: self.numerics,
            traversal: self.traversal,
            keep: if self.is_padded { Keep::only(Item::RayPadding) } else { options.keep },
            ..options.clone()
        }
    }
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.accelerator, self.schedule, self.steps)?;
        if self.skip == Skip::On {
            f.write_str(" skipping")?;
        }
        if self.numerics == Numerics::Paper {
            f.write_str(" paper")?;
        }
        if self.traversal == Traversal::Dda3d {
            f.write_str(" 3d-dda")?;
        }
        if self.is_padded {
            f.write_str(" padded")?;
        }
        Ok(())
    }
}

/// Every kernel that traces rays, with both numerics, in each of its launch modes. What depends on the scene, on samples
/// or on the number of loop iterations is not in it.
pub const COVERING: [Way; 35] = {
    use Accelerator::{Bvh, Grid, Irregular, None};
    use ScheduleKind::{Compact, First, Fused, Second};
    [
        STEPPED,
        Way::new(Grid, First, 1).paper(),
        Way::new(Grid, Second, 1).leaping(),
        Way::new(Grid, Compact, 1),
        Way::new(Grid, Compact, 8),
        Way::new(Grid, Compact, 8).leaping(),
        Way::new(Grid, Compact, 3).leaping(),
        Way::new(Grid, Compact, 8).paper(),
        Way::new(Grid, Fused, 1),
        Way::new(Grid, Fused, 1).leaping(),
        Way::new(Grid, Fused, 1).paper(),
        Way::new(Grid, Second, 1).dda(),
        Way::new(Grid, Compact, 1).dda(),
        Way::new(Grid, Compact, 8).dda(),
        Way::new(Grid, Fused, 1).dda(),
        Way::new(Bvh, Second, 1),
        Way::new(Bvh, Compact, 1).paper(),
        Way::new(Bvh, Compact, 8),
        Way::new(Bvh, Compact, 2).paper(),
        Way::new(Bvh, Fused, 1),
        Way::new(Bvh, Fused, 1).paper(),
        Way::new(Bvh, Compact, 1).padded(),
        Way::new(Bvh, Compact, 8).padded(),
        Way::new(Bvh, Fused, 1).padded(),
        Way::new(Irregular, First, 1),
        Way::new(Irregular, Second, 1),
        Way::new(Irregular, Compact, 1),
        Way::new(Irregular, Compact, 8),
        Way::new(Irregular, Fused, 1),
        Way::new(None, Second, 1),
        Way::new(None, First, 1).paper(),
        Way::new(None, Compact, 1),
        Way::new(None, Compact, 8),
        Way::new(None, Fused, 1),
        Way::new(None, Compact, 3).paper(),
    ]
};

/// Every accelerator: one step per pass in either launch mode, several steps per pass, and fused. Robust numerics.
pub const EVERY: [Way; 21] = {
    use Accelerator::{Bvh, Grid, Irregular, None};
    use ScheduleKind::{Compact, Fused, Second};
    [
        Way::new(Grid, Second, 1),
        Way::new(Grid, Compact, 1).leaping(),
        Way::new(Grid, Compact, 8),
        Way::new(Grid, Compact, 8).leaping(),
        Way::new(Grid, Fused, 1),
        Way::new(Grid, Fused, 1).leaping(),
        Way::new(Bvh, Second, 1),
        Way::new(Bvh, Compact, 1),
        Way::new(Bvh, Compact, 8),
        Way::new(Bvh, Fused, 1),
        Way::new(None, Second, 1),
        Way::new(None, Compact, 1),
        Way::new(None, Compact, 8),
        Way::new(None, Fused, 1),
        Way::new(Bvh, Second, 1).padded(),
        Way::new(Bvh, Compact, 8).padded(),
        Way::new(Bvh, Fused, 1).padded(),
        Way::new(Irregular, Second, 1),
        Way::new(Irregular, Compact, 1),
        Way::new(Irregular, Compact, 8),
        Way::new(Irregular, Fused, 1),
    ]
};

/// Grid with and without empty-space skipping, irregular grid and BVH, in many passes and in one: fast enough for many rays.
pub const FAST: [Way; 8] = {
    use Accelerator::{Bvh, Grid, Irregular};
    use ScheduleKind::{Compact, Fused};
    [
        Way::new(Grid, Compact, 8),
        Way::new(Grid, Compact, 8).leaping(),
        Way::new(Grid, Fused, 1),
        Way::new(Grid, Fused, 1).leaping(),
        Way::new(Bvh, Compact, 8),
        Way::new(Bvh, Fused, 1),
        Way::new(Irregular, Compact, 8),
        Way::new(Irregular, Fused, 1),
    ]
};

/// The numerics with which rays can be traced through this accelerator.
#[must_use]
pub fn numerics_of(accelerator: Accelerator) -> &'static [Numerics] {
    match accelerator {
        Accelerator::Irregular => &[Numerics::Robust],
        _ => &[Numerics::Robust, Numerics::Paper],
    }
}

/// Whether walks through this accelerator use the rule.
#[must_use]
pub fn has_rule(accelerator: Accelerator, rule: Rule) -> bool {
    match rule {
        Rule::TMax | Rule::Acceptance => accelerator == Accelerator::Grid,
        Rule::CellGrowth => matches!(accelerator, Accelerator::Grid | Accelerator::Irregular),
        Rule::BoxPadding => accelerator == Accelerator::Bvh,
        Rule::TriangleTest => true,
    }
}

/// As in the paper: through the grid, every ray launched in every pass, one step each. It has many passes, and each
/// kernel does one thing.
pub const STEPPED: Way = Way::new(Accelerator::Grid, ScheduleKind::Second, 1);

/// Note for users when the paper's numerics miss everything.
pub const MISSES_ALL: &str = "the paper's rules require the eye to be inside the grid: from here, all rays miss; \
                              move the eye inside, or use --numerics robust";

/// The same in a report, whose choices are not the reader's.
pub const ALL_MISS: &str = "with the paper's rules and a grid, rays are lost, because the eye is outside the grid";

/// Whether the paper's numerics, which do not clip rays to the grid, start a camera's rays outside the grid.
#[must_use]
pub fn misses_all(scene: &Scene, options: &Options, plan: &Plan) -> bool {
    let RaySource::Camera { camera, .. } = &options.rays else { return false };
    let (bounds, eye) = (scene.bounds(), camera.eye);
    // --keep-all keeps the clipping code even if the eye is inside.
    let is_inside = eye.cmpgt(bounds.min.as_dvec3()).all() && eye.cmplt(bounds.max.as_dvec3()).all();
    let features = &plan.features;
    features.grid && features.clip && !features.robust && !(options.keep.has(Item::Clipping) && is_inside)
}

/// Why the paper's numerics lose rays of other programs.
pub const MISSES_OUTSIDE: &str = "with a grid, the paper's rules can lose rays that start outside it";

/// How many rays start outside the grid, to which the paper's numerics do not clip them; 0 with other numerics.
#[must_use]
pub fn count_outside(rays: &[Ray], data: &SceneData) -> usize {
    let SceneData { features, units, info, grid, .. } = data;
    if features.robust || !features.grid || info.triangles == 0 {
        return 0;
    }
    let is_outside = |ray: &&Ray| {
        (0..3).any(|axis| {
            let cell = (units.to_traced(ray.origin[axis]) - grid.corner[axis]) / grid.width[axis];
            !(0.0..grid.cells[axis] as f32).contains(&cell)
        })
    };
    rays.iter().filter(is_outside).count()
}

/// How many that is of all of them, in words, if there is one.
#[must_use]
pub fn share_outside(rays: &[Ray], data: &SceneData) -> Option<&'static str> {
    match count_outside(rays, data) {
        0 => None,
        all if all == rays.len() => Some("all"),
        most if 2 * most > rays.len() => Some("most"),
        _ => Some("some"),
    }
}
