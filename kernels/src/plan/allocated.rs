//! What a run allocates: sets of elements, streams, and buffers.

use std::collections::BTreeSet;

use super::check::check_list;
use super::{DrawnPlan, Limits, PlanError, Planned, PlannedSet};
use crate::options::scene_data::SceneDataKind;
use crate::program::Program;
use crate::program::live::{LIVE_RAYS, live_bytes};
use crate::program::sizes::{TooMany, derive};
use crate::scene_data::SceneData;
use crate::shader::LAUNCH;
use crate::shared::address::list_side;
use crate::tables::elements::{Count, Elements, Size};
use crate::tables::sizes::{COUNT_SLOT_BYTES, COUNT_SLOTS, fill_bytes, given_bytes};
use crate::tables::stream::Stream;

/// What a run allocates.
pub(crate) struct Allocated {
    pub(crate) sets: Vec<PlannedSet>,
    pub(crate) streams: Vec<Planned<Stream>>,
    pub(crate) buffers: Vec<Planned<&'static str>>,
}

impl Allocated {
    /// For a run of rays; `given` by the caller or not. The first of the sets is theirs.
    pub(crate) fn new(
        program: &'static Program,
        sets: Vec<PlannedSet>,
        bound: &BTreeSet<&str>,
        data: &SceneData,
        given: bool,
        limits: &Limits,
        drawn: Option<&DrawnPlan>,
    ) -> Result<Self, PlanError> {
        let size = main_size(&sets);
        if let Some(drawn) = drawn {
            let mut streams = planned_streams(program, &sets, bound);
            let mut buffers = planned_buffers(program, bound, data, limits)?;
            streams.iter_mut().for_each(|stream| stream.bytes = drawn.stream_bytes(stream.what, size));
            buffers.extend(drawn.housekeeping(size));
            return Ok(Self { sets, streams, buffers });
        }
        let mut all = Self::of_sets(program, sets, bound, data, limits)?;
        if given {
            let inputs = program.course().map_or(&[][..], |course| course.inputs).iter();
            let inputs = inputs.filter(|stream| bound.contains(stream.name()));
            let bytes = inputs.map(|&stream| given_bytes(stream, size.width, size.height)).sum();
            all.buffers.push(Planned { what: "given", bytes });
        }
        Ok(all)
    }

    /// For sets of these sizes, of which the first is the main one.
    pub(crate) fn of_sets(
        program: &'static Program,
        sets: Vec<PlannedSet>,
        bound: &BTreeSet<&str>,
        data: &SceneData,
        limits: &Limits,
    ) -> Result<Self, PlanError> {
        let (size, live) = (main_size(&sets), live_texels(program, &sets));
        let streams = planned_streams(program, &sets, bound);
        let mut buffers = planned_buffers(program, bound, data, limits)?;
        buffers.extend(housekeeping(program, bound, live));
        buffers.push(Planned { what: "fill", bytes: fill_bytes(size, sets.len(), program.streams) });
        if !data.inputs.is_empty() {
            let bytes = data.inputs.iter().map(|input| given_bytes(input.stream, input.width, input.height)).sum();
            buffers.push(Planned { what: "given", bytes });
        }
        Ok(Self { sets, streams, buffers })
    }
}

/// The sets of a program whose image has this size, of which the sizes of some others are known.
pub(crate) fn sets_of(
    program: &'static Program,
    image: Size,
    others: &[(&'static Elements, Size)],
    side: u32,
) -> Result<Vec<PlannedSet>, TooMany> {
    let known = |what: &&'static Elements| match what.count {
        Count::Image => Some(image),
        _ => others.iter().find(|(set, _)| set.name == what.name).map(|&(_, size)| size),
    };
    let mut sizes: Vec<_> = program.elements.iter().map(known).collect();
    derive(program, &mut sizes, side)?;
    Ok(program.elements.iter().zip(sizes).map(|(&what, size)| PlannedSet { what, size }).collect())
}

/// The size of the main set.
fn main_size(sets: &[PlannedSet]) -> Size {
    sets.first().and_then(|set| set.size).unwrap_or(Size { width: 1, height: 1, count: 0 })
}

/// Texels of the largest set whose elements may be listed: those with states.
pub(crate) fn live_texels(program: &Program, sets: &[PlannedSet]) -> u64 {
    let has_states = |set: &&PlannedSet| program.course_of(set.what).is_some();
    sets.iter().filter(has_states).filter_map(|set| set.size).map(|size| size.texels()).max().unwrap_or(0)
}

fn planned_streams(program: &'static Program, sets: &[PlannedSet], bound: &BTreeSet<&str>) -> Vec<Planned<Stream>> {
    let bytes = |stream: Stream| {
        let size = sets.iter().find(|set| set.what.name == stream.info().elements.name).and_then(|set| set.size);
        size.and_then(|size| stream.bytes(size.texels())).unwrap_or(0)
    };
    let bound = program.streams().filter(|stream| bound.contains(stream.name()));
    bound.map(|what| Planned { what, bytes: bytes(what) }).collect()
}

fn planned_buffers(
    program: &Program,
    bound: &BTreeSet<&str>,
    data: &SceneData,
    limits: &Limits,
) -> Result<Vec<Planned<&'static str>>, PlanError> {
    let mut buffers = Vec::new();
    for info in program.buffers.iter().filter(|b| bound.contains(b.name)) {
        let mut bytes = info.contents(data).len() as u64;
        if !info.is_uniform {
            check_list(info.name, bytes, data.features.scene_data, limits)?;
            if data.features.scene_data == SceneDataKind::Textures {
                bytes = 4 * list_side(bytes / 4).pow(2);
            }
        }
        buffers.push(Planned { what: info.name, bytes });
    }
    Ok(buffers)
}

/// The buffers in which the GPU executor counts and lists elements, as far as kernels bind them.
fn housekeeping(program: &'static Program, bound: &BTreeSet<&str>, texels: u64) -> Vec<Planned<&'static str>> {
    let slots = COUNT_SLOTS * COUNT_SLOT_BYTES;
    let mut all = Vec::new();
    let mut add = |what, bytes| all.push(Planned { what, bytes });
    add("sent", slots);
    add("sent_copy", slots);
    if bound.contains(LAUNCH) {
        add(LAUNCH, slots);
    }
    for list in program.lists.iter().filter(|list| bound.contains(list.name)) {
        for slots in list.slots {
            add(slots, COUNT_SLOTS * COUNT_SLOT_BYTES / 2 + COUNT_SLOT_BYTES);
        }
    }
    if bound.contains(LIVE_RAYS) {
        add(LIVE_RAYS, live_bytes(program, texels));
    }
    all
}
