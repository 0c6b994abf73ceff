//! The pictures of kept runs in place of the current run's: flipped through by a key.

use std::sync::Arc;

use raystep_kernels::executor::gpu::{StreamTexture, stream_format};
use raystep_kernels::{Stream, StreamData};
use raystep_lab::text::counted;

use super::KeptRuns;
use crate::draw::stream::drawable;
use crate::runs::{Kept, Picture, RunId};
use crate::session::request::Opened;
use crate::ui::canvas::{Canvas, Moment};

/// Most textures of kept streams at a time.
const MOST_TEXTURES: usize = 4;

/// Streams of kept runs on the GPU, the last used first.
#[derive(Default)]
pub(in crate::ui) struct Textures(Vec<(Moment, Stream, StreamTexture)>);

/// The moment of a kept run's picture: a run has never as many passes.
fn moment(kept: &Kept) -> Moment {
    (kept.id, usize::MAX - usize::try_from(kept.edition).unwrap_or(0))
}

impl Textures {
    /// The texture of a stream, uploaded if it is not there.
    fn of(&mut self, canvas: &Canvas, moment: Moment, data: &StreamData) -> StreamTexture {
        let is_it = |(m, s, _): &(Moment, Stream, StreamTexture)| (*m, *s) == (moment, data.stream);
        if let Some(at) = self.0.iter().position(is_it) {
            let found = self.0.remove(at);
            self.0.insert(0, found);
        } else {
            self.0.truncate(MOST_TEXTURES - 1);
            self.0.insert(0, (moment, data.stream, upload(canvas, data)));
        }
        self.0[0].2.clone()
    }

    /// Drops the textures of a run.
    pub(in crate::ui) fn forget(&mut self, id: RunId) {
        self.0.retain(|((run, _), ..)| *run != id);
    }
}

fn upload(canvas: &Canvas, data: &StreamData) -> StreamTexture {
    let (width, height, layers) = (data.width, data.height, data.stream.layers() as u32);
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: layers };
    let texture = drawable(&canvas.gpu.device, "stream of a kept run", stream_format(data.stream), size);
    canvas.gpu.write_texture(texture.as_image_copy(), size, bytemuck::cast_slice(&data.bits));
    texture
}

/// A kept run in a stream view.
pub(in crate::ui) struct Flipped {
    /// Which run it is, and why it is not shown if it is not.
    pub(in crate::ui) label: String,
    /// The stream, and the moment that it is of; `None` if it was not kept.
    pub(in crate::ui) texture: Option<(Moment, StreamTexture)>,
    picture: Arc<Picture>,
}

impl Flipped {
    /// The values of the stream that is shown.
    pub(in crate::ui) fn values(&self, stream: Stream) -> Option<&StreamData> {
        self.picture.stream(stream)
    }
}

/// Why a kept run's picture cannot be shown in place of the open run's; `None` if it can.
fn why_not(runs: &KeptRuns, kept: &Kept, opened: &Opened) -> Option<String> {
    if !runs.is_of(kept, opened) {
        return Some("it is of another scene".into());
    }
    match &kept.picture {
        Err(why) => Some(why.clone()),
        Ok(picture) if picture.size() != [opened.plan.width, opened.plan.height] => {
            let [width, height] = picture.size();
            Some(format!("it has {width} × {height} pixels, not {} × {}", opened.plan.width, opened.plan.height))
        }
        Ok(_) => None,
    }
}

impl KeptRuns {
    /// Shows the next kept run, or the one before; after the last, and before the first, the open run.
    ///
    /// # Errors
    /// In one sentence, if none of them can be shown.
    pub(in crate::ui) fn flip(&mut self, is_forward: bool, opened: &Opened) -> Result<(), String> {
        let refused = |kept: &Kept| why_not(self, kept, opened);
        let fitting: Vec<RunId> =
            self.runs.list().iter().filter(|kept| refused(kept).is_none()).map(|kept| kept.id).collect();
        if fitting.is_empty() {
            let why = self.runs.list().last().and_then(|kept| Some(format!("{}: {}", kept.name, refused(kept)?)));
            let why = why.unwrap_or_else(|| "no run is kept".into());
            self.flipped = None;
            return Err(format!("no kept run can be shown here ({why})"));
        }
        let at = self.flipped.and_then(|id| fitting.iter().position(|&other| other == id));
        let to = match (at, is_forward) {
            (None, true) => Some(0),
            (None, false) => fitting.len().checked_sub(1),
            (Some(at), true) => Some(at + 1),
            (Some(at), false) => at.checked_sub(1),
        };
        self.flipped = to.and_then(|to| fitting.get(to)).copied();
        Ok(())
    }

    /// The kept run that stream views show.
    pub(in crate::ui) fn flipped(&self) -> Option<RunId> {
        self.flipped
    }

    /// Shows a run in stream views, or the open run.
    pub(in crate::ui) fn set_flipped(&mut self, id: Option<RunId>) {
        self.flipped = id;
    }

    /// Why a run's picture cannot be shown in place of the open run's; `None` if it can.
    pub(in crate::ui) fn why_not_flipped(&self, kept: &Kept, opened: &Opened) -> Option<String> {
        why_not(self, kept, opened)
    }

    /// What stream views show in place of the open run's stream.
    pub(in crate::ui) fn shown(&mut self, canvas: &Canvas, opened: &Opened, stream: Stream) -> Option<Flipped> {
        let id = self.flipped?;
        let kept = self.runs.get(id).filter(|kept| why_not(self, kept, opened).is_none());
        let (Some(kept), all) = (kept, self.runs.list().len()) else {
            self.flipped = None;
            return None;
        };
        let picture = kept.picture.as_ref().ok()?.clone();
        let number = self.runs.list().iter().position(|other| other.id == id).unwrap_or(0) + 1;
        let which = format!("kept run {number} of {all}: {}", kept.name);
        let moment = moment(kept);
        let Some(data) = picture.stream(stream) else {
            let label = format!("{which} – not shown: {} was not kept, only {}", stream.name(), picture.names());
            return Some(Flipped { label, texture: None, picture });
        };
        let texture = self.textures.of(canvas, moment, data);
        Some(Flipped { label: which, texture: Some((moment, texture)), picture })
    }

    /// How many kept runs cannot be shown here, for display.
    pub(in crate::ui) fn left_out(&self, opened: &Opened) -> Option<String> {
        let count = self.runs.list().iter().filter(|kept| why_not(self, kept, opened).is_some()).count();
        (count > 0).then(|| counted(count, "kept run"))
    }
}
