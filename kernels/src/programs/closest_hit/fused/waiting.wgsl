// A ray between two dispatches of a kernel that takes whole walks: it waits at an item of its cell's list, or between two
// nodes of the BVH.

struct Wait {
    texel: vec2u,
    // Whether it waited before this dispatch, and waits after it.
    before: bool,
    after: bool,
    // As in the stream state: the cell and the item in its list, or the node and its level, or the triangle.
    cell: u32,
    item: u32,
}

var<private> wait: Wait;

fn wait_at(cell: u32, item: u32) {
    wait.after = true;
    wait.cell = cell;
    wait.item = item;
}

// Whether the ray waited before this dispatch, and at which item; false and 0 if rays never wait.
fn has_waited() -> bool {
    @if(resumes) return wait.before;
    @else return false;
}

fn waiting_item() -> u32 {
    @if(resumes) return wait.item;
    @else return 0u;
}
