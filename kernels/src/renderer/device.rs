//! The device that passes run on. Everything that differs between devices is here, so that few other files mention
//! the feature `gpu`.

#![cfg_attr(not(feature = "gpu"), expect(unused_variables, reason = "only a GPU uses some of them"))]

use std::future::poll_fn;
use std::sync::Arc;
use std::task::Poll;

use super::RenderError;
use crate::executor::PassResult;
use crate::executor::cpu::CpuExecutor;
#[cfg(feature = "gpu")]
use crate::executor::gpu::fragment::{self, FragmentExecutor};
#[cfg(feature = "gpu")]
use crate::executor::gpu::{Gpu, GpuExecutor, MOST_PASSES, Snapshot};
use crate::executor::sizes::Sizes;
use crate::options::Options;
use crate::plan::{Limits, Plan};
use crate::program::Kernel;
use crate::program::schedule::Call;
use crate::scene_data::SceneData;
use crate::tables::elements::{Elements, Size};
use crate::tables::kernel::Launch;
use crate::tables::state::StateCounts;
use crate::tables::stream::{Region, Stream, StreamData};

/// The device that passes run on.
#[derive(Clone)]
pub enum Device {
    /// A wgpu device.
    #[cfg(feature = "gpu")]
    Gpu(Arc<Gpu>),
    /// The twins in f32. The clock, in nanoseconds from any start, times passes if there is one.
    Cpu(Option<fn() -> u64>),
    /// The twins in f64, from the same f32 scene and camera.
    CpuF64(Option<fn() -> u64>),
}

impl Device {
    /// The default device, given the best adapter: that adapter, unless it is software, or only draws. In that case the
    /// twins are faster; they use `clock`.
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn auto(gpu: Arc<Gpu>, clock: Option<fn() -> u64>) -> Self {
        if gpu.is_software() || !gpu.computes { Self::Cpu(clock) } else { Self::Gpu(gpu) }
    }

    /// Whether it is a wgpu device.
    #[must_use]
    pub fn is_gpu(&self) -> bool {
        !matches!(self, Self::Cpu(_) | Self::CpuF64(_))
    }

    /// Whether it is a GPU in hardware.
    pub(crate) fn is_hardware(&self) -> bool {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => !gpu.is_software(),
            Self::Cpu(_) | Self::CpuF64(_) => false,
        }
    }

    /// Its limits.
    #[must_use]
    pub fn limits(&self) -> Limits {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => Limits::from(&**gpu),
            Self::Cpu(_) | Self::CpuF64(_) => Limits::CPU,
        }
    }
}

/// Runs passes on one device.
pub(super) enum Executor {
    #[cfg(feature = "gpu")]
    Gpu(Box<GpuExecutor>),
    #[cfg(feature = "gpu")]
    Fragment(Box<FragmentExecutor>),
    Cpu(CpuExecutor<f32>),
    CpuF64(CpuExecutor<f64>),
}

/// The streams after some pass, kept on the device that they are from.
pub(super) enum Kept {
    #[cfg(feature = "gpu")]
    Gpu(Box<Snapshot>),
    #[cfg(feature = "gpu")]
    Fragment(Box<fragment::Snapshot>),
    Cpu(Box<CpuExecutor<f32>>),
    CpuF64(Box<CpuExecutor<f64>>),
}

impl Executor {
    /// Passes are timed if the options ask for it and the device has a clock. `given` are the input streams. An executor
    /// `beside` it has the same data on the same device.
    pub(super) async fn new(
        device: &Device,
        plan: &Arc<Plan>,
        data: &SceneData,
        options: &Options,
        given: &[StreamData],
        beside: Option<&Self>,
    ) -> Result<Self, RenderError> {
        let timed = options.timings;
        let timer = |clock: &Option<fn() -> u64>| clock.filter(|_| timed);
        Ok(match device {
            #[cfg(feature = "gpu")]
            Device::Gpu(gpu) if plan.drawn.is_some() => {
                let other = match beside {
                    Some(Self::Fragment(other)) => Some(&**other),
                    _ => None,
                };
                let mut executor = FragmentExecutor::new(gpu.clone(), plan, data, options, other).await?;
                executor.give(given);
                Self::Fragment(Box::new(executor))
            }
            #[cfg(feature = "gpu")]
            Device::Gpu(gpu) => {
                let other = match beside {
                    Some(Self::Gpu(other)) => Some(&**other),
                    _ => None,
                };
                let mut executor = GpuExecutor::beside(gpu.clone(), plan, data, timed, other).await?;
                executor.give(given);
                Self::Gpu(Box::new(executor))
            }
            Device::Cpu(clock) => Self::Cpu(CpuExecutor::new(plan, timer(clock))?),
            Device::CpuF64(clock) => Self::CpuF64(CpuExecutor::new(plan, timer(clock))?),
        })
    }

