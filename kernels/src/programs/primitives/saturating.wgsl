// Sums that saturate at u32::MAX, in whatever order they are added, so that the host sees when there were too many. The
// CPU reference is u32::saturating_add.

fn saturating_add(a: u32, b: u32) -> u32 {
    return a + min(b, ~a);
}
