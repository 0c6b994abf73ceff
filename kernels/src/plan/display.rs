//! The plan as `raystep plan` prints it.

use std::fmt;

use super::Plan;
use super::omitted::{NotNeeded, Omitted};
use super::structure::Structure;
use crate::fragment::depth_of;
use crate::numbers::bytes::Bytes;
use crate::options::mapping::{Fragment, Update};
use crate::options::scene_data::SceneDataKind;
use crate::program::Program;
use crate::shader::{Binding, Resource};
use crate::shared::address::list_side;
use crate::tables::stream::Stream;

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_head(f)?;
        self.write_tables(f)
    }
}

/// Describes an element of a buffer, including the buffers that the GPU executor keeps for itself.
pub(crate) fn element(program: &Program, name: &str) -> &'static str {
    match (program.buffer(name), name) {
        (Some(info), _) => info.element,
        (None, "fill") => "u32 texels: initial contents of streams",
        (None, "given") => "input rays: initial contents of some streams",
        (None, "live_rays") => "u32 per ray in the list of a kernel: x and y << 16",
        (None, "sent") => "256 bytes per pass: number of rays that the pass moved to each state",
        (None, "depth") => "f32 per ray: the kernel that takes it, as a depth",
        (None, "queries") => "8 bytes per pass: whether its last draw wrote a fragment",
        (None, "queries_copy") => "copy of queries, for the host to read",
        (None, "sent_copy") => "copy of sent, for the host to read",
        (None, _) => "256 bytes per pass of its kernel: its arguments, and the position of its list",
    }
}

/// A plan, and the sizes of the grid or BVH that was built for it.
#[derive(Clone, Copy, Debug)]
pub struct PlanText<'a>(pub &'a Plan, pub &'a Structure);

impl fmt::Display for PlanText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.write_head(f)?;
        writeln!(f, "{}", self.1)?;
        self.0.write_tables(f)
    }
}

impl Plan {
    fn write_head(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.traces_rays() {
            return writeln!(
                f,
                "{} x {} texels, {} rays, {} triangles",
                self.width, self.height, self.rays, self.triangles
            );
        }
        writeln!(f, "{}: {}", self.program.name, self.program.summary)?;
        writeln!(f, "\nelements")?;
        for set in &self.sets {
            match set.size {
                Some(size) => {
                    writeln!(f, "  {:<19} {:>10}  {} x {} texels", set.what.name, size.count, size.width, size.height)?;
                }
                None => writeln!(f, "  {:<19} {:>10}  counted by the run", set.what.name, "?")?,
            }
        }
        Ok(())
    }

    /// Whether its elements are rays in states. Elements of a user's program without a scene are none.
    #[must_use]
    pub fn traces_rays(&self) -> bool {
        let reads_none = !self.program.files.is_empty() && self.program.buffers.is_empty();
        self.program.course().is_some() && !reads_none
    }

    /// Whether its lists of scene data are in textures.
    fn has_textures(&self) -> bool {
        self.features.scene_data == SceneDataKind::Textures
    }

    /// What a binding of one of its variants is on the device.
    pub(crate) fn kind_of(&self, binding: &Binding) -> &'static str {
        match binding.resource {
            Resource::ReadStream(_) | Resource::WriteStream { .. } | Resource::WriteStreams { .. } => "stream",
            Resource::Uniform | Resource::Launch => "uniform",
            Resource::Storage if self.has_textures() => "texture",
            Resource::Storage | Resource::Live { .. } => "buffer",
            Resource::List => "texture",
        }
    }

    /// The draws of each kernel, if they are drawn.
    fn write_draws(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(drawn) = &self.drawn else { return Ok(()) };
        let Fragment { targets, update, cull, until } = drawn.how;
        writeln!(f, "\ndraws (targets {targets}, update {update}, cull {cull}, until {until})")?;
        for kernel in &drawn.kernels {
            writeln!(f, "  {}", kernel.kernel.name())?;
            let copied = drawn.copied_bytes(kernel.kernel, self.size());
            match update {
                Update::Copy if copied > 0 => {
                    writeln!(f, "    copy  {:<28} {}", names(&kernel.updates), Bytes(copied))?;
                }
                Update::Swap if !kernel.updates.is_empty() => writeln!(f, "    swap  {}", names(&kernel.updates))?,
                _ => {}
            }
            if drawn.depths.is_some() {
                writeln!(f, "    depth {:<28} drawn where it is {:?}", "from state", depth_of(kernel.kernel))?;
            }
            for draw in &kernel.draws {
                let reads: Vec<Stream> = draw.reads().collect();
                writeln!(f, "    draw  {:<28} reads {}", names(&draw.targets), names(&reads))?;
            }
        }
        Ok(())
    }

    fn write_tables(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", NotNeeded(&self.left_out))?;
        writeln!(f, "\nkernels")?;
        for variant in &self.variants {
            let info = variant.kernel.info();
            let states: Vec<_> = variant.kernel.takes().iter().map(|&t| self.program.states.name(t)).collect();
            let over = match states.as_slice() {
                [] => variant.kernel.instance().over.name.to_owned(),
                states => format!("{} in {}", variant.kernel.instance().over.name, states.join(", ")),
            };
            writeln!(f, "  {:<14} {} ({over})", variant.kernel.name(), info.summary)?;
            for binding in &variant.bindings {
                let access = match (binding.reads, binding.writes) {
                    (true, true) => "updates",
                    (false, true) => "writes ",
                    _ => "reads  ",
                };
                writeln!(f, "    {access} {:<7} {}", self.kind_of(binding), binding.name)?;
            }
        }
        self.write_draws(f)?;
        writeln!(f, "\nstreams")?;
        for s in &self.streams {
            let info = s.what.info();
            writeln!(
                f,
                "  {:<19} {:>10}  {}  [{}]",
                info.name,
                Bytes(s.bytes).to_string(),
                info.layer_names(),
                info.unit
            )?;
        }
        for group in &self.sharing.groups {
            writeln!(f, "  in one texture, as a kernel writes more than the device binds: {}", names(group))?;
        }
        writeln!(f, "\nbuffers{}", if self.has_textures() { ", and lists in textures" } else { "" })?;
        for b in &self.buffers {
            write!(f, "  {:<19} {:>10}  {}", b.what, Bytes(b.bytes).to_string(), element(self.program, b.what))?;
            if self.has_textures() && self.program.buffer(b.what).is_some_and(|info| !info.is_uniform) {
                let side = list_side(b.bytes / 4);
                write!(f, "; {side} x {side} texels")?;
            }
            writeln!(f)?;
        }
        writeln!(f, "  {:<19} {:>10}", "total", Bytes(self.bytes()).to_string())?;
        write!(f, "{}", Omitted(&self.left_out))
    }
}

fn names(streams: &[Stream]) -> String {
    streams.iter().map(|stream| stream.name()).collect::<Vec<_>>().join(", ")
}
