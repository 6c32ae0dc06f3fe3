// The inverse warp: walks the texels under the view ray one by one, and leaps over all that the ray passes before any surface.
// In each texel the solid is what lies between front and back; the ray enters it through the front, through the back (a wall that the back
// layer shows from within), or through the side of a column. Behind a solid nothing is known: there the surface that the ray passed last
// is taken to go on.
struct Walk { bool was_behind; bool has_passed; ivec2 cell; vec2 line; };   // `cell`, `line`: what the ray passed last in free space

// A texel's plane along the ray: it lies before the ray at depth a while line.x - line.y a > 0, and meets it at line.x / line.y.
vec2 line_of(vec4 layers, ivec2 cell, vec2 uv, vec2 slope) { return vec2(front_at(layers, cell, uv), 1.0 - dot(layers.yz, slope)); }

Hit hit_at(ivec2 cell, vec2 line, vec2 uv, vec2 slope, float a, float leave) {
    float depth = clamp(line.x / max(line.y, 1e-30), a, leave);
    return Hit(true, cell, vec3(uv + slope * depth, depth), false);
}

// The ray from depth a to `leave` within the texel `cell`.
Hit meets(inout Walk walk, ivec2 cell, vec4 layers, vec2 uv, vec2 slope, float a, float leave) {
    vec2 line = line_of(layers, cell, uv, slope);
    float above = line.x - line.y * a;
    if (above >= 0.0) {
        if (line.y * leave >= line.x) return hit_at(cell, line, uv, slope, a, leave);
        walk = Walk(is_empty(layers), !is_empty(layers), cell, line);
        return MISS;
    }
    bool joins = -above <= u_continuous + 0.5 * (abs(layers.y) + abs(layers.z));
    if (joins || a <= layers.w) return Hit(true, cell, vec3(uv + slope * a, a), walk.was_behind && !joins);
    walk.was_behind = true;
    if (FILL != 0 && walk.has_passed && walk.line.x >= walk.line.y * a && walk.line.y * leave >= walk.line.x)
        return hit_at(walk.cell, walk.line, uv, slope, a, leave);
    return MISS;
}

// From depth a to `leave`, texel by texel, edge texels quarter by quarter; `cell` is the first. Behind `farthest` there is nothing to meet but
// the surface passed last.
Hit walk_texels(inout Walk walk, ivec2 cell, vec2 uv, vec2 slope, vec2 pace, ivec2 stride, float a, float leave, float farthest) {
    vec2 border = (vec2(cell + max(stride, 0)) - uv) * pace * vec2(stride);   // a at which the ray leaves the cell, per axis
    for (int i = 0; i < 6 * TILE; ++i) {
        if (a > farthest && !(FILL != 0 && walk.has_passed)) {
            walk.was_behind = true;
            break;
        }
        float out_of_cell = min(border.x, border.y), until = min(leave, out_of_cell);
        vec4 layers = texelFetch(u_layers, texel_at(cell), 0);
        ivec2 shown = cell;
        if (is_edge(layers)) {
            vec2 middle = border - 0.5 * pace;
            if (middle.x > a) until = min(until, middle.x);
            if (middle.y > a) until = min(until, middle.y);
            uint code = shown_at(layers, cell, uv + slope * 0.5 * (a + until));
            if (code != 0u) {
                if (code < 15u) shown += neighbour(code);
                layers = code < 15u ? layers_at(shown) : vec4(EMPTY, 0.0, 0.0, -1.0);
            }
        }
        Hit hit = meets(walk, shown, layers, uv, slope, a, until);
        if (hit.found) return hit;
        if (until >= leave) break;
        a = until;
        if (until == out_of_cell) {
            bool across_u = border.x < border.y;
            cell += across_u ? ivec2(stride.x, 0) : ivec2(0, stride.y);
            border += across_u ? vec2(pace.x, 0.0) : vec2(0.0, pace.y);
        }
    }
    return MISS;
}

Hit trace(vec2 uv) {
    vec2 slope = ray_slope(uv);
    ivec2 stride = ivec2(slope.x < 0.0 ? -1 : 1, slope.y < 0.0 ? -1 : 1);
    vec2 pace = 1.0 / max(abs(slope), vec2(1e-9));                            // depth per texel
    vec2 to_low = -uv * pace * vec2(stride), to_high = (vec2(u_size) - uv) * pace * vec2(stride);
    vec2 first = min(to_low, to_high), last = max(to_low, to_high);
    float a = max(v_begin, max(first.x, first.y)), end = min(u_deepest, min(last.x, last.y));
    if (a > end) return MISS;
    ivec2 tile = clamp(ivec2(floor(uv + slope * (a + 1e-6 * u_deepest))), ivec2(0), u_size - 1) / TILE, tiles = (u_size - 1) / TILE;
    vec2 border = (vec2(tile + max(stride, 0)) * float(TILE) - uv) * pace * vec2(stride), step = pace * float(TILE);
    Walk walk = Walk(false, false, ivec2(0), vec2(0.0));
    bool leapt = false, came_in_u = false;
    for (int i = 0; i < u_size.x + u_size.y; ++i) {
        float leave;
        vec2 reach;
        for (int j = 0; j < u_size.x + u_size.y; ++j) {
            leave = min(end, min(border.x, border.y));
            reach = texelFetch(u_tiles, tile + 1, 0).rg;
            if (leave >= reach.x) break;
            if (leave >= end) return MISS;
            a = leave;
            leapt = true;
            came_in_u = border.x < border.y;
            tile += came_in_u ? ivec2(stride.x, 0) : ivec2(0, stride.y);
            border += came_in_u ? vec2(step.x, 0.0) : vec2(0.0, step.y);
        }
        float begin = max(a, reach.x);
        ivec2 low = tile * TILE, cell = clamp(ivec2(floor(uv + slope * begin)), low, min(low + TILE, u_size) - 1);
        if (leapt && a == begin) {
            if (came_in_u) cell.x = stride.x > 0 ? low.x : low.x + TILE - 1;
            else cell.y = stride.y > 0 ? low.y : low.y + TILE - 1;
            ivec2 before = cell - (came_in_u ? ivec2(stride.x, 0) : ivec2(0, stride.y));
            vec4 layers = layers_at(before);
            walk = Walk(is_empty(layers), !is_empty(layers), before, line_of(layers, before, uv, slope));
        }
        Hit hit = walk_texels(walk, cell, uv, slope, pace, stride, begin, leave, reach.y);
        if (hit.found) return hit;
        if (leave >= end) return MISS;
        a = leave;
        leapt = false;
        came_in_u = border.x < border.y;
        tile += came_in_u ? ivec2(stride.x, 0) : ivec2(0, stride.y);
        border += came_in_u ? vec2(step.x, 0.0) : vec2(0.0, step.y);
    }
    return MISS;
}
