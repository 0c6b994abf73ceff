// A ray of the kernel walk between two passes.

import package::state::{TRAV, BACKGROUND};
import package::tracing::{Trace, latest, listed_as};
import package::grid_lists::{list_ended};

struct Place {
    tag: u32,
    cell: u32,
    item: u32,
    trace: Trace,
}

// The item of its list at which the ray waited; 0 if rays never wait.
fn waiting_item(place: Place) -> u32 {
    @if(resumes) return place.item;
    @else return 0u;
}

// The state after a cell's list has ended; exit is the t at which the ray leaves the cell.
fn after_list(trace: Trace, exit: f32) -> u32 {
    let tag = list_ended(listed_as(trace), latest(trace), exit);
    @if(intervals && !in_cell) if (tag == TRAV && trace.interval.y <= exit) {
        return BACKGROUND;
    }
    return tag;
}
