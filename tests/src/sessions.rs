//! Functions that drive the inspector's session.

use raystep_inspector::{Session, Target, go_on};
use raystep_kernels::StreamData;

use crate::streams_of;

/// Steps to a target; returns the place reached.
pub async fn go(session: &mut Session, target: Target) -> usize {
    session.step(target, &mut go_on).await.expect("a step")
}

/// All streams in their current state.
pub async fn streams(session: &Session) -> Vec<StreamData> {
    let mut all = Vec::new();
    for stream in streams_of(session.renderer().plan()) {
        all.push(session.stream(stream).await.expect("values"));
    }
    all
}
