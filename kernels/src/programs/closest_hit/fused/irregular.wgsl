// Through an irregular grid. A turn of the loop tests a triangle or, once the list is at its end, steps to the next cell:
// rays that run together then wait for each other's longest list once, not in every cell.

import package::constants::{NO_LIST, LAST_ITEM};
import package::vector::{smallest3};
import package::grid::{grid};
import package::grid_walk::{GridRay, grid_ray};
import package::irregular_walk::{
    VoxelWalk, irregular_items, enter_irregular, at_voxel, voxel_exit, step_voxel, unpacked_voxel,
};
import package::ray::{load_voxel, store_voxel};
import package::tested::{tested};
import package::tracing::{Trace, farthest, is_spent};
import package::fused_waiting::{wait, wait_at, has_waited};

// The first cell, or the one at which the ray waits.
fn first_cell(ray: GridRay) -> VoxelWalk {
    @if(resumes) if (wait.before) {
        return at_voxel(load_voxel(wait.texel), wait.cell);
    }
    return enter_irregular(ray);
}

fn wait_in(walk: VoxelWalk, item: u32) {
    store_voxel(wait.texel, unpacked_voxel(walk.voxel));
    wait_at(walk.cell, item);
}

fn traced(start: Trace) -> Trace {
    var trace = start;
    let ray = grid_ray(trace.origin, trace.direction);
    var walk = first_cell(ray);
    var item = walk.first;
    @if(resumes) if (item != NO_LIST) {
        item += wait.item;
    }
    @if(counters) trace.cells += select(0u, 1u, walk.inside & !has_waited());
    while (walk.inside) {
        if (item != NO_LIST) {
            let entry = irregular_items[item];
            trace = tested(trace, entry & ~LAST_ITEM, vec3i(0));
            @if(any_hit || whole_paths) if (trace.ended) {
                return trace;
            }
            item = select(item + 1u, NO_LIST, (entry & LAST_ITEM) != 0u);
        }
        if (item == NO_LIST) {
            let exit = voxel_exit(walk, ray);
            if (farthest(trace) <= smallest3(exit.tmax)) {
                break;
            }
            walk = step_voxel(walk, exit, ray);
            item = walk.first;
            @if(counters) trace.cells += select(0u, 1u, walk.inside);
            @if(resumes) trace.turns += 1u + grid.levels;
        }
        @if(resumes) if (is_spent(trace) && walk.inside) {
            wait_in(walk, select(item - walk.first, 0u, item == NO_LIST));
            return trace;
        }
    }
    return trace;
}
