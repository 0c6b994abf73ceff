// Through an irregular grid: a step is a cell.

import package::constants::{NO_LIST, LAST_ITEM};
import package::state::{TRAV, ISECT_NO_HIT, SHADE, BACKGROUND};
import package::vector::{smallest3};
import package::grid::{grid};
import package::grid_walk::{grid_ray};
import package::irregular_walk::{irregular_items, at_voxel, voxel_exit, step_voxel, unpacked_voxel};
import package::ray::{load_voxel, store_voxel};
import package::scene::{scene};
import package::tested::{tested};
import package::tracing::{listed_as, is_spent};
import package::walk_place::{Place, waiting_item, after_list};

fn walked(start: Place, texel: vec2u) -> Place {
    var place = start;
    let ray = grid_ray(place.trace.origin, place.trace.direction);
    var walk = at_voxel(load_voxel(texel), place.cell);
    @if(resumes) var waits = false;
    for (var step = 0u; step < scene.steps; step++) {
        @if(resumes) if (is_spent(place.trace)) {
            break;
        }
        // One to find the next cell in each level of the map, at most.
        @if(resumes) place.trace.turns += 1u + grid.levels;
        var goes_on = walk.first != NO_LIST;
        var item = walk.first + waiting_item(place);
        while (goes_on) {
            let entry = irregular_items[item];
            place.trace = tested(place.trace, entry & ~LAST_ITEM, vec3i(0));
            @if(any_hit) if (place.trace.ended) {
                place.tag = SHADE;
                return place;
            }
            goes_on = (entry & LAST_ITEM) == 0u;
            item += 1u;
            @if(resumes) if (is_spent(place.trace) && goes_on) {
                place.item = item - walk.first;
                waits = true;
                break;
            }
        }
        let tag = listed_as(place.trace);
        @if(resumes) if (waits) {
            place.tag = tag;
            break;
        }
        @if(resumes) place.item = 0u;
        let exit = voxel_exit(walk, ray);
        place.tag = after_list(place.trace, smallest3(exit.tmax));
        if (place.tag != TRAV) {
            break;
        }
        walk = step_voxel(walk, exit, ray);
        if (!walk.inside) {
            place.tag = select(SHADE, BACKGROUND, tag == ISECT_NO_HIT);
            break;
        }
        place.tag = tag;
        place.cell = walk.cell;
        @if(counters) place.trace.cells += 1u;
    }
    store_voxel(texel, unpacked_voxel(walk.voxel));
    return place;
}
