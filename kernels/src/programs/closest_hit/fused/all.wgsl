// Without a structure: through all triangles.

import package::scene::{scene};
import package::tested::{tested};
import package::tracing::{Trace, is_spent};
import package::fused_waiting::{wait_at, waiting_item};

fn traced(start: Trace) -> Trace {
    var trace = start;
    for (var triangle = waiting_item(); triangle < scene.triangles; triangle++) {
        trace = tested(trace, triangle, vec3i(0));
        @if(any_hit || whole_paths) if (trace.ended) {
            return trace;
        }
        @if(resumes) if (is_spent(trace) && triangle + 1u < scene.triangles) {
            wait_at(0u, triangle + 1u);
            return trace;
        }
    }
    return trace;
}
