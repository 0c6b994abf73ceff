// Through a uniform grid: a ray tests all triangles of its cell's list before it goes on to the next cell.

import package::constants::{NO_TRIANGLE};
import package::vector::{smallest3};
import package::grid::{cell_index};
import package::grid_walk::{grid_ray, next_cell};
import package::grid_lists::{grid_cells, grid_items, empty_distance};
import package::tested::{tested};
import package::tracing::{Trace, farthest, is_spent};
import package::fused_waiting::{wait, waiting_item};
import package::fused_waiting_in_grid::{first_cell, cells_left, wait_in};

fn traced(start: Trace) -> Trace {
    var trace = start;
    let ray = grid_ray(trace.origin, trace.direction);
    var walk = first_cell(ray);
    var left = cells_left();
    while (walk.inside) {
        let index = cell_index(walk.cell);
        @if(resumes) if (is_spent(trace)) {
            wait_in(walk, left, index, 0u);
            return trace;
        }
        @if(resumes) trace.turns += 1u;
        @if(counters) trace.cells += select(0u, 1u, waiting_item() == 0u);
        let distance = empty_distance(index);
        if (distance == 0) {
            let first = grid_cells[index];
            let end = grid_cells[index + 1u];
            for (var item = first + waiting_item(); item < end; item++) {
                trace = tested(trace, grid_items[item], walk.cell);
                @if(any_hit || whole_paths) if (trace.ended) {
                    return trace;
                }
                @if(resumes) if (is_spent(trace) && item + 1u < end) {
                    wait_in(walk, left, index, item + 1u - first);
                    return trace;
                }
            }
        }
        @if(resumes) wait.item = 0u;
        @if(!in_cell) if (farthest(trace) <= smallest3(walk.tmax)) {
            break;
        }
        @else {
            left -= 1;
            if (trace.triangle != NO_TRIANGLE || left < 0) {
                break;
            }
        }
        walk = next_cell(walk, distance, ray);
    }
    return trace;
}
