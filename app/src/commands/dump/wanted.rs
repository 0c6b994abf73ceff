//! The requested streams.

use raystep_kernels::Stream;
use raystep_kernels::plan::Plan;

use crate::error::Error;

/// The streams to write; an error if a named stream is not part of the plan, which says what would need it.
pub(super) fn streams(named: &[Stream], plan: &Plan) -> Result<Vec<Stream>, Error> {
    if named.is_empty() {
        return Ok(plan.streams.iter().map(|s| s.what).collect());
    }
    for &stream in named {
        if !plan.has_stream(stream) {
            let what = format!("stream {}", stream.name());
            let reason = plan.left_out.iter().find(|l| l.what == what).map_or("not needed", |l| l.reason);
            return Err(Error::usage(format!("--stream {}: this run omits it: {reason}", stream.name())));
        }
    }
    Ok(named.to_vec())
}
