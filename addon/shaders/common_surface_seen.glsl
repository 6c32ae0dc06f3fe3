// Needs common_triangles.glsl, and common_large.glsl where LARGE.
//
// What the tests need of the triangle seen: its normal turned to the viewer, and the seen point put exactly into its plane, because the
// interpolated view depth of a large triangle is off by many times float32's own noise.
struct Surface {
    vec3 normal_ws;
    vec3 position_ws;
    float noise_m;
    vec3 edge_1, edge_2;
};

// The rasteriser gives a triangle pixels whose centres lie a fraction of a pixel beyond its edge. There its plane may lie below its
// neighbour's, which the exact test would find in the way: such a point is moved onto the edge, by `most` at the most.
vec3 moved_inside(vec3 x, vec3 from, vec3 to, vec3 normal, float most) {
    vec3 inwards = cross(normal, to - from);
    float across = dot(inwards, x - from) / max(length(inwards), 1e-30);
    return x - inwards * (clamp(across, -most, 0.0) / max(length(inwards), 1e-30));
}

// `is_met`: the ray passes through it; `is_named`: an impostor names it, but the ray passes beside it: then the place next to the ray.
Surface surface_seen(uvec4 info, uint slot, uint triangle, bool is_met, bool is_named, vec3 start, vec3 along, float view_depth) {
    vec3 a = corner_ws(info, slot, triangle * 3u), b = corner_ws(info, slot, triangle * 3u + 1u), c = corner_ws(info, slot, triangle * 3u + 2u);
    vec3 turn = cross(b - a, c - a);
    turn /= max(length(turn), 1e-30);
    vec3 n = dot(turn, along) > 0.0 ? -turn : turn;
    vec3 x = start + along * view_depth, far = a;
#if LARGE
    vec4 plane;
    if (large_plane(slot, triangle, plane)) {
        n = dot(plane.xyz, along) > 0.0 ? -plane.xyz : plane.xyz;
        float across = dot(plane.xyz, along);
        if (abs(across) > 1e-3 * length(along)) x -= along * ((dot(plane.xyz, x) + plane.w) / across);
        far = x;
    } else
#endif
    {
        float slope = dot(n, along), most = is_met ? 1e30 : 1e-3 * view_depth;
        if (is_named) x += n * dot(n, a - x);
        else if (slope < -1e-3 * length(along)) x += along * clamp(dot(n, a - x) / slope, -most, most);
    }
#ifdef INSIDE_ITS_TRIANGLE
    bool is_inside = true;
#else
    bool is_inside = is_met || is_named;
#endif
    float most = is_named ? 1e30 : 1e-4 * view_depth;
    if (is_inside) x = moved_inside(moved_inside(moved_inside(x, a, b, turn, most), b, c, turn, most), c, a, turn, most);
    vec3 size = max(abs(x), max(abs(start), abs(far)));
    return Surface(n, x, 4.8e-7 * max(max(size.x, size.y), size.z), b - a, c - a);
}
