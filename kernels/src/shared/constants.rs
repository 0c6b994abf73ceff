//! Numbers that kernels and twins share. They become the WGSL module `package::constants`.

/// Farther than any t: the value of t without a hit and of `tmax` along an axis that is never crossed.
/// 2¹⁰⁰ and not infinity, because WGSL may assume that infinities do not occur.
pub const INF: f32 = 1.267_650_6e30;

/// A direction component below this (2⁻⁶⁴) cannot carry the ray across one cell's width of rounding
/// error inside the grid: with t at most 2²⁸ in traced units, it moves by less than 2⁻³⁶, far less than
/// what every cell is grown by (see [`crate::structures::grid`]). Dividing by anything larger stays below [`INF`].
pub const PARALLEL: f32 = 5.421_011e-20;

/// The paper's threshold for the same question (§4.2.3), absolute.
pub const PAPER_PARALLEL: f32 = 0.001;

/// The determinant's threshold in the published Möller–Trumbore test (1997).
pub const PAPER_EPSILON: f32 = 1e-6;

/// The smallest f32 with all of its digits, 2⁻¹²⁶.
pub const MIN_NORMAL: f32 = f32::MIN_POSITIVE;

/// The triangle of a ray that hit nothing.
pub const NO_TRIANGLE: u32 = 0xffff_ffff;

/// Invocations of a workgroup along x and y. 64 together, a multiple of every GPU's lane count.
pub const WORKGROUP: u32 = 8;

/// The same of a workgroup that appends rays to lists: fewer workgroups wait for each other at a list's end.
pub const LIST_SIDE: u32 = 16;

/// Nodes of the binary tree that make one step of a ray that takes several a pass: about the work of a cell, or of a node of the wide tree.
pub const NODES_A_STEP: u32 = 8;

/// Workgroups a row of an indirect dispatch; the number of rows follows from the rays that are live.
pub const LIST_GROUPS: u32 = 8;

/// The tag of a thread that has no ray to work on.
pub const NOBODY: u32 = 0xffff_ffff;

/// The parent of a tree's root, and where a ray is that has finished its walk through a tree.
pub const NO_NODE: u32 = 0xffff_ffff;

/// Most levels of a wide tree: what a walk with an entry of its stack a level needs.
pub const WIDE_MAX_DEPTH: u32 = 32;

/// The cell of a search that has not begun.
pub const NO_CELL: u32 = 0xffff_ffff;

/// Added to the number of lights summed so far, in the state's item: longer than any list.
pub const LIGHTS_SUMMED: u32 = 1 << 31;

/// Loop turns that a triangle's test counts for: the list's, and three of the loop over its edges.
pub const TURNS_A_TEST: u32 = 4;

/// Groups of siblings that the stack of the fused kernel has room for, where a scene's tree needs so many.
#[must_use]
pub fn wide_stack(needed: u32) -> u32 {
    needed.clamp(1, WIDE_MAX_DEPTH)
}

/// The WGSL module `package::constants`, with room for so many groups on a ray's stack, and so many loop turns a
/// dispatch.
#[must_use]
pub fn wgsl_module(stack: u32, turns: u32) -> String {
    // Rust prints the shortest decimal that reads back as the same f32.
    format!(
        "const INF: f32 = {INF:e}f;\nconst PARALLEL: f32 = {PARALLEL:e}f;\n\
         const PAPER_PARALLEL: f32 = {PAPER_PARALLEL:e}f;\nconst PAPER_EPSILON: f32 = {PAPER_EPSILON:e}f;\n\
         const MIN_NORMAL: f32 = {MIN_NORMAL:e}f;\n\
         const NO_TRIANGLE: u32 = {NO_TRIANGLE}u;\nconst WORKGROUP: u32 = {WORKGROUP}u;\n\
         const LIST_SIDE: u32 = {LIST_SIDE}u;\nconst LIST_GROUPS: u32 = {LIST_GROUPS}u;\nconst NOBODY: u32 = {NOBODY}u;\nconst NODES_A_STEP: u32 = {NODES_A_STEP}u;\nconst NO_NODE: u32 = {NO_NODE}u;\n\
         const TINY_DIRECTION: f32 = {PARALLEL:e}f;\nconst WIDE_STACK: u32 = {}u;\n\
         const TURNS_A_TEST: u32 = {TURNS_A_TEST}u;\nconst NO_CELL: u32 = {NO_CELL}u;\nconst LIGHTS_SUMMED: u32 = {LIGHTS_SUMMED}u;\nconst TURNS: u32 = {turns}u;\n",
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
    }
}
