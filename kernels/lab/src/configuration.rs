//! How a scene is traced: what measurements and tests compare.

use std::fmt;

use raystep_kernels::options::Integrator;
use raystep_kernels::options::STEPS_PER_PASS;
use raystep_kernels::options::mapping::Mapping;
use raystep_kernels::{
    Accelerator, GridSize, Item, Keep, Numerics, Options, Order, Rule, ScheduleKind, Skip, Traversal,
};

/// The options that are compared with one another, on the same scene, rays and device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Configuration {
    /// The acceleration structure.
    pub accelerator: Accelerator,
    /// The schedule.
    pub schedule: ScheduleKind,
    /// Most steps of a ray in one pass of the compact schedule.
    pub steps: u32,
    /// Whether rays skip empty cells.
    pub skip: Skip,
    /// The resolution of a uniform grid; that of the other options if `None`.
    pub grid: Option<GridSize>,
    /// The numerics.
    pub numerics: Numerics,
    /// Which of several hits is the nearest; as in the other options if `None`.
    pub order: Option<Order>,
    /// The rule of robust numerics that is replaced by the paper's.
    pub without: Option<Rule>,
    /// How rays walk through a uniform grid.
    pub traversal: Traversal,
    /// How kernels are mapped to the GPU.
    pub mapping: Mapping,
    /// The light that is computed; that of the other options if `None`.
    pub integrator: Option<Integrator>,
    /// Whether boxes are grown for each ray in any scene.
    pub is_padded: bool,
    /// Whether to use explicit fma wherever a compiler may contract, see [`Options::contracted`].
    pub contracted: bool,
}

/// Steps of a pass that tests every triangle: its list holds the whole scene.
pub const TESTS_PER_PASS: u32 = 128;

impl Configuration {
    /// Robust numerics, without empty-space skipping.
    #[must_use]
    pub const fn new(accelerator: Accelerator, schedule: ScheduleKind, steps: u32) -> Self {
        Self {
            accelerator,
            schedule,
            steps,
            skip: Skip::Off,
            grid: None,
            numerics: Numerics::Robust,
            order: None,
            without: None,
            traversal: Traversal::AmanatidesWoo,
            mapping: Mapping::Compute,
            integrator: None,
            is_padded: false,
            contracted: false,
        }
    }

    /// What the command line takes by default; without a structure, [`TESTS_PER_PASS`] steps a pass.
    #[must_use]
    pub fn usual(accelerator: Accelerator, schedule: ScheduleKind) -> Self {
        let steps = if accelerator == Accelerator::None { TESTS_PER_PASS } else { STEPS_PER_PASS };
        Self { skip: Skip::Auto, ..Self::new(accelerator, schedule, steps) }
    }

    /// The same with empty-space skipping.
    #[must_use]
    pub const fn skipping(self) -> Self {
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
        Self { traversal: Traversal::Dda3d, ..self.paper() }
    }

    /// The same with hits that are ordered by exact t.
    #[must_use]
    pub const fn exact(self) -> Self {
        Self { order: Some(Order::Exact), ..self }
    }

    /// Whether hits are ordered by exact t.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.order == Some(Order::Exact) && self.without.is_none()
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
            grid: self.grid.unwrap_or(options.grid),
            numerics: self.numerics,
            order: self.order.unwrap_or(options.order),
            without: self.without,
            traversal: self.traversal,
            mapping: self.mapping,
            integrator: self.integrator.unwrap_or(options.integrator),
            contracted: self.contracted,
            keep: if self.is_padded { Keep::only(Item::RayPadding) } else { options.keep },
            ..options.clone()
        }
    }

    /// Its fields in CSV files, by the names of their columns.
    pub(crate) fn fields(&self) -> [(&'static str, String); 9] {
        let steps = (self.schedule == ScheduleKind::Compact).then(|| self.steps.to_string());
        [
            ("accelerator", self.accelerator.to_string()),
            ("schedule", self.schedule.to_string()),
            ("numerics", self.numerics.to_string()),
            ("order", if self.is_exact() { Order::Exact } else { Order::Rounded }.to_string()),
            ("rule", self.without.map_or(String::new(), |rule| rule.to_string())),
            ("skip", self.skip.to_string()),
            ("steps_per_pass", steps.unwrap_or_default()),
            ("mapping", self.mapping.to_string()),
            ("traversal", self.traversal.to_string()),
        ]
    }

    /// Its numerics in a configuration's id: `robust`, `paper`, `exact`, or `without-` and the rule.
    pub(crate) fn rules(&self) -> String {
        match self.without {
            Some(rule) => format!("without-{rule}"),
            None if self.is_exact() => "exact".into(),
            None => self.numerics.to_string(),
        }
    }
}

impl From<&Options> for Configuration {
    fn from(options: &Options) -> Self {
        Self {
            accelerator: options.accelerator,
            schedule: options.schedule,
            steps: options.steps_per_pass,
            skip: options.skip,
            grid: Some(options.grid),
            numerics: options.numerics,
            order: Some(options.order),
            without: options.without,
            traversal: options.traversal,
            mapping: options.mapping,
            integrator: Some(options.integrator),
            is_padded: false,
            contracted: options.contracted,
        }
    }
}

