//! Counters of each pass and the lists of live rays.

use super::buffers::{labelled_buffer, own_buffer};
use crate::plan::Plan;
use crate::program::live::LIVE_RAYS;
use crate::program::schedule::Call;
use crate::program::{Kernel, Program};
use crate::shader::{Binding, LAUNCH, MOST_ASSERTIONS, Resource};
use crate::shared;
use crate::shared::constants::{LIST_GROUPS, LIST_SIDE};
use crate::tables::elements::{Elements, Size};
use crate::tables::kernel::Launch;
use crate::tables::sizes::{COUNT_SLOT_BYTES, COUNT_SLOTS};
use crate::tables::state::{StateCounts, Tag};

/// Words of a list's slot that kernels bind.
const LIST_WORDS: u64 = 8;

/// Rays per row of an indirect dispatch.
const RAYS_A_ROW: u32 = LIST_SIDE * LIST_SIDE * LIST_GROUPS;

/// Rows of an indirect dispatch that a list needs.
fn rows_of(rays: u32) -> u32 {
    rays.div_ceil(RAYS_A_ROW)
}

/// One kernel's list.
struct List {
    /// The kernel whose list it is.
    kernel: Kernel,
    /// Slots of even and odd passes of the kernel within a batch: one is read while the other is written.
    slots: [wgpu::Buffer; 2],
    /// How often the kernel has run: its parity tells which half of its part of `live_rays` holds its list.
    turn: u64,
    /// Where its part of `live_rays` begins, in words, and how long a half of it is.
    first: u32,
    texels: u32,
}

impl List {
    /// Offset of the list of a kernel's pass in `live_rays`, in words.
    fn first_ray(&self, turn: u64) -> u32 {
        self.first + (turn % 2) as u32 * self.texels
    }
}

/// The buffers, and the list of each kernel.
pub(super) struct Books {
    pub(super) sent: wgpu::Buffer,
    pub(super) copy: wgpu::Buffer,
    /// Launch parameters, if a kernel binds them.
    launches: Option<wgpu::Buffer>,
    lists: Vec<Option<List>>,
    live_rays: Option<wgpu::Buffer>,
    program: &'static Program,
}

/// A copy of the lists, made after some pass.
pub(super) struct KeptLists {
    turns: Vec<u64>,
    rays: Vec<Option<wgpu::Buffer>>,
}

impl KeptLists {
    /// Bytes they occupy on the GPU.
    pub(super) fn bytes(&self) -> u64 {
        self.rays.iter().flatten().map(wgpu::Buffer::size).sum()
    }
}

/// Where a pass finds its slots.
#[derive(Clone, Debug, Default)]
pub(super) struct Place {
    /// Index of the pass within the batch.
    sent: u32,
    /// Index among the passes of its own kernel within the batch.
    own: u32,
    /// For each list that it sends rays to, the index among the passes of that list's kernel within the batch.
    next: Vec<u32>,
    list: Option<usize>,
}

impl Place {
    /// The same for another slot.
    pub(super) fn at_slot(&self, slot: u32) -> Self {
        Self { sent: slot, ..self.clone() }
    }

    /// Which slots its bind group has: bit i is the parity of list i.
    pub(super) fn parities(&self) -> u64 {
        self.next.iter().rev().fold(0, |parities, next| 2 * parities + u64::from(next % 2))
    }

    /// Threads launched by the pass, given the rays in each state before it.
    pub(super) fn threads(&self, kernel: Kernel, before: &StateCounts, size: Size) -> u64 {
        match self.list {
            Some(_) => u64::from(rows_of(kernel.live(before))) * u64::from(RAYS_A_ROW),
            None => kernel.groups(size).map(u64::from).iter().product::<u64>() * threads_of(kernel),
        }
    }

    /// Dynamic offset of a binding, by name; `None` if it has none.
    pub(super) fn offset(&self, program: &Program, name: &str) -> Option<u32> {
        let slot = match name {
            "sent" | LAUNCH => self.sent,
            "own_list" => self.own / 2,
            _ => self.next.get(list_named(program, name)?).copied()? / 2,
        };
        Some(slot * COUNT_SLOT_BYTES as u32)
    }
}

