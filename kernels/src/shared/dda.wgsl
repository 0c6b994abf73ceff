// The 3D-DDA of Fujimoto, Tanaka and Iwata (1986): two line-drawing DDAs that share a driving axis, along which the ray
// crosses cells fastest.
//
// The control term of an axis is how far the ray has gone past its next face along that axis, in cells, when it reaches
// the next face along the driving axis: above 0, it crosses the face of that axis first. The driving axis's own is 0.

// Cells that the ray crosses along each axis while it crosses one along the driving axis: 1 there.
fn slopes(direction: vec3f, width: vec3f) -> vec3f {
    let speed = abs(direction / width);
    let fastest = max(max(speed.x, speed.y), speed.z);
    return select(speed / fastest, vec3f(1.0), speed == vec3f(fastest));
}

// Of several axes with slope 1, the first drives.
fn driving_axis(slope: vec3f) -> vec3<bool> {
    let x = slope.x == 1.0;
    let y = !x && slope.y == 1.0;
    return vec3<bool>(x, y, !x && !y);
}

// The control terms of a ray in its first cell; position: in cells.
fn first_control(position: vec3f, cell: vec3i, direction: vec3f, slope: vec3f) -> vec3f {
    let low = vec3f(cell);
    let left = select(low + 1.0 - position, position - low, direction < vec3f(0.0));
    let axis = driving_axis(slope);
    let left_driving = select(select(left.z, left.y, axis.y), left.x, axis.x);
    return slope * left_driving - left;
}

// The axis that is crossed next: where two terms are positive, the one that is larger in proportion to its slope. Ties
// are in the order of Listing 1.
fn crossed_axis(control: vec3f, slope: vec3f) -> vec3<bool> {
    let x_before_y = control.x * slope.y > control.y * slope.x;
    let x_before_z = control.x * slope.z > control.z * slope.x;
    let y_before_z = control.y * slope.z > control.z * slope.y;
    let x = x_before_y && x_before_z;
    let y = !x_before_y && y_before_z;
    return vec3<bool>(x, y, !x && !y);
}

// The control terms after a step along an axis.
fn next_control(control: vec3f, slope: vec3f, axis: vec3<bool>) -> vec3f {
    let drives = any(axis & driving_axis(slope));
    return control + select(vec3f(0.0), slope, drives) - select(vec3f(0.0), vec3f(1.0), axis);
}
