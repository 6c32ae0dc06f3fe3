// For the tests whose light_through and stays_on_surface stand before it.
#if DEPTHS == 1
float first_depth(ivec3 at) { return texelFetch(u_shadow_depth, at, 0).r; }
#else
float first_depth(ivec3 at) { return texelFetch(u_cells_0, at, 0).x; }
#endif

// Metres over the receiver's plane of what the map holds at a place of it, and of the highest thing in the four cells round it.
float height_in(Receiver r, ivec2 cell) {
    ivec2 at = clamped_cell(cell);
    return height_above(r, vec3(cell_ndc(at), first_depth(ivec3(at, r.map)) * 2.0 - 1.0));
}
float highest_round(Receiver r, vec2 texel) {
    ivec2 corner = ivec2(floor(texel - 0.5));
    float highest = height_in(r, corner);
    for (int i = 1; i < 4; ++i) highest = max(highest, height_in(r, corner + ivec2(i & 1, i >> 1)));
    return highest;
}

// Whether what shades the place stands between it and the eye, and is too thin for any pixel's centre to show: whether the view's ray from the
// place meets a surface that the map knows. Below that meeting the ray lies under what the map holds, above it over it: the height is found
// by bisection. Where the two never agree the ray only leaves a shadow; what rises less than a quarter of a texel is not told from the plane.
bool is_covered(Receiver r, vec2 step, vec3 offset) {
    vec3 place = r.position_ws + offset;
    vec4 h = u_pixel_from_world * vec4(place, 1.0);
    vec3 to_eye = -(u_along_from_pixel * vec3(h.xy / h.w, 1.0));
    float rise = dot(r.normal_ws, to_eye), room = footprint_m(r), height = highest_round(r, r.texel + step), under = 0.0, over = -1.0;
    for (int i = 0; i < MOST_COVERED && height > 0.25 * room && rise > 0.0; ++i) {
        vec4 q = project(r.map, place + to_eye * (height / rise));
        float next = height_in(r, ivec2(floor((q.xy * 0.5 + 0.5) * u_map_size)));
        if (next > 0.25 * room && abs(next - height) < 2.0 * room) return true;
        if (next > height) under = height;
        else over = height;
        height = over < 0.0 ? next : 0.5 * (under + over);
    }
    return false;
}

// `through`: what a tap `step` texels from the receiver's place found, where it differs from what the place itself has, `own`. If nobody sees
// the tap on the receiver's surface, the place stands for it: the levels of the filter stay, and no rim lies along a foot or an edge.
float seen_light(Receiver r, vec2 step, float through, float own) {
    if (through == own || !stays_on_surface()) return through;
    vec3 offset = offset_on_plane(r, step);
    return is_hidden(r, offset) || (through < own && is_covered(r, step, offset)) ? own : through;
}