impl Books {
    pub(super) fn new(device: &wgpu::Device, plan: &Plan) -> Self {
        use wgpu::BufferUsages as U;
        let buffer = |name: &'static str, usage| own_buffer(device, plan, name, usage);
        let slots = |name| buffer(name, U::STORAGE | U::INDIRECT | U::COPY_SRC | U::COPY_DST);
        let kernels = plan.schedule.kernels();
        let list = |index: usize| {
            let [even, odd] = plan.program.lists[index].slots;
            let kernel = kernels.iter().copied().find(|kernel| kernel.list() == Some(index))?;
            let (texels, turn) = (plan.live_texels() as u32, 0);
            Some(List { kernel, slots: [slots(even)?, slots(odd)?], turn, first: 2 * index as u32 * texels, texels })
        };
        let own = |name, usage| labelled_buffer(device, &plan.label(name), COUNT_SLOTS * COUNT_SLOT_BYTES, usage);
        Self {
            sent: own("sent", U::STORAGE | U::COPY_SRC | U::COPY_DST),
            copy: own("sent_copy", U::COPY_DST | U::MAP_READ),
            launches: buffer(LAUNCH, U::UNIFORM | U::COPY_DST),
            lists: (0..plan.program.lists.len()).map(list).collect(),
            live_rays: buffer(LIVE_RAYS, U::STORAGE | U::COPY_SRC | U::COPY_DST),
            program: plan.program,
        }
    }

    /// Names and sizes in bytes of its buffers.
    pub(super) fn allocated(&self) -> Vec<(&'static str, u64)> {
        let mut all = vec![("sent", self.sent.size()), ("sent_copy", self.copy.size())];
        all.extend(self.launches.iter().map(|b| (LAUNCH, b.size())));
        for (list, info) in self.lists.iter().zip(self.program.lists) {
            let Some(list) = list else { continue };
            all.extend(info.slots.into_iter().zip(&list.slots).map(|(name, b)| (name, b.size())));
        }
        all.extend(self.live_rays.iter().map(|b| (LIVE_RAYS, b.size())));
        all
    }

