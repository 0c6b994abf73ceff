//! How a program's kernels are written down.

/// Defines a program's table of kernels, and a constant for each of them. A kernel's twin is the function of the same
/// name in the module of the same name.
macro_rules! kernels {
    ($($(#[doc = $doc:literal])* $kernel:ident $module:ident of $over:ident, twin: $twin:ident, { takes: $takes:expr, sends: $sends:expr, role: $role:expr, workgroup: $workgroup:expr, launch: $launch:expr, counts: $counts:expr, resumes: $resumes:expr, list: $list:expr, $(proof: $proof:expr,)? $(sets: $sets:expr, follows: $follows:expr,)? colour: $colour:expr, why_absent: $why_absent:expr, summary: $summary:literal, explain: $explain:expr, path: $path:expr, rounding: $rounding:expr, breaks: $breaks:expr, })*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Index { $($kernel),* }

        /// Every kernel.
        pub static KERNELS: [$crate::program::Instance; [$(Index::$kernel as usize),*].len()] =
            [$($crate::program::Instance { $(sets: $sets, follows: $follows,)? ..$crate::program::Instance::of(
                $crate::program::KernelInfo {
                    name: stringify!($module),
                    wgsl: include_str!(concat!(stringify!($module), ".wgsl")),
                    twin: $crate::program::instance::twin!($twin $module),
                    home: &HOME,
                    takes: $takes,
                    sends: $sends,
                    role: $role,
                    workgroup: $workgroup,
                    launch: $launch,
                    counts: $counts,
                    resumes: $resumes,
                    list: $list,
                    proof: $crate::program::instance::proof!($($proof)?),
                    colour: $colour,
                    why_absent: $why_absent,
                    summary: $summary,
                    explain: $explain,
                    path: $path,
                    rounding: $rounding,
                    breaks: $breaks,
                },
                &$over,
            ) }),*];

        $($(#[doc = $doc])* pub const $kernel: Kernel = Kernel::at(&PROGRAM, Index::$kernel as usize);)*
    };
}
pub(crate) use kernels;

macro_rules! proof {
    () => {
        $crate::program::kernel::Proof::NONE
    };
    ($proof:expr) => {
        $proof
    };
}
pub(crate) use proof;

macro_rules! twin {
    (element $module:ident) => {
        $crate::program::Twin::Element { f32: super::$module::$module::<f32>, f64: super::$module::$module::<f64> }
    };
    (pass $module:ident) => {
        $crate::program::Twin::Pass(super::$module::$module)
    };
}
pub(crate) use twin;
