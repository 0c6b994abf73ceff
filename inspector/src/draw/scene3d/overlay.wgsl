// What is drawn over the scene: lines of a width in pixels, dots (lines without a length), and filled triangles.

struct Line {
    @location(0) a: vec3f,
    @location(1) b: vec3f,
    @location(2) color: vec4f,
    @location(3) width_px: f32,
}

struct LineVarying {
    @builtin(position) position: vec4f,
    @location(0) at_px: vec2f,
    @location(1) @interpolate(flat) ends_px: vec4f,
    @location(2) @interpolate(flat) color: vec4f,
    @location(3) @interpolate(flat) half_px: f32,
}

fn pixels(clip: vec4f) -> vec2f {
    return (clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5) * view.size_px;
}

// A line's end is the start of its quad's left or right side; the quad is as much longer and wider as the line's
// round ends and its smooth border need.
@vertex
fn vs_line(line: Line, @builtin(vertex_index) index: u32) -> LineVarying {
    var a = view.clip_from_world * vec4f(line.a, 1.0);
    var b = view.clip_from_world * vec4f(line.b, 1.0);
    if (a.w < view.near && b.w < view.near) {
        return LineVarying(vec4f(2.0, 2.0, 0.0, 1.0), vec2f(), vec4f(), vec4f(), 0.0);
    }
    // What lies behind the eye has no place in the picture.
    if (a.w < view.near) {
        a = mix(a, b, (view.near - a.w) / (b.w - a.w));
    } else if (b.w < view.near) {
        b = mix(b, a, (view.near - b.w) / (a.w - b.w));
    }
    let a_px = pixels(a);
    let b_px = pixels(b);
    let length_px = distance(a_px, b_px);
    var along = vec2f(1.0, 0.0);
    if (length_px > 1e-3) {
        along = (b_px - a_px) / length_px;
    }
    let across = vec2f(-along.y, along.x);

    // Two triangles: a-, b-, a+, a+, b-, b+.
    let at_b = index == 1u || index >= 4u;
    let side = select(-1.0, 1.0, index == 2u || index == 3u || index == 5u);
    let half_px = line.width_px * 0.5;
    let reach_px = half_px + 1.0;
    let end_px = select(a_px, b_px, at_b);
    let at_px = end_px + along * select(-reach_px, reach_px, at_b) + across * (side * reach_px);
    let clip = nearer(select(a, b, at_b));
    let ndc = (at_px / view.size_px - 0.5) * vec2f(2.0, -2.0);
    // w is 1, so that everything is interpolated along the picture.
    return LineVarying(vec4f(ndc, clip.z / clip.w, 1.0), at_px, vec4f(a_px, b_px), line.color, half_px);
}

fn line_color(in: LineVarying) -> vec4f {
    let start = in.ends_px.xy;
    let way = in.ends_px.zw - start;
    let share = clamp(dot(in.at_px - start, way) / max(dot(way, way), 1e-6), 0.0, 1.0);
    let off_px = distance(in.at_px, start + way * share);
    // Thinner than a pixel: fainter instead.
    let covered = clamp(max(in.half_px, 0.5) + 0.5 - off_px, 0.0, 1.0) * min(2.0 * in.half_px, 1.0);
    let opacity = in.color.a * covered;
    return vec4f(in.color.rgb * opacity, opacity);
}

@fragment
fn fs_line(in: LineVarying) -> @location(0) vec4f {
    return line_color(in);
}

@fragment
fn fs_line_hidden(in: LineVarying) -> @location(0) vec4f {
    return line_color(in) * view.hidden;
}

struct FillVarying {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) color: vec4f,
}

@vertex
fn vs_fill(@location(0) position: vec3f, @location(1) color: vec4f) -> FillVarying {
    return FillVarying(nearer(view.clip_from_world * vec4f(position, 1.0)), color);
}

@fragment
fn fs_fill(in: FillVarying) -> @location(0) vec4f {
    return vec4f(in.color.rgb * in.color.a, in.color.a);
}

@fragment
fn fs_fill_hidden(in: FillVarying) -> @location(0) vec4f {
    return vec4f(in.color.rgb * in.color.a, in.color.a) * view.hidden;
}
