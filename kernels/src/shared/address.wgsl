// Where an entry of a list is, if the list lies in a square texture, row by row: the column and row of its texel. The
// paper's function of this name (§4.1, Figure 5); here in integers, so that no texel is missed.

fn get_address(i: u32, k: u32) -> vec2u {
    return vec2u(i % k, i / k);
}
