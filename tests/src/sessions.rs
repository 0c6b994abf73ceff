//! The inspector's session, as tests drive it.

use raystep_inspector::{Session, Target, go_on};
use raystep_kernels::StreamData;

use crate::streams_of;

/// Goes there; the place reached.
pub async fn go(session: &mut Session, target: Target) -> usize {
    session.step(target, &mut go_on).await.expect("a step")
}

/// All streams as they are now.
pub async fn streams(session: &Session) -> Vec<StreamData> {
    let mut all = Vec::new();
    for stream in streams_of(session.renderer().plan()) {
        all.push(session.stream(stream).await.expect("values"));
    }
    all
}
