//! A pass of a kernel whose elements do not read each other, on all cores.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use super::guest::{Failed, OnElement};
use super::rows::count_tags;
use super::{CpuExecutor, ELEMENTS_PER_TASK, Task};
use crate::numbers::parallel::for_chunks;
use crate::program::Kernel;
use crate::program::kernel::Precision;
use crate::scene_data::SceneData;
use crate::tables::kernel::Role;

impl<R: Precision> CpuExecutor<R> {
    /// Runs a kernel on each element of every task with work for it; returns the number of these elements.
    pub(super) fn run_elements(&mut self, kernel: Kernel, scene: &SceneData) -> Result<u64, Failed> {
        let program = self.plan.program;
        let course = program.courses.iter().position(|c| c.stream.info().elements.name == kernel.instance().over.name);
        let tag = course.and_then(|course| self.tag(&program.courses[course]));
        let takes_all = kernel.takes().is_empty();
        let is_first = scene.features.eye_rays && kernel.role() == Role::Whole;
        let set = program.elements.iter().position(|e| e.name == kernel.instance().over.name);
        let Some(rows) = set.map(|set| &mut self.rows[set]) else { return Ok(0) };
        let Some(on_element) = OnElement::<R>::new(kernel, &self.interpreted, &rows.layout) else { return Ok(0) };
        let stride = rows.layout.stride.max(1);
        let (width, elements) = rows.size.map_or((1, 0), |size| (size.width as usize, size.count as usize));
        let size = rows.size.map_or([1, 1], |size| [size.width, size.height]);
        // A device launches a kernel with a list on the elements in its states only. Twins have no work for others anyway.
        let only = tag.filter(|_| on_element.is_interpreted() && scene.features.live_lists && kernel.list().is_some());
        // Elements without states have no counts.
        let counts = match course {
            Some(course) if tag.is_some() => self.counts[course].as_mut_slice(),
            _ => &mut [],
        };
        let counts = counts.iter_mut().map(Some).chain(std::iter::repeat_with(|| None));
        let mut tasks: Vec<Task<R::Bits>> = rows
            .texels
            .chunks_mut(ELEMENTS_PER_TASK * stride)
            .zip(counts)
            .enumerate()
            .filter(|(_, (_, counts))| takes_all || is_first || counts.as_ref().is_some_and(|c| kernel.live(c) > 0))
            .map(|(task, (texels, counts))| (task * ELEMENTS_PER_TASK, texels, counts))
            .collect();
        let in_task = |first: usize, texels: &[R::Bits]| (texels.len() / stride).min(elements.saturating_sub(first));
        let calls = tasks.iter().map(|(first, texels, _)| in_task(*first, texels) as u64).sum();
        // Of the failures, that of the first element. After one, no other element is begun.
        let failed: Mutex<Option<(usize, Failed)>> = Mutex::new(None);
        let has_failed = AtomicBool::new(false);
        for_chunks(&mut tasks, 1, |_, tasks| {
            for (first, texels, counts) in tasks {
                let last = *first + in_task(*first, texels);
                let mut runner = on_element.runner(scene, size);
                for (row, element) in texels.chunks_exact_mut(stride).zip(*first..last) {
                    if has_failed.load(Ordering::Relaxed) {
                        break;
                    }
                    if only.is_some_and(|tag| !kernel.takes().contains(&R::bits_to_u32(row[tag]))) {
                        continue;
                    }
                    let (x, y) = ((element % width) as u32, (element / width) as u32);
                    if let Err(why) = runner.run(row, x, y) {
                        has_failed.store(true, Ordering::Relaxed);
                        let mut first = failed.lock().unwrap_or_else(PoisonError::into_inner);
                        if first.as_ref().is_none_or(|(other, _)| element < *other) {
                            *first = Some((element, why));
                        }
                        break;
                    }
                }
                if let (Some(counts), Some(tag)) = (counts, tag) {
                    **counts = count_tags::<R>(texels, stride, tag, program.states);
                }
            }
        });
        let failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
        failed.map_or(Ok(calls), |(_, failed)| Err(failed))
    }
}
