// The inverse warp: walks the texels under the view ray one by one, and leaps over all that the ray passes before any surface.
// In each texel the solid is what lies between front and back; the ray enters it through the front, through the back (a wall that the back
// layer shows from within), or through the side of a column. Behind a solid nothing is known: there the surface that the ray passed last
// is taken to go on.
// A texel's plane along the ray is a line: it lies before the ray at depth a while line.x - line.y a > 0, and meets it at line.x / line.y.
flat in float v_begin;              // depth before which no ray here meets a surface
uniform sampler2D u_tiles;          // of every TILE × TILE texels, v downwards, with an empty rim: the nearest surface in or beside them, the
                                    // depth behind which nothing is met, the nearest surface in them
struct Passed { bool is_known; ivec2 cell; vec2 line; };                // what the ray passed last in free space
struct Walk { bool met, on_back, was_behind; ivec2 cell; vec2 line; float a, leave; Passed passed; };

void meet(inout Walk walk, ivec2 cell, vec2 line, bool on_back) {
    walk.met = true;
    walk.cell = cell;
    walk.line = line;
    walk.on_back = on_back;
}

// The ray from depth walk.a to walk.leave within the texel `cell`.
void step_through(inout Walk walk, ivec2 cell, vec4 layers, vec2 uv, vec2 slope) {
    vec2 line = vec2(front_at(layers, cell, uv), 1.0 - dot(layers.yz, slope));
    float above = line.x - line.y * walk.a;
    if (above >= 0.0) {
        walk.was_behind = is_empty(layers);
        walk.passed = Passed(!walk.was_behind, cell, line);
        if (line.y * walk.leave >= line.x) meet(walk, cell, line, false);
        return;
    }
    bool joins = -above <= u_continuous + 0.5 * (abs(layers.y) + abs(layers.z));
    if (joins || walk.a <= layers.w) {
        meet(walk, cell, vec2(walk.a, 1.0), walk.was_behind && !joins);
        return;
    }
    walk.was_behind = true;
    vec2 last = walk.passed.line;
    if (FILL != 0 && walk.passed.is_known && last.x >= last.y * walk.a && last.y * walk.leave >= last.x) meet(walk, walk.passed.cell, last, false);
}

// Over the nearer of a square's two borders (the depths at which the ray leaves it, per axis) into the next square.
void cross(inout ivec2 square, inout vec2 border, ivec2 stride, vec2 width) {
    bvec2 axis = bvec2(border.x < border.y, border.x >= border.y);
    square += ivec2(axis) * stride;
    border += vec2(axis) * width;
}

// From depth walk.a to `leave`, texel by texel, edge texels quarter by quarter; `cell` is the first. Behind `farthest` there is nothing to meet
// but the surface passed last.
void walk_texels(inout Walk walk, ivec2 cell, vec2 uv, vec2 slope, vec2 pace, ivec2 stride, float leave, float farthest) {
    vec2 border = (vec2(cell + max(stride, 0)) - uv) * pace * vec2(stride);
    for (int i = 0; i < 6 * TILE; ++i) {
        if (walk.a > farthest && !(FILL != 0 && walk.passed.is_known)) {
            walk.was_behind = true;
            break;
        }
        float out_of_cell = min(border.x, border.y);
        walk.leave = min(leave, out_of_cell);
        vec4 layers = texelFetch(u_layers, texel_at(cell), 0);
        ivec2 shown = cell;
        if (is_edge(layers)) {
            vec2 middle = border - 0.5 * pace;
            if (middle.x > walk.a) walk.leave = min(walk.leave, middle.x);
            if (middle.y > walk.a) walk.leave = min(walk.leave, middle.y);
            uint code = shown_at(layers, cell, uv + slope * 0.5 * (walk.a + walk.leave));
            if (code < 15u) shown += neighbour(code);
            layers = code < 15u ? texelFetch(u_layers, texel_at(shown), 0) : NOTHING;
        }
        step_through(walk, shown, layers, uv, slope);
        if (walk.met || walk.leave >= leave) break;
        walk.a = walk.leave;
        if (walk.leave == out_of_cell) cross(cell, border, stride, pace);
    }
}

Hit trace(vec2 uv) {
    vec2 slope = ray_slope(uv);
    ivec2 stride = ivec2(slope.x < 0.0 ? -1 : 1, slope.y < 0.0 ? -1 : 1);
    vec2 pace = 1.0 / max(abs(slope), vec2(1e-9));                            // depth per texel
    vec2 to_low = -uv * pace * vec2(stride), to_high = (vec2(u_size) - uv) * pace * vec2(stride);
    vec2 first = min(to_low, to_high), last = max(to_low, to_high);
    float a = max(v_begin, max(first.x, first.y)), end = min(u_deepest, min(last.x, last.y));
    if (a > end) return MISS;
    ivec2 tile = clamp(ivec2(floor(uv + slope * (a + 1e-6 * u_deepest))), ivec2(0), u_size - 1) / TILE;
    vec2 border = (vec2(tile + max(stride, 0)) * float(TILE) - uv) * pace * vec2(stride), width = pace * float(TILE);
    Walk walk = Walk(false, false, false, ivec2(0), vec2(0.0), a, a, Passed(false, ivec2(0), vec2(0.0)));
    for (int i = 0; i < u_size.x + u_size.y; ++i) {
        float leave = min(end, min(border.x, border.y));
        vec3 reach = texelFetch(u_tiles, tile + 1, 0).rgb;
        for (int j = 0; leave < reach.x && leave < end && j < u_size.x + u_size.y; ++j) {
            walk.a = leave;
            cross(tile, border, stride, width);
            leave = min(end, min(border.x, border.y));
            reach = texelFetch(u_tiles, tile + 1, 0).rgb;
        }
        if (leave < reach.x) return MISS;
        walk.a = max(walk.a, min(reach.z, leave));
        ivec2 low = tile * TILE, cell = clamp(ivec2(floor(uv + slope * walk.a)), low, min(low + TILE, u_size) - 1);
        walk_texels(walk, cell, uv, slope, pace, stride, leave, reach.y);
        if (walk.met || leave >= end) break;
        walk.a = leave;
        cross(tile, border, stride, width);
    }
    if (!walk.met) return MISS;
    float depth = clamp(walk.line.x / max(walk.line.y, 1e-30), walk.a, walk.leave);
    return Hit(true, walk.cell, vec3(uv + slope * depth, depth), walk.on_back);
}
