// An entry of a list.

struct Entry {
    triangle: u32,
    // Whether the list ends after it.
    is_last: bool,
}
