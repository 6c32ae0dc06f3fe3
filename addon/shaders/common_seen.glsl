// What the camera sees, and whether it sees a place on a receiver's plane. Beyond the foot of a wall, a step or a flush panel that plane runs
// on inside a solid, where no light arrives: a filter's tap there says nothing of the surface. Seen from outside, a solid hides its inside.
uniform sampler2D u_view_depth;
uniform usampler2D u_ids;
uniform mat3 u_along_from_pixel;   // view ray per metre of view depth: M (x, y, 1), pixel coordinates from the bottom left
uniform mat3 u_start_from_pixel;   // world point at view depth 0
uniform mat4 u_pixel_from_world;   // homogeneous pixel coordinates of a world point
const float SEEN_NOISE = 8.0;      // of float32's noise: surfaces nearer than that to the plane are in it
const float FALLS_AWAY = 0.5;      // sine of the angle below the plane from which on it is another side of a thing
const int MOST_COVERED = 8;        // steps along the view's ray through what the map holds

// The place `step` texels from the receiver's, on its plane: along the light from where it lies across the ray.
vec3 offset_on_plane(Receiver r, vec2 step) {
    vec3 across = step.x * r.step_s + step.y * r.step_t;
    return across - r.light_ws * (dot(r.normal_ws, across) / max(r.facing, 1e-3));
}

// Whether the place is not on the surface seen: at one of the four pixels whose centres surround it, so that a foot that passes between
// them counts, something stands before the receiver's plane, or what is seen falls away behind it as beyond an edge, or nothing is seen.
bool is_hidden(Receiver r, vec3 offset) {
    vec4 h = u_pixel_from_world * vec4(r.position_ws + offset, 1.0);
    ivec2 size = textureSize(u_view_depth, 0);
    if (!(h.w > 0.0 && all(greaterThanEqual(h.xy, vec2(0.0))) && all(lessThanEqual(h.xy, vec2(size) * h.w)))) return true;
    ivec2 corner = ivec2(floor(h.xy / h.w - 0.5));
    for (int i = 0; i < 4; ++i) {
        ivec2 at = clamp(corner + ivec2(i & 1, i >> 1), ivec2(0), size - 1);
        uvec2 ids = texelFetch(u_ids, at, 0).rg;
        if (ids == r.ids) continue;
        if (ids.r == 0u) return true;
        vec3 pixel_h = vec3(vec2(at) + 0.5, 1.0);
        vec3 seen = u_start_from_pixel * pixel_h + (u_along_from_pixel * pixel_h) * texelFetch(u_view_depth, at, 0).r - r.position_ws;
        float height = dot(r.normal_ws, seen);
        if (height > SEEN_NOISE * r.noise_m || height < -FALLS_AWAY * length(seen)) return true;
    }
    return false;
}
