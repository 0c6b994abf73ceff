// Without a structure: a step is a triangle.

import package::state::{SHADE};
import package::scene::{scene};
import package::tested::{tested};
import package::tracing::{ended_as, is_spent};
import package::walk_place::{Place};

fn walked(start: Place, texel: vec2u) -> Place {
    var place = start;
    let end = min(place.item + scene.steps, scene.triangles);
    for (; place.item < end; place.item++) {
        @if(resumes) if (is_spent(place.trace)) {
            break;
        }
        place.trace = tested(place.trace, place.item, vec3i(0));
        @if(any_hit) if (place.trace.ended) {
            place.tag = SHADE;
            return place;
        }
    }
    if (place.item >= scene.triangles) {
        place.tag = ended_as(place.trace);
    }
    return place;
}
