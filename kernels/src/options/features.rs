//! The options of the kernels, decided when their WGSL is composed.

use super::Ray;
use super::scene_data::SceneDataKind;
use crate::shared::constants::INF;
use crate::shared::grid_walk::WalkRules;
use crate::shared::samples::Sampler;
use crate::shared::triangle::TriangleRules;

macro_rules! features {
    ($($name:ident: $doc:literal,)*) => {
        /// One flag for every option named in an `@if` of the WGSL; the twins branch on them too. And three numbers, and where the lists are.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        pub struct Features {
            $(#[doc = $doc] pub $name: bool,)*
            /// Most groups of siblings that wait on the stack while the fused kernel walks through this scene's BVH.
            pub stack: u32,
            /// Loop iterations after which a thread leaves the rest to the next dispatch; 0 if no thread needs so many.
            pub turns: u32,
            /// How many times a ray is reflected or refracted at most.
            pub depth: u32,
            /// Where the lists of scene data are on the device; the WGSL that is composed does not depend on it.
            pub scene_data: SceneDataKind,
        }

        impl Features {
            /// Name (in the WGSL) and value of every flag.
            #[must_use]
            pub fn list(&self) -> Vec<(&'static str, bool)> {
                vec![$((stringify!($name), self.$name)),*]
            }

            /// Sets a flag; false if there is none of this name.
            pub fn set(&mut self, name: &str, is_on: bool) -> bool {
                match name {
                    $(stringify!($name) => self.$name = is_on,)*
                    _ => return false,
                }
                true
            }
        }
    };
}

features! {
    robust: "`--numerics robust`, else `paper`.",
    watertight: "Triangles are tested by Woop, Benthin and Wald (2013), else by Möller and Trumbore (1997).",
    exact_order: "The nearest hit is the one at the smallest exact t: what rounding leaves open is decided in integers.",
    decides: "The kernel decides in integers.",
    contracted: "The watertight test has an explicit fma wherever a compiler may contract.",
    dda: "A grid is walked by a 3D-DDA, else as Amanatides and Woo do.",
    drifting: "tMax is accumulated: it grows by tDelta per cell; else it is computed from the cell.",
    in_cell: "A hit counts only inside the cell being tested, else the nearest is kept.",
    grid: "The scene is traced through a uniform grid.",
    irregular: "The scene is traced through an irregular grid.",
    aside: "Triangles much farther away than the others are tested before a ray enters the irregular grid.",
    bvh: "The scene is traced through a BVH.",
    wide: "The BVH has up to eight children a node.",
    ray_padding: "Boxes of the BVH are grown as they are tested, by their distance; else when they are built.",
    skip: "Rays skip empty cells of the grid, several at a time.",
    live_lists: "Only rays that wait for a kernel are launched.",
    fragments: "Kernels run as fragment programs.",
    many_steps: "A ray may take several steps in one pass.",
    resumes: "A walk may take more loop iterations than one dispatch allows: it continues in the next.",
    resumes_exact: "The same where integers decide.",
    resumes_scan: "The same for the search for repeated tests.",
    resumes_light: "The same for the sum over the lights.",
    intervals: "Rays have a smallest or a largest t: other hits do not count.",
    any_hit: "A ray ends at the first hit found, nearest or not.",
    all_hits: "All hits of a ray are wanted, in exact order: each is found after the one before it.",
    leaves: "A ray begins on a triangle, which it cannot hit again.",
    specular: "Surfaces reflect or refract rays, each of which is traced like the first.",
    dielectric: "A surface splits a ray in two.",
    path: "Light is followed along random paths.",
    whole_paths: "One kernel follows a path from its first ray to its end.",
    mis: "Light that a path finds counts by the pdfs of both ways to find it.",
    by_light: "Light that a path hits by chance counts only after a mirror or glass.",
    photons: "Light that photons carried to surfaces is estimated from a map of them.",
    mapped: "There is such a map: something gives light, and photons may bounce.",
    exact: "It is estimated from exactly the nearest photons.",
    gathers_later: "It is estimated where rays arrive that a diffuse surface sends on.",
    apart: "The kernel's elements are not those of the image.",
    eye_rays: "The fused kernel generates its rays itself.",
    clip: "Rays may start outside of the grid.",
    perspective: "Rays fan out from the eye, else they are parallel.",
    counters: "Cells visited and triangles tested are counted per ray.",
    normals: "Shading interpolates vertex normals.",
    textures: "A material has a base colour texture.",
    vertex_colors: "Vertices have colours.",
    many_materials: "There is more than one material.",
    emissive: "A material emits light.",
    double_sided: "A material is shaded on both sides.",
    many_lights: "There is more than one light.",
    directional_lights: "A light is directional.",
    spot_lights: "A light is a spot.",
    shadows: "A light counts only if a shadow ray reaches it.",
    samples: "A pixel has several samples, each with its own ray.",
    sobol: "Samples are spread evenly over the pixel, else at random.",
    blocks: "A pixel has several blocks of samples, each with its own mean.",
}

/// What a scene is traced through.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StructureKind {
    /// Nothing: every ray tests every triangle.
    #[default]
    None,
    /// A uniform grid.
    Grid,
    /// An irregular grid, or a grid of two levels.
    Irregular,
    /// A BVH: a binary one, or an eight-wide one for the fused kernel.
    Bvh,
}

impl StructureKind {
    /// Whether it is a grid of either kind, whose cells have lists.
    #[must_use]
    pub const fn has_cells(self) -> bool {
        matches!(self, Self::Grid | Self::Irregular)
    }
}

impl Features {
    /// What the scene is traced through.
    #[must_use]
    pub const fn structure(&self) -> StructureKind {
        match (self.grid, self.irregular, self.bvh) {
            (true, ..) => StructureKind::Grid,
            (_, true, _) => StructureKind::Irregular,
            (.., true) => StructureKind::Bvh,
            _ => StructureKind::None,
        }
    }

    /// The t after which hits of a ray count. If all hits are wanted, it is the triangle that a ray from a surface leaves by or
    /// not that tells, not the rounded t.
    #[must_use]
    pub(crate) fn begin(&self, ray: &Ray) -> f32 {
        if self.all_hits && ray.t_min == 0.0 { -INF } else { ray.t_min }
    }

    /// The options that the walk through the grid depends on.
    #[must_use]
    pub fn walk_rules(&self) -> WalkRules {
        WalkRules { robust: self.robust, clip: self.clip, drifting: self.drifting, dda: self.dda }
    }

    /// Whether tMax is computed from a ray's cell, so that a kernel which takes several steps need not store it.
    #[must_use]
    pub fn keeps_no_tmax(&self) -> bool {
        self.robust && !self.drifting
    }

    /// The options that the triangle test depends on.
    #[must_use]
    pub fn triangle_rules(&self) -> TriangleRules {
        TriangleRules { watertight: self.watertight, contracted: self.contracted, exact_order: self.exact_order }
    }

    /// How samples are distributed over a pixel that has several.
    #[must_use]
    pub fn sampler(&self) -> Sampler {
        if self.sobol { Sampler::Sobol } else { Sampler::Random }
    }
}
