// The inverse warp: walks the texels under the view ray one by one, and leaps over all that the ray passes before any surface.
// In each texel the solid is what lies between front and back; the ray enters it through the front, through the back (a wall that the back
// layer shows from within), or through the side of a column. Behind a solid nothing is known: there the surface that the ray passed last
// is taken to go on.
struct Walk { bool was_behind; ivec2 cell; vec4 layers; };   // `cell`, `layers`: what the ray passed last in free space

// The ray from depth a to `leave` within the texel `cell`.
Hit meets(inout Walk walk, ivec2 cell, vec4 layers, vec2 uv, vec2 slope, float a, float leave) {
    vec2 at = uv + slope * a, to = uv + slope * leave;
    float above = front_at(layers, cell, at) - a, below = leave - front_at(layers, cell, to);
    if (above >= 0.0) {
        if (below >= 0.0) {
            float t = above + below > 0.0 ? above / (above + below) : 0.0;
            return Hit(true, cell, mix(vec3(at, a), vec3(to, leave), t), false);
        }
        walk = Walk(is_empty(layers), cell, layers);
        return MISS;
    }
    bool joins = -above <= u_continuous + 0.5 * (abs(layers.y) + abs(layers.z));
    if (joins || a <= layers.w) return Hit(true, cell, vec3(at, a), walk.was_behind && !joins);
    walk.was_behind = true;
    if (FILL == 0 || is_empty(walk.layers)) return MISS;
    above = front_at(walk.layers, walk.cell, at) - a;
    below = leave - front_at(walk.layers, walk.cell, to);
    return Hit(above >= 0.0 && below >= 0.0, walk.cell, mix(vec3(at, a), vec3(to, leave), above / max(above + below, 1e-30)), false);
}

// The same in an edge texel, quarter by quarter.
Hit meets_edge(inout Walk walk, ivec2 cell, vec4 layers, vec2 uv, vec2 slope, float a, float leave) {
    vec2 crossing = (vec2(cell) + 0.5 - uv) / mix(slope, vec2(1e-9), lessThan(abs(slope), vec2(1e-9)));
    crossing = clamp(crossing, a, leave);
    float ends[4] = float[4](a, min(crossing.x, crossing.y), max(crossing.x, crossing.y), leave);
    for (int i = 0; i < 3; ++i) {
        if (ends[i + 1] <= ends[i] && !(i == 2 && leave <= a)) continue;
        uint code = shown_at(cell, uv + slope * 0.5 * (ends[i] + ends[i + 1]));
        ivec2 shown = cell + neighbour(code);
        vec4 theirs = code == 15u ? vec4(EMPTY, 0.0, 0.0, -1.0) : code == 0u ? layers : layers_at(shown);
        Hit hit = meets(walk, code == 15u ? cell : shown, theirs, uv, slope, ends[i], ends[i + 1]);
        if (hit.found) return hit;
    }
    return MISS;
}

Hit trace(vec2 uv) {
    vec2 slope = ray_slope(uv);
    vec2 speed = max(abs(slope), vec2(1e-9));
    vec2 towards = vec2(slope.x < 0.0 ? -1.0 : 1.0, slope.y < 0.0 ? -1.0 : 1.0);
    vec2 to_low = -uv * towards / speed, to_high = (vec2(u_size) - uv) * towards / speed;
    vec2 first = min(to_low, to_high), last = max(to_low, to_high);
    float a = max(u_nearest, max(first.x, first.y)), end = min(u_deepest, min(last.x, last.y));
    if (a > end) return MISS;
    ivec2 cell = clamp(ivec2(floor(uv + slope * (a + 1e-6 * u_deepest))), ivec2(0), u_size - 1);
    ivec2 stride = ivec2(towards);
    Walk walk = Walk(false, ivec2(0), vec4(EMPTY, 0.0, 0.0, -1.0));
    for (int i = 0; i < u_size.x + u_size.y; ++i) {
        ivec2 low, came_from = ivec2(-1);
        float nearest;
        for (int j = 0; j < u_size.x + u_size.y; ++j) {
            low = cell / TILE * TILE;
            nearest = texelFetch(u_tiles, low / TILE, 0).r;
            vec2 far_side = (vec2(low) + max(towards, 0.0) * float(TILE) - uv) * towards / speed;
            float beyond = min(far_side.x, far_side.y);
            if (min(beyond, end) >= nearest) break;
            if (beyond >= end) return MISS;
            a = beyond;
            came_from = clamp(ivec2(floor(uv + slope * a)), low, low + TILE - 1);
            bool across_u = far_side.x < far_side.y;
            cell = ivec2(across_u ? (stride.x > 0 ? low.x + TILE : low.x - 1) : came_from.x,
                         across_u ? came_from.y : (stride.y > 0 ? low.y + TILE : low.y - 1));
            came_from = cell - (across_u ? ivec2(stride.x, 0) : ivec2(0, stride.y));
            if (is_outside(cell)) return MISS;
        }
        if (nearest > a) {
            a = nearest;
            cell = clamp(ivec2(floor(uv + slope * a)), low, min(low + TILE, u_size) - 1);
        } else if (came_from.x >= 0) {
            vec4 layers = layers_at(came_from);
            walk = Walk(is_empty(layers), came_from, layers);
        }
        vec2 border = (vec2(cell) + max(towards, 0.0) - uv) * towards / speed;   // a at which the ray leaves the cell, per axis
        for (int j = 0; j < 2 * TILE; ++j) {
            float leave = min(end, min(border.x, border.y));
            vec4 layers = texelFetch(u_layers, texel_at(cell), 0);
            Hit hit;
            if (is_edge(layers)) hit = meets_edge(walk, cell, layers, uv, slope, a, leave);
            else hit = meets(walk, cell, layers, uv, slope, a, leave);
            if (hit.found) return hit;
            if (leave >= end) return MISS;
            a = leave;
            if (border.x < border.y) { cell.x += stride.x; border.x += 1.0 / speed.x; }
            else { cell.y += stride.y; border.y += 1.0 / speed.y; }
            if (any(notEqual(cell / TILE * TILE, low)) || is_outside(cell)) break;
        }
        if (is_outside(cell)) return MISS;
    }
    return MISS;
}
