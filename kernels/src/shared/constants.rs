//! Constants shared by kernels and twins, made into the WGSL module `package::constants`.

/// Larger than any t: the value of t without a hit, and of `tmax` along an axis that is never crossed. 2¹⁰⁰ instead of
/// infinity, because WGSL may assume that there are no infinities.
pub const INF: f32 = 1.267_650_6e30;

/// A direction component below this (2⁻⁶⁴) cannot move the ray inside the grid by more than the rounding error that
/// cells are grown for: with t at most 2²⁸ in traced units, it moves by less than 2⁻³⁶, far less than every cell's
/// growth (see [`crate::structures::grid`]). Dividing by anything larger stays below [`INF`].
pub const PARALLEL: f32 = 5.421_011e-20;

/// The paper's threshold for parallel rays (§4.2.3), absolute.
pub const PAPER_PARALLEL: f32 = 0.001;

/// The determinant's threshold in the published Möller–Trumbore test (1997).
pub const PAPER_EPSILON: f32 = 1e-6;

/// The smallest normal f32, 2⁻¹²⁶.
pub const MIN_NORMAL: f32 = f32::MIN_POSITIVE;

/// The triangle of a ray that hit nothing.
pub const NO_TRIANGLE: u32 = 0xffff_ffff;

/// Bounds of the rounding errors of the triangle test, see `triangle.wgsl`: of an edge function, of a sheared corner and of
/// t, in parts of 2⁻²⁴ of what they are relative to. Each is larger than what is derived, by the rounding of the bound itself.
pub const EDGE_ERROR: f32 = 36.0 / (1 << 24) as f32;
/// See [`EDGE_ERROR`].
pub const CORNER_ERROR: f32 = 4.0 / (1 << 24) as f32;
/// See [`EDGE_ERROR`].
pub const DEPTH_ERROR: f32 = 34.0 / (1 << 24) as f32;

/// More than what rounding t to the nearest f32 moves it by, with the rounding of sums of t and its error, in parts of t.
pub const END_ERROR: f32 = 4.0 / (1 << 24) as f32;

/// More than products lose that underflow in the triangle test, 2⁻¹²⁰.
pub const UNDERFLOW: f32 = 7.523_164e-37;

/// How much a box of the BVH is grown per distance from the ray's origin: 2⁻¹⁸, 64 roundings. See
/// [`Padding`](crate::structures::bvh::Padding).
pub const BOX_PADDING: f32 = 3.814_697_3e-6;

/// Invocations per workgroup along x and along y. 64 in total, a multiple of every GPU's SIMD width.
pub const WORKGROUP: u32 = 8;

/// Likewise for a workgroup that appends rays to lists: the larger it is, the fewer workgroups compete for a list's
/// end.
pub const LIST_SIDE: u32 = 16;

/// Nodes of the binary BVH per step, where a ray takes several steps per pass: about as much work as a cell, or a node
/// of the wide BVH.
pub const NODES_A_STEP: u32 = 8;

/// Workgroups per row of an indirect dispatch; the number of rows depends on the number of live rays.
pub const LIST_GROUPS: u32 = 8;

/// The tag of a thread that has no ray to work on.
pub const NOBODY: u32 = 0xffff_ffff;

/// The parent of a BVH's root, and the node of a ray that has finished its walk.
pub const NO_NODE: u32 = 0xffff_ffff;

/// Most levels of a wide BVH: a walk needs one stack entry per level.
pub const WIDE_MAX_DEPTH: u32 = 32;

/// The cell of a search that has not begun yet.
pub const NO_CELL: u32 = 0xffff_ffff;

/// Start of the list of an irregular grid's cell that lists nothing.
pub const NO_LIST: u32 = 0xffff_ffff;

/// The cell of an irregular grid that is the space around it, if triangles were set aside: rays begin there.
pub const OUTSIDE: u32 = 0;

/// The bit that marks the last item of a list of an irregular grid.
pub const LAST_ITEM: u32 = 1 << 31;