impl fmt::Display for Configuration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.accelerator, self.schedule, self.steps)?;
        for (is_so, words) in [
            (self.skip == Skip::On, " skipping"),
            (self.numerics == Numerics::Paper, " paper"),
            (self.traversal == Traversal::Dda3d, " 3d-dda"),
            (self.is_exact(), " exact"),
            (self.is_padded, " padded"),
        ] {
            f.write_str(if is_so { words } else { "" })?;
        }
        Ok(())
    }
}

/// Every kernel that traces rays, with both numerics, in each of its launch modes. What depends on the scene, on samples
/// or on the number of loop iterations is not in it.
pub const COVERING: [Configuration; 35] = {
    use Accelerator::{Bvh, Grid, Irregular, None};
    use ScheduleKind::{Compact, First, Fused, Second};
    [
        STEPPED,
        Configuration::new(Grid, First, 1).paper(),
        Configuration::new(Grid, Second, 1).skipping(),
        Configuration::new(Grid, Compact, 1),
        Configuration::new(Grid, Compact, 8),
        Configuration::new(Grid, Compact, 8).skipping(),
        Configuration::new(Grid, Compact, 3).skipping(),
        Configuration::new(Grid, Compact, 8).paper(),
        Configuration::new(Grid, Fused, 1),
        Configuration::new(Grid, Fused, 1).skipping(),
        Configuration::new(Grid, Fused, 1).paper(),
        Configuration::new(Grid, Second, 1).dda(),
        Configuration::new(Grid, Compact, 1).dda(),
        Configuration::new(Grid, Compact, 8).dda(),
        Configuration::new(Grid, Fused, 1).dda(),
        Configuration::new(Bvh, Second, 1),
        Configuration::new(Bvh, Compact, 1).paper(),
        Configuration::new(Bvh, Compact, 8),
        Configuration::new(Bvh, Compact, 2).paper(),
        Configuration::new(Bvh, Fused, 1),
        Configuration::new(Bvh, Fused, 1).paper(),
        Configuration::new(Bvh, Compact, 1).padded(),
        Configuration::new(Bvh, Compact, 8).padded(),
        Configuration::new(Bvh, Fused, 1).padded(),
        Configuration::new(Irregular, First, 1),
        Configuration::new(Irregular, Second, 1),
        Configuration::new(Irregular, Compact, 1),
        Configuration::new(Irregular, Compact, 8),
        Configuration::new(Irregular, Fused, 1),
        Configuration::new(None, Second, 1),
        Configuration::new(None, First, 1).paper(),
        Configuration::new(None, Compact, 1),
        Configuration::new(None, Compact, 8),
        Configuration::new(None, Fused, 1),
        Configuration::new(None, Compact, 3).paper(),
    ]
};

/// Every accelerator: one step per pass in either launch mode, several steps per pass, and fused. Robust numerics.
pub const EVERY: [Configuration; 21] = {
    use Accelerator::{Bvh, Grid, Irregular, None};
    use ScheduleKind::{Compact, Fused, Second};
    [
        Configuration::new(Grid, Second, 1),
        Configuration::new(Grid, Compact, 1).skipping(),
        Configuration::new(Grid, Compact, 8),
        Configuration::new(Grid, Compact, 8).skipping(),
        Configuration::new(Grid, Fused, 1),
        Configuration::new(Grid, Fused, 1).skipping(),
        Configuration::new(Bvh, Second, 1),
        Configuration::new(Bvh, Compact, 1),
        Configuration::new(Bvh, Compact, 8),
        Configuration::new(Bvh, Fused, 1),
        Configuration::new(None, Second, 1),
        Configuration::new(None, Compact, 1),
        Configuration::new(None, Compact, 8),
        Configuration::new(None, Fused, 1),
        Configuration::new(Bvh, Second, 1).padded(),
        Configuration::new(Bvh, Compact, 8).padded(),
        Configuration::new(Bvh, Fused, 1).padded(),
        Configuration::new(Irregular, Second, 1),
        Configuration::new(Irregular, Compact, 1),
        Configuration::new(Irregular, Compact, 8),
        Configuration::new(Irregular, Fused, 1),
    ]
};

/// Grid with and without empty-space skipping, irregular grid and BVH, in many passes and in one: fast enough for many rays.
pub const FAST: [Configuration; 8] = {
    use Accelerator::{Bvh, Grid, Irregular};
    use ScheduleKind::{Compact, Fused};
    [
        Configuration::new(Grid, Compact, 8),
        Configuration::new(Grid, Compact, 8).skipping(),
        Configuration::new(Grid, Fused, 1),
        Configuration::new(Grid, Fused, 1).skipping(),
        Configuration::new(Bvh, Compact, 8),
        Configuration::new(Bvh, Fused, 1),
        Configuration::new(Irregular, Compact, 8),
        Configuration::new(Irregular, Fused, 1),
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

/// Whether walks through this accelerator use the rule, unless they are asked for another order of hits.
#[must_use]
pub fn has_rule(accelerator: Accelerator, rule: Rule) -> bool {
    match rule {
        Rule::TMax | Rule::Acceptance => accelerator == Accelerator::Grid,
        Rule::CellGrowth => matches!(accelerator, Accelerator::Grid | Accelerator::Irregular),
        Rule::BoxPadding => accelerator == Accelerator::Bvh,
        Rule::TriangleTest => true,
        Rule::ExactOrder => false,
    }
}

/// As in the paper: through the grid, every ray launched in every pass, one step each. It has many passes, and each
/// kernel does one thing.
pub const STEPPED: Configuration = Configuration::new(Accelerator::Grid, ScheduleKind::Second, 1);