    /// Sets the input streams from now on; [`clear`](Self::clear) resets to them.
    pub(super) fn give(&mut self, given: &[StreamData]) {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.give(given),
            #[cfg(feature = "gpu")]
            Self::Fragment(e) => e.give(given),
            // They take them at every clear.
            Self::Cpu(_) | Self::CpuF64(_) => {}
        }
    }

    /// Takes over what depends on the camera.
    pub(super) fn set_view(&self, data: &SceneData) {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.set_view(data),
            #[cfg(feature = "gpu")]
            Self::Fragment(e) => e.set_view(data),
            // They are given the data with every pass.
            Self::Cpu(_) | Self::CpuF64(_) => {}
        }
    }

    /// Resets every stream to its initial value: the input streams to theirs, the others to unwritten values.
    pub(super) fn clear(&mut self, given: &[StreamData]) {
        match self {
            // It keeps copies of the input streams.
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => return e.clear(),
            #[cfg(feature = "gpu")]
            Self::Fragment(e) => return e.clear(),
            Self::Cpu(e) => e.clear(),
            Self::CpuF64(e) => e.clear(),
        }
        for data in given {
            // A plan for input rays has these streams.
            let _: bool = self.write(data);
        }
    }

    pub(super) fn is_gpu(&self) -> bool {
        !matches!(self, Self::Cpu(_) | Self::CpuF64(_))
    }

    /// Most passes per call of [`run`](Self::run).
    pub(super) fn most_passes(&self) -> usize {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(_) => MOST_PASSES,
            #[cfg(feature = "gpu")]
            Self::Fragment(e) => e.most_passes(),
            Self::Cpu(_) | Self::CpuF64(_) => 1,
        }
    }

    /// Whether a kernel is not submitted together with other passes.
    pub(super) fn is_alone(&self, kernel: Kernel) -> bool {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.is_alone(kernel),
            _ => kernel.info().launch == Launch::Bands,
        }
    }

    /// Runs these passes; on a CPU, only the first.
    pub(super) async fn run(
        &mut self,
        calls: &[Call],
        counts: &StateCounts,
        data: &SceneData,
    ) -> Result<Vec<PassResult>, RenderError> {
        Ok(match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.run(calls, counts).await?,
            #[cfg(feature = "gpu")]
            Self::Fragment(e) => e.run(calls).await?,
            Self::Cpu(e) => {
                let result = e.run(calls[0], data)?;
                let_others_run().await;
                vec![result]
            }
            Self::CpuF64(e) => {
                let result = e.run(calls[0], data)?;
                let_others_run().await;
                vec![result]
            }
        })
    }

    pub(super) fn health(&self) -> Result<(), RenderError> {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => Ok(e.health()?),
            #[cfg(feature = "gpu")]
            Self::Fragment(e) => Ok(e.health()?),
            Self::Cpu(_) | Self::CpuF64(_) => Ok(()),
        }
    }

    pub(super) fn size(&self, elements: &Elements) -> Option<Size> {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.size(elements),
            #[cfg(feature = "gpu")]
            Self::Fragment(e) => e.size(elements),
            Self::Cpu(e) => e.size(elements),
            Self::CpuF64(e) => e.size(elements),
        }
    }

    /// The current size of each set.
    pub(super) fn sizes(&self) -> Sizes {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.sizes(),
            #[cfg(feature = "gpu")]
            Self::Fragment(e) => e.sizes(),
            Self::Cpu(e) => e.sizes(),
            Self::CpuF64(e) => e.sizes(),
        }
    }

    pub(super) fn resize(&mut self, sizes: Sizes) -> Result<(), RenderError> {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.resize(sizes)?,
            #[cfg(feature = "gpu")]
            // All sets have their sizes from the plan.
            Self::Fragment(_) => {}
            Self::Cpu(e) => e.resize(sizes)?,
            Self::CpuF64(e) => e.resize(sizes)?,
        }
        Ok(())
    }

    pub(super) async fn read(&self, stream: Stream) -> Result<Option<StreamData>, RenderError> {
        Ok(match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.read(stream).await?,
            #[cfg(feature = "gpu")]
            Self::Fragment(e) => e.read(stream).await?,
            Self::Cpu(e) => e.read(stream),
            Self::CpuF64(e) => e.read(stream),
        })
    }

    pub(super) async fn read_texels(
        &self,
        streams: &[Stream],
        x: u32,
        y: u32,
    ) -> Result<Option<Vec<Vec<u32>>>, RenderError> {
        Ok(match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.read_texels(streams, x, y).await?,
            #[cfg(feature = "gpu")]
            Self::Fragment(e) => e.read_texels(streams, x, y).await?,
            Self::Cpu(e) => e.read_texels(streams, x, y),
            Self::CpuF64(e) => e.read_texels(streams, x, y),
        })
    }

    pub(super) async fn read_region(&self, stream: Stream, region: Region) -> Result<Option<StreamData>, RenderError> {
        Ok(match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.read_region(stream, region).await?,
            #[cfg(feature = "gpu")]
            Self::Fragment(e) => e.read_region(stream, region).await?,
            Self::Cpu(e) => e.read_region(stream, region),
            Self::CpuF64(e) => e.read_region(stream, region),
        })
    }

    /// Returns false if the plan left the stream out or the size differs.
    pub(super) fn write(&mut self, data: &StreamData) -> bool {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.write(data),
            #[cfg(feature = "gpu")]
            Self::Fragment(e) => e.write(data),
            Self::Cpu(e) => e.write(data),
            Self::CpuF64(e) => e.write(data),
        }
    }

    /// Replaces one component of one ray; on a GPU, this must not be its tag. Returns the number of rays in each state if
    /// that may have changed.
    pub(super) fn write_component(
        &mut self,
        stream: Stream,
        layer: usize,
        x: u32,
        y: u32,
        bits: u32,
    ) -> Option<StateCounts> {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => {
                e.write_component(stream, layer, x, y, bits);
                None
            }
            // Streams are written whole.
            #[cfg(feature = "gpu")]
            Self::Fragment(_) => None,
            Self::Cpu(e) => {
                e.write_component(stream, layer, x, y, bits);
                Some(e.counts())
            }
            Self::CpuF64(e) => {
                e.write_component(stream, layer, x, y, bits);
                Some(e.counts())
            }
        }
    }

    pub(super) async fn snapshot(&mut self, counts: &StateCounts) -> Result<Kept, RenderError> {
        Ok(match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => Kept::Gpu(Box::new(e.snapshot(counts).await?)),
            #[cfg(feature = "gpu")]
            Self::Fragment(e) => Kept::Fragment(Box::new(e.snapshot().await?)),
            Self::Cpu(e) => Kept::Cpu(Box::new(e.snapshot()?)),
            Self::CpuF64(e) => Kept::CpuF64(Box::new(e.snapshot()?)),
        })
    }

    /// Fails and changes nothing if the streams are kept on another device.
    pub(super) fn restore(&mut self, kept: &Kept) -> Result<(), RenderError> {
        match (self, kept) {
            #[cfg(feature = "gpu")]
            (Self::Gpu(e), Kept::Gpu(snapshot)) if snapshot.is_on(e.gpu()) => e.restore(snapshot)?,
            #[cfg(feature = "gpu")]
            (Self::Fragment(e), Kept::Fragment(snapshot)) if snapshot.is_on(e.gpu()) => e.restore(snapshot),
            (Self::Cpu(e), Kept::Cpu(kept)) => e.restore(kept)?,
            (Self::CpuF64(e), Kept::CpuF64(kept)) => e.restore(kept)?,
            _ => return Err(RenderError::OtherRun),
        }
        Ok(())
    }
}

impl Kept {
    /// Identity and bytes of each part.
    pub(super) fn parts(&self) -> Vec<(usize, u64)> {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(snapshot) => snapshot.parts().collect(),
            #[cfg(feature = "gpu")]
            Self::Fragment(snapshot) => snapshot.parts().collect(),
            Self::Cpu(executor) => vec![(std::ptr::from_ref(&**executor).addr(), executor.bytes())],
            Self::CpuF64(executor) => vec![(std::ptr::from_ref(&**executor).addr(), executor.bytes())],
        }
    }
}

/// Yields to the caller's executor once. A pass on a CPU takes its time, and an executor with one thread, such as that of
/// a browser's worker, serves its events in between. So should every other future between parts of long work.
pub fn let_others_run() -> impl Future<Output = ()> {
    let mut has_yielded = false;
    poll_fn(move |context| {
        if std::mem::replace(&mut has_yielded, true) {
            return Poll::Ready(());
        }
        context.waker().wake_by_ref();
        Poll::Pending
    })
}