/// Added to the number of lights summed so far, in the state's item: larger than any list's length.
pub const LIGHTS_SUMMED: u32 = 1 << 31;

/// Loop iterations that a triangle test counts as: one of the list's loop, and three of the loop over its edges.
pub const TURNS_A_TEST: u32 = 4;

/// Loop iterations that integers take to decide about a triangle, with some to spare.
pub const TURNS_TO_DECIDE: u32 = 2_048;

/// The same to decide which of two triangles a ray crosses first, whose origin is moved by an infinitesimal.
pub const TURNS_TO_CROSS: u32 = 8_192;

/// Words that a ray takes which waits for the other ray of a surface.
pub const BRANCH: u32 = 10;

/// Words of a place where a photon is stored.
pub const RECORD: u32 = 11;

/// Groups of siblings that the fused kernel's stack has room for, if a scene's BVH needs `needed`.
#[must_use]
pub fn wide_stack(needed: u32) -> u32 {
    needed.clamp(1, WIDE_MAX_DEPTH)
}

/// The WGSL module `package::constants`, for a stack of this many groups, this many loop iterations per dispatch, and for
/// rays that are reflected or refracted at most so often.
#[must_use]
pub fn wgsl_module(stack: u32, turns: u32, depth: u32) -> String {
    // Rust prints the shortest decimal that parses to the same f32.
    format!(
        "const INF: f32 = {INF:e}f;\nconst PARALLEL: f32 = {PARALLEL:e}f;\n\
         const PAPER_PARALLEL: f32 = {PAPER_PARALLEL:e}f;\nconst PAPER_EPSILON: f32 = {PAPER_EPSILON:e}f;\n\
         const MIN_NORMAL: f32 = {MIN_NORMAL:e}f;\nconst BOX_PADDING: f32 = {BOX_PADDING:e}f;\n\
         const EDGE_ERROR: f32 = {EDGE_ERROR:e}f;\nconst CORNER_ERROR: f32 = {CORNER_ERROR:e}f;\n\
         const DEPTH_ERROR: f32 = {DEPTH_ERROR:e}f;\nconst UNDERFLOW: f32 = {UNDERFLOW:e}f;\n\
         const END_ERROR: f32 = {END_ERROR:e}f;\n\
         const NO_TRIANGLE: u32 = {NO_TRIANGLE}u;\nconst WORKGROUP: u32 = {WORKGROUP}u;\n\
         const LIST_SIDE: u32 = {LIST_SIDE}u;\nconst LIST_GROUPS: u32 = {LIST_GROUPS}u;\nconst NOBODY: u32 = {NOBODY}u;\nconst NODES_A_STEP: u32 = {NODES_A_STEP}u;\nconst NO_NODE: u32 = {NO_NODE}u;\n\
         const TINY_DIRECTION: f32 = {PARALLEL:e}f;\nconst WIDE_STACK: u32 = {}u;\n\
         const TURNS_A_TEST: u32 = {TURNS_A_TEST}u;\nconst TURNS_TO_DECIDE: u32 = {TURNS_TO_DECIDE}u;\nconst TURNS_TO_CROSS: u32 = {TURNS_TO_CROSS}u;\nconst NO_CELL: u32 = {NO_CELL}u;\nconst NO_LIST: u32 = {NO_LIST}u;\nconst OUTSIDE: u32 = {OUTSIDE}u;\nconst LAST_ITEM: u32 = {LAST_ITEM}u;\nconst LIGHTS_SUMMED: u32 = {LIGHTS_SUMMED}u;\nconst TURNS: u32 = {turns}u;\n\
         const DEPTH: u32 = {depth}u;\nconst BRANCH: u32 = {BRANCH}u;\nconst RECORD: u32 = {RECORD}u;\n",
        wide_stack(stack)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_the_powers_of_two_that_the_bounds_assume() {
        assert_eq!(INF, 100f32.exp2());
        assert_eq!(PARALLEL, (-64f32).exp2());
        assert_eq!(BOX_PADDING, (-18f32).exp2());
        assert_eq!(UNDERFLOW, (-120f32).exp2());
    }
}