    /// The resource bound to a name of a kernel, in the bind group for these slots; see [`Place::parities`].
    pub(super) fn binding(&self, kernel: Kernel, name: &str, parities: u64) -> Option<wgpu::BindingResource<'_>> {
        let parity = |list: usize| parities >> list & 1 == 1;
        let slots = |list: usize, is_odd: bool| Some(&self.lists.get(list)?.as_ref()?.slots[usize::from(is_odd)]);
        let buffer = match name {
            "sent" => &self.sent,
            LAUNCH => self.launches.as_ref()?,
            "own_list" => kernel.list().and_then(|list| slots(list, !parity(list)))?,
            LIVE_RAYS => return self.live_rays.as_ref().map(wgpu::Buffer::as_entire_binding),
            _ => list_named(self.program, name).and_then(|list| slots(list, parity(list)))?,
        };
        let bytes = match name {
            LAUNCH => size_of::<shared::launch::Launch>() as u64,
            "sent" => COUNT_SLOT_BYTES,
            _ => LIST_WORDS * 4,
        };
        let size = std::num::NonZeroU64::new(bytes);
        Some(wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size }))
    }

    /// The buffers with slots in which a pass counts rays. A batch's only pass has the first slot of each.
    pub(super) fn slots(&self) -> impl Iterator<Item = &wgpu::Buffer> {
        std::iter::once(&self.sent).chain(self.lists.iter().flatten().flat_map(|list| &list.slots))
    }

    /// Empties all lists.
    pub(super) fn clear(&mut self) {
        self.lists.iter_mut().flatten().for_each(|list| list.turn = 0);
    }

    /// Copies the lists, given the number of rays in each state.
    pub(super) fn keep(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        counts: &StateCounts,
    ) -> KeptLists {
        let none = || self.lists.iter().map(|_| None).collect();
        let mut kept = KeptLists { turns: vec![0; self.lists.len()], rays: none() };
        for (index, list) in self.lists.iter().enumerate() {
            let (Some(list), Some(live_rays)) = (list, &self.live_rays) else { continue };
            kept.turns[index] = list.turn;
            let size = 4 * u64::from(list.kernel.live(counts));
            if size > 0 {
                let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
                let label = format!("{}.{}, kept", self.program.name, self.program.lists[index].name);
                let label = Some(label.as_str());
                let rays =
                    device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false });
                let first = 4 * u64::from(list.first_ray(list.turn));
                encoder.copy_buffer_to_buffer(live_rays, first, &rays, 0, size);
                kept.rays[index] = Some(rays);
            }
        }
        kept
    }

    /// Copies the lists back.
    pub(super) fn restore(&mut self, encoder: &mut wgpu::CommandEncoder, kept: &KeptLists) {
        for (index, list) in self.lists.iter_mut().enumerate() {
            let Some(list) = list else { continue };
            list.turn = kept.turns[index];
            if let (Some(live_rays), Some(rays)) = (&self.live_rays, &kept.rays[index]) {
                let first = 4 * u64::from(list.first_ray(list.turn));
                encoder.copy_buffer_to_buffer(rays, 0, live_rays, first, rays.size());
            }
        }
    }

    /// Rebuilds the lists of a set from the tags, after the stream of its states was replaced from outside.
    pub(super) fn relist(&mut self, queue: &wgpu::Queue, of: &Elements, tags: &[Tag], width: u32) {
        let Some(live_rays) = &self.live_rays else { return };
        for list in self.lists.iter().flatten().filter(|list| list.kernel.instance().over.name == of.name) {
            let ids: Vec<u32> = (0u32..)
                .zip(tags)
                .filter(|(_, tag)| list.kernel.takes().contains(tag))
                .map(|(i, _)| (i % width) | ((i / width) << 16))
                .collect();
            if !ids.is_empty() {
                let first = 4 * u64::from(list.first_ray(list.turn));
                queue.write_buffer(live_rays, first, bytemuck::cast_slice(&ids));
            }
        }
    }

    /// Lays out a batch: the slots of each pass, initialised for reading and for adding to. `sizes` are the sizes of
    /// the sets that the kernels are launched over.
    pub(super) fn lay_out(
        &mut self,
        queue: &wgpu::Queue,
        calls: &[Call],
        counts: &StateCounts,
        sizes: &[Size],
    ) -> Vec<Place> {
        // As many as have a size.
        let calls = &calls[..calls.len().min(sizes.len())];
        let launch = |(call, size): (&Call, &Size)| shared::launch::Launch::new(size.count, size.width, call.parameter);
        self.write_launches(queue, calls.iter().zip(sizes).map(launch));
        let mut run = vec![0u32; self.lists.len()];
        let mut places = Vec::with_capacity(calls.len());
        for (sent, &Call { kernel, .. }) in (0..).zip(calls) {
            let list = kernel.list().filter(|&l| self.lists[l].is_some());
            let mut place = Place { sent, own: 0, next: run.clone(), list };
            if let Some(list) = list {
                place.own = run[list];
                run[list] += 1;
                place.next[list] = run[list];
            }
            places.push(place);
        }
        for (index, &turns) in run.iter().enumerate() {
            let Some(list) = &mut self.lists[index] else { continue };
            let first = [0, 1].map(|i| list.first_ray(list.turn + i));
            let live = list.kernel.live(counts);
            for (parity, slots) in list.slots.iter().enumerate() {
                let count = (turns as usize + 2 - parity) / 2;
                let mut words = vec![0u32; count * COUNT_SLOT_BYTES as usize / 4];
                for (i, slot) in words.chunks_exact_mut(COUNT_SLOT_BYTES as usize / 4).enumerate() {
                    let rays = if 2 * i + parity == 0 { live } else { 0 };
                    slot[..5].copy_from_slice(&[LIST_GROUPS, rows_of(rays), 1, rays, first[parity]]);
                }
                queue.write_buffer(slots, 0, bytemuck::cast_slice(&words));
            }
            list.turn += u64::from(turns);
        }
        places
    }

    /// Writes the parameters of the next dispatches of the only pass of a batch, each of which begins with such a block.
    pub(super) fn begin_at(&self, queue: &wgpu::Queue, parameter: u32, size: Size, first_blocks: &[u32]) {
        let launch = shared::launch::Launch::new(size.count, size.width, parameter);
        let launches = first_blocks.iter().map(|&first_block| shared::launch::Launch { first_block, ..launch });
        self.write_launches(queue, launches);
    }

    /// Writes the parameters of launches, each to its own slot.
    fn write_launches(&self, queue: &wgpu::Queue, launches: impl ExactSizeIterator<Item = shared::launch::Launch>) {
        if let Some(buffer) = &self.launches {
            let mut slots = vec![0; launches.len() * COUNT_SLOT_BYTES as usize];
            for (launch, slot) in launches.zip(slots.chunks_mut(COUNT_SLOT_BYTES as usize)) {
                slot[..size_of_val(&launch)].copy_from_slice(bytemuck::bytes_of(&launch));
            }
            queue.write_buffer(buffer, 0, &slots);
        }
    }

    /// The indirect arguments of a pass: buffer and offset.
    pub(super) fn arguments(&self, place: &Place) -> Option<(&wgpu::Buffer, u64)> {
        let list = self.lists[place.list?].as_ref()?;
        Some((&list.slots[place.own as usize % 2], u64::from(place.own / 2) * COUNT_SLOT_BYTES))
    }
}

