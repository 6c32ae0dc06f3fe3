// Smooth edges of shadows: where one may pass the footprint of the camera's sample, SMOOTHING places of it are tested instead of one.
//
// They are those of a lattice in the footprint's plane, no two in a row or a column (n rooks), the first of them the sample's own: an
// upright edge meets as many levels as a slanted one. A place that something hides counts as the sample's own, and so does one
// beyond the map.

// Whether an edge may pass: of nine cells over the footprint, a texel apart at least, some stand before the receiver's plane and some do not.
bool edge_may_pass(Receiver r, mat2 footprint) {
    vec2 reach = max(0.5 * (abs(footprint[0]) + abs(footprint[1])), vec2(1.0));
    float bias = automatic_bias_m(r);
    int before = 0;
    for (int i = 0; i < 9; ++i) {
        ivec3 at = ivec3(clamped_cell(ivec2(floor(r.texel + reach * vec2(i % 3 - 1, i / 3 - 1)))), r.map);
        before += int(height_above(r, vec3(cell_ndc(at.xy), texelFetch(u_shadow_depth, at, 0).r * 2.0 - 1.0)) > bias);
    }
    return before != 0 && before != 9;
}

// Of the lattice the i-th place, in footprints from the middle: 0, 1, -1, 2, -2 ... in x, SMOOTHING_TURN times as much, wrapped, in y.
vec2 lattice_place(int i) {
    const int half_count = SMOOTHING / 2;
    int x = (i + 1) / 2 * ((i & 1) == 0 ? -1 : 1);
    int y = (x * SMOOTHING_TURN + half_count + 64 * SMOOTHING) % SMOOTHING - half_count;
    return vec2(x, y) / float(SMOOTHING);
}

// Whether the place is hidden: the view ray towards it meets, before it, a surface that one of the four pixels round it shows. Over the foot
// of a wall, a step or a flush panel the receiver's plane runs on inside a solid, where no light arrives.
bool is_covered(Receiver r, vec3 offset) {
    vec3 x = r.position_ws + offset;
    vec4 h = u_pixel_from_world * vec4(x, 1.0);
    vec3 ray = u_along_from_pixel * vec3(h.xy / h.w, 1.0);
    ivec2 last = textureSize(u_view_depth, 0) - 1, corner = ivec2(floor(h.xy / h.w - 0.5));
    for (int i = 0; i < 4; ++i) {
        ivec2 at = clamp(corner + ivec2(i & 1, i >> 1), ivec2(0), last);
        uvec2 ids = texelFetch(u_ids, at, 0).rg & uvec2(~0u, ~FROM_TEXTURE);
        if (ids == r.ids || ids.r == 0u) continue;
        vec3 pixel_h = vec3(vec2(at) + 0.5, 1.0);
        vec3 seen = u_start_from_pixel * pixel_h + (u_along_from_pixel * pixel_h) * texelFetch(u_view_depth, at, 0).r;
        if (dot(r.normal_ws, seen - r.position_ws) <= SEEN_NOISE * r.noise_m) continue;
        uvec4 info = instance_info(ids.r - 1u);
        vec3 edges;
        if (!walk_to_ray(info, ids.r - 1u, x, ray, ids.g, edges)) continue;
        if (depth_to_plane(info, ids.r - 1u, ids.g, x, ray) * dot(ray, r.normal_ws) > SEEN_NOISE * r.noise_m) return true;
    }
    return false;
}

bool is_in_map(vec2 texel) { return all(greaterThanEqual(texel, vec2(0.0))) && all(lessThanEqual(texel, vec2(u_map_size))); }

// Light reaching the footprint of a receiver that faces the light, 0 ... 1; `at_place`: its very place. `footprint` of the sample: texels, a
// column a side.
float smoothed_light(Receiver r, mat2 footprint, out float at_place) {
    Limits limits = limits_of(r);
    bool is_edge = edge_may_pass(r, footprint);
    float lit = 0.0;
    for (int i = 0; i < SMOOTHING; ++i) {
        vec2 step = footprint * lattice_place(i);
        float through = light_through(r, limits, step);
        if (i == 0) at_place = through;
        bool is_other = through != at_place && is_in_map(r.texel + step) && !is_covered(r, offset_on_plane(r, step));
        lit += is_other ? through : at_place;
        if (!is_edge) return lit;
    }
    return lit / float(SMOOTHING);
}
