// Through a uniform grid: a step is a cell.

import package::constants::{INF};
import package::state::{TRAV, ISECT_NO_HIT, SHADE, BACKGROUND};
import package::vector::{smallest3};
import package::grid::{cell_index, cell_of_index};
import package::grid_walk::{Walk, GridRay, grid_ray, next_cell, cell_exit, per_axis};
import package::grid_lists::{grid_cells, grid_items, empty_distance};
import package::per_axis::{load_per_axis, store_per_axis};
import package::scene::{scene};
import package::tested::{tested};
import package::tracing::{listed_as, is_spent};
import package::walk_place::{Place, waiting_item, after_list};

// robust: tmax is computed from the cell each time, so there is nothing to keep.
fn kept_walk(texel: vec2u, index: u32, ray: GridRay) -> Walk {
    let cell = cell_of_index(index);
    @if(robust && !drifting) return Walk(cell, cell_exit(cell, ray), true);
    @else return Walk(cell, load_per_axis(texel), true);
}

fn walked(start: Place, texel: vec2u) -> Place {
    var place = start;
    let ray = grid_ray(place.trace.origin, place.trace.direction);
    var walk = kept_walk(texel, place.cell, ray);
    @if(resumes) var waits = false;
    for (var step = 0u; step < scene.steps; step++) {
        @if(resumes) if (is_spent(place.trace)) {
            break;
        }
        @if(resumes) place.trace.turns += 1u;
        let distance = empty_distance(place.cell);
        if (distance == 0) {
            let first = grid_cells[place.cell];
            let end = grid_cells[place.cell + 1u];
            for (var item = first + waiting_item(place); item < end; item++) {
                place.trace = tested(place.trace, grid_items[item], walk.cell);
                @if(any_hit) if (place.trace.ended) {
                    place.tag = SHADE;
                    return place;
                }
                @if(resumes) if (is_spent(place.trace) && item + 1u < end) {
                    place.item = item + 1u - first;
                    waits = true;
                    break;
                }
            }
        }
        let tag = listed_as(place.trace);
        @if(resumes) if (waits) {
            place.tag = tag;
            break;
        }
        @if(resumes) place.item = 0u;
        @if(in_cell) let exit = INF;
        @else let exit = smallest3(walk.tmax);
        place.tag = after_list(place.trace, exit);
        if (place.tag != TRAV) {
            break;
        }
        walk = next_cell(walk, distance, ray);
        if (!walk.inside) {
            place.tag = select(SHADE, BACKGROUND, tag == ISECT_NO_HIT);
            break;
        }
        place.tag = tag;
        place.cell = cell_index(walk.cell);
        @if(counters) place.trace.cells += 1u;
    }
    @if(!robust || drifting) store_per_axis(texel, per_axis(walk));
    return place;
}