/// The list whose slots are bound under this name.
fn list_named(program: &Program, name: &str) -> Option<usize> {
    program.lists.iter().position(|list| list.name == name)
}

/// Whether there is one per pass, at an offset of its own.
pub(super) fn is_dynamic(binding: &Binding) -> bool {
    match binding.resource {
        Resource::Launch => true,
        Resource::Live { .. } => binding.name != LIVE_RAYS,
        _ => false,
    }
}

/// Workgroups of each dispatch of a kernel that is launched over a list, if one dispatch may take so much work: none if a
/// single one does.
pub(super) fn blocks_a_dispatch(kernel: Kernel, size: Size, work_a_dispatch: u64) -> Option<u32> {
    let Launch::List { each, weight } = kernel.info().launch else { return None };
    let most = work_a_dispatch / u64::from(weight);
    let a_block = u64::from(kernel.workgroup()) * u64::from(each);
    // Along one axis, so that no dispatch has a workgroup of the next one.
    (u64::from(size.count) > most).then(|| (most / a_block).clamp(1, 65_535) as u32)
}

/// Threads per workgroup of a kernel.
fn threads_of(kernel: Kernel) -> u64 {
    let workgroup = u64::from(kernel.workgroup());
    match kernel.info().launch {
        Launch::List { .. } => workgroup,
        Launch::Whole | Launch::Bands => workgroup * workgroup,
    }
}

/// Counts after a pass, from those before it and the numbers of rays it sent.
pub(super) fn counts_after(kernel: Kernel, before: &StateCounts, sent: &StateCounts) -> StateCounts {
    let mut after = before.clone();
    after.clear(kernel.takes().iter().copied());
    match kernel.sends_all_to() {
        Some(to) => after.add(to, kernel.live(before)),
        None => after.iter_mut().zip(sent).for_each(|(a, s)| *a += s),
    }
    after
}

/// Counts after a pass whose elements were counted anew.
pub(super) fn counted_anew(kernel: Kernel, before: &StateCounts, counted: &StateCounts) -> StateCounts {
    let mut after = before.clone();
    after.clear(kernel.course().into_iter().flat_map(|course| kernel.program().states_of(course)));
    after.iter_mut().zip(counted).for_each(|(a, n)| *a += n);
    after
}

/// The words of a pass that users' kernels write, last first: the line of a loop that did not end, and for each assertion how
/// many elements it did not hold for.
pub(super) type Wrong = [u32; 1 + MOST_ASSERTIONS];

/// These words of each pass.
pub(super) fn read_wrong(bytes: &[u8]) -> Vec<Wrong> {
    let words = |slot: &[u8]| {
        let mut last = slot.rchunks_exact(4).map(|word| word.try_into().map_or(0, u32::from_le_bytes));
        std::array::from_fn(|_| last.next().unwrap_or(0))
    };
    bytes.chunks_exact(COUNT_SLOT_BYTES as usize).map(words).collect()
}

pub(super) fn read_sent(bytes: &[u8], states: usize) -> Vec<StateCounts> {
    let word = |word: &[u8]| word.try_into().map_or(0, u32::from_le_bytes);
    bytes
        .chunks_exact(COUNT_SLOT_BYTES as usize)
        .map(|slot| slot.chunks_exact(4).take(states).map(word).collect())
        .collect()
}
