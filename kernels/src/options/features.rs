//! The textual options of the kernels: what a run needs, and for what it does not need, why not.

use crate::shared::grid_walk::WalkRules;
use crate::shared::samples::Sampler;
use crate::shared::triangle::TriangleRules;

macro_rules! features {
    ($($name:ident: $doc:literal,)*) => {
        /// One flag for every `@if` in the WGSL, on which the twins branch too, and two numbers.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        pub struct Features {
            $(#[doc = $doc] pub $name: bool,)*
            /// Groups of siblings that wait at most while the fused kernel walks through the tree of this scene.
            pub stack: u32,
            /// Loop turns after which a thread leaves the rest to the next dispatch; 0 where no thread needs so many.
            pub turns: u32,
        }

        impl Features {
            /// Name in the WGSL and value of every flag.
            #[must_use]
            pub fn list(&self) -> Vec<(&'static str, bool)> {
                vec![$((stringify!($name), self.$name)),*]
            }
        }
    };
}

features! {
    robust: "`--numerics robust`, else `paper`.",
    watertight: "Triangles are tested by Woop, Benthin and Wald (2013), else by Möller and Trumbore (1997).",
    contracted: "The watertight test has an explicit fma wherever a compiler may contract.",
    drifting: "tMax grows by tDelta from cell to cell, else it follows from the cell.",
    in_cell: "A hit counts only in the cell that is tested, else the nearest is kept.",
    grid: "The scene is traced through a uniform grid.",
    bvh: "The scene is traced through a tree of boxes.",
    skip: "Rays leap over empty cells of the grid.",
    live_lists: "Only rays that wait for a kernel are launched.",
    many_steps: "A ray may take several steps in one pass.",
    resumes: "A walk may take more loop turns than one dispatch has: it goes on in the next.",
    resumes_scan: "The search for repeated tests may, likewise.",
    resumes_light: "The sum over the lights may, likewise.",
    any_hit: "A ray ends at the first hit that is found.",
    eye_rays: "The fused kernel makes its rays itself.",
    clip: "Rays may start outside of the grid.",
    perspective: "Rays fan out from the eye, else they are parallel.",
    counters: "Cells visited and triangles tested are counted per ray.",
    normals: "Shading interpolates vertex normals.",
    textures: "A material has a base colour texture.",
    vertex_colors: "Corners have colours.",
    many_materials: "There is more than one material.",
    emissive: "A material emits light.",
    double_sided: "A material is shaded on both sides.",
    many_lights: "There is more than one light.",
    directional_lights: "A light is directional.",
    spot_lights: "A light is a spot.",
    samples: "A pixel has several samples, each with a ray of its own.",
    sobol: "Samples are spread evenly over the pixel, else at random.",
}

impl Features {
    /// The part that the grid's walk depends on.
    #[must_use]
    pub fn walk_rules(&self) -> WalkRules {
        WalkRules { robust: self.robust, clip: self.clip, drifting: self.drifting }
    }

    /// Whether tMax follows from a ray's cell, so that a kernel which takes several steps need not keep it.
    #[must_use]
    pub fn keeps_no_tmax(&self) -> bool {
        self.robust && !self.drifting
    }

    /// The part that the test of a triangle depends on.
    #[must_use]
    pub fn triangle_rules(&self) -> TriangleRules {
        TriangleRules { watertight: self.watertight, contracted: self.contracted }
    }

    /// How samples are spread over a pixel, where it has several.
    #[must_use]
    pub fn sampler(&self) -> Sampler {
        if self.sobol { Sampler::Sobol } else { Sampler::Random }
    }
}
