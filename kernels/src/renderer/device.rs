//! Where passes run. What differs between devices is here, so that few other files mention the feature `gpu`.

#![cfg_attr(not(feature = "gpu"), expect(unused_variables, reason = "some are for the GPU alone"))]

use std::sync::Arc;

use super::RenderError;
use crate::executor::PassResult;
use crate::executor::cpu::CpuExecutor;
#[cfg(feature = "gpu")]
use crate::executor::gpu::{Gpu, GpuExecutor, MOST_PASSES, Snapshot};
use crate::executor::sizes::Sizes;
use crate::plan::{Limits, Plan};
use crate::program::Kernel;
use crate::scene_data::SceneData;
use crate::tables::elements::{Elements, Size};
use crate::tables::state::StateCounts;
use crate::tables::stream::{Region, Stream, StreamData};

/// Where passes run.
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
    /// What to take where nobody chose, and this is the best adapter: it, unless it is software. The twins are faster
    /// then; `clock` is theirs.
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn auto(gpu: Arc<Gpu>, clock: Option<fn() -> u64>) -> Self {
        if gpu.is_software() { Self::Cpu(clock) } else { Self::Gpu(gpu) }
    }

    /// Whether it is a wgpu device.
    #[must_use]
    pub fn is_gpu(&self) -> bool {
        !matches!(self, Self::Cpu(_) | Self::CpuF64(_))
    }

    /// What it can hold.
    pub(crate) fn limits(&self) -> Limits {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => Limits::from(&**gpu),
            Self::Cpu(_) | Self::CpuF64(_) => Limits::CPU,
        }
    }
}

/// What runs the passes of one run on its device.
pub(super) enum Executor {
    #[cfg(feature = "gpu")]
    Gpu(Box<GpuExecutor>),
    Cpu(CpuExecutor<f32>),
    CpuF64(CpuExecutor<f64>),
}

/// Streams as they were after some pass. What runs on a GPU is kept on the GPU.
pub(super) enum Kept {
    #[cfg(feature = "gpu")]
    Gpu(Box<Snapshot>),
    Cpu(Box<CpuExecutor<f32>>),
    CpuF64(Box<CpuExecutor<f64>>),
}

impl Executor {
    /// `timed`: passes are timed, where the device has a clock.
    pub(super) async fn new(
        device: &Device,
        plan: &Arc<Plan>,
        data: &SceneData,
        timed: bool,
        given: &[StreamData],
    ) -> Result<Self, RenderError> {
        let timer = |clock: &Option<fn() -> u64>| clock.filter(|_| timed);
        Ok(match device {
            #[cfg(feature = "gpu")]
            Device::Gpu(gpu) => {
                let mut executor = GpuExecutor::new(gpu.clone(), plan, data, timed).await?;
                executor.give(given);
                Self::Gpu(Box::new(executor))
            }
            Device::Cpu(clock) => Self::Cpu(CpuExecutor::new(plan, timer(clock))?),
            Device::CpuF64(clock) => Self::CpuF64(CpuExecutor::new(plan, timer(clock))?),
        })
    }

    /// Every stream to what it begins with: the given ones, and unwritten values.
    pub(super) fn clear(&mut self, given: &[StreamData]) {
        match self {
            // It has copies of the given streams.
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => return e.clear(),
            Self::Cpu(e) => e.clear(),
            Self::CpuF64(e) => e.clear(),
        }
        for data in given {
            // A plan for given rays has these streams.
            let _: bool = self.write(data);
        }
    }

    pub(super) fn is_gpu(&self) -> bool {
        !matches!(self, Self::Cpu(_) | Self::CpuF64(_))
    }

    /// The most passes that one call of [`run`](Self::run) runs.
    pub(super) fn most_passes(&self) -> usize {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(_) => MOST_PASSES,
            Self::Cpu(_) | Self::CpuF64(_) => 1,
        }
    }

    /// Runs passes, on a CPU the first of them.
    pub(super) async fn run(
        &mut self,
        passes: &[Kernel],
        counts: &StateCounts,
        data: &SceneData,
    ) -> Result<Vec<PassResult>, RenderError> {
        Ok(match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.run(passes, counts).await?,
            Self::Cpu(e) => vec![e.run(passes[0], data)?],
            Self::CpuF64(e) => vec![e.run(passes[0], data)?],
        })
    }

    pub(super) fn size(&self, elements: &Elements) -> Option<Size> {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.size(elements),
            Self::Cpu(e) => e.size(elements),
            Self::CpuF64(e) => e.size(elements),
        }
    }

    /// How many elements each set has now.
    pub(super) fn sizes(&self) -> Sizes {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.sizes(),
            Self::Cpu(e) => e.sizes(),
            Self::CpuF64(e) => e.sizes(),
        }
    }

    pub(super) fn resize(&mut self, sizes: Sizes) -> Result<(), RenderError> {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.resize(sizes)?,
            Self::Cpu(e) => e.resize(sizes)?,
            Self::CpuF64(e) => e.resize(sizes)?,
        }
        Ok(())
    }

    pub(super) async fn read(&self, stream: Stream) -> Result<Option<StreamData>, RenderError> {
        Ok(match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.read(stream).await?,
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
            Self::Cpu(e) => e.read_texels(streams, x, y),
            Self::CpuF64(e) => e.read_texels(streams, x, y),
        })
    }

    pub(super) async fn read_region(&self, stream: Stream, region: Region) -> Result<Option<StreamData>, RenderError> {
        Ok(match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.read_region(stream, region).await?,
            Self::Cpu(e) => e.read_region(stream, region),
            Self::CpuF64(e) => e.read_region(stream, region),
        })
    }

    /// False where the plan left the stream out or the size differs.
    pub(super) fn write(&mut self, data: &StreamData) -> bool {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(e) => e.write(data),
            Self::Cpu(e) => e.write(data),
            Self::CpuF64(e) => e.write(data),
        }
    }

    /// Replaces one component of one ray, on a GPU not its tag; the rays in each state where that may have changed.
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
            Self::Cpu(e) => Kept::Cpu(Box::new(e.snapshot()?)),
            Self::CpuF64(e) => Kept::CpuF64(Box::new(e.snapshot()?)),
        })
    }

    /// Fails and changes nothing where another device keeps the streams.
    pub(super) fn restore(&mut self, kept: &Kept) -> Result<(), RenderError> {
        match (self, kept) {
            #[cfg(feature = "gpu")]
            (Self::Gpu(e), Kept::Gpu(snapshot)) if snapshot.is_on(e.gpu()) => e.restore(snapshot)?,
            (Self::Cpu(e), Kept::Cpu(kept)) => e.restore(kept)?,
            (Self::CpuF64(e), Kept::CpuF64(kept)) => e.restore(kept)?,
            _ => return Err(RenderError::OtherRun),
        }
        Ok(())
    }
}

impl Kept {
    /// What it holds: which one, and its bytes.
    pub(super) fn parts(&self) -> Vec<(usize, u64)> {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(snapshot) => snapshot.parts().collect(),
            Self::Cpu(executor) => vec![(std::ptr::from_ref(&**executor).addr(), executor.bytes())],
            Self::CpuF64(executor) => vec![(std::ptr::from_ref(&**executor).addr(), executor.bytes())],
        }
    }
}
