// The point to be lit, as the shadow tests see it: its place in the map, its plane, and how far things in the map stand above it.
//
// Heights and distances are taken relative to the receiver, from differences of map coordinates, so that nothing large cancels: a planar
// receiver never shadows itself, whatever the warp, and every bias is in metres.
struct Receiver {
    vec3 position_ws;
    vec3 normal_ws;          // of its triangle, on the viewer's side
    vec3 light_ws;
    int map;
    vec4 log_warp, log_linear;   // of the map: looked up once
    vec4 q;                  // project(map, position)
    vec2 texel;              // 0 ... N
    vec3 step_s, step_t;     // one texel, across the light's ray, metres
    float facing;            // cosine between normal and light
    float noise_m;           // what float32 cannot tell
    float blur;              // texels by which the rasteriser's depth of its triangle may be out of place
    vec4 clip;               // what world_from_clip takes at q
    vec4 height_row;         // of a change of clip: numerator of the height over the plane,
    vec4 distance_row;       // of the distance towards the light,
    vec4 w_row;              // and the change of the divisor, which is w here
    float w;
    uvec2 ids;               // slot + 1, triangle
    uint id;                 // the ID test's number of the object
};

// What world_from_clip takes at NDC (s, t, depth); see unproject.
vec4 clip_at(int i, vec3 q) {
    vec4 l = maps[i].log_warp;
    if (ANY_LOG == 0 || l.w == 0.0) return vec4(q, 1.0);
    float w = log_w(l, maps[i].log_linear.zw, q.y);
    return vec4(l.z == 0.0 ? q.x : q.x * w, maps[i].log_linear.x * w + maps[i].log_linear.y, q.z, w);
}

// The same receiver at another place, for the tests that move it: everything that depends on the place.
Receiver placed_at(Receiver r, vec3 x_ws, vec4 q) {
    r.position_ws = x_ws;
    r.q = q;
    r.texel = (q.xy * 0.5 + 0.5) * u_map_size;
    r.clip = clip_at(r.map, q.xyz);
    mat4 m = maps[r.map].world_from_clip;
    r.w_row = vec4(m[0].w, m[1].w, m[2].w, m[3].w);
    r.w = dot(r.w_row, r.clip);
    mat3 moved = mat3(m[0].xyz - x_ws * m[0].w, m[1].xyz - x_ws * m[1].w, m[2].xyz - x_ws * m[2].w);
    vec3 last = m[3].xyz - x_ws * m[3].w;
    r.height_row = vec4(r.normal_ws * moved, dot(r.normal_ws, last));
    r.distance_row = vec4(r.light_ws * moved, dot(r.light_ws, last));
    return r;
}

// A rasteriser finds the slopes of depth as differences of float32 products over the triangle's area. Over a triangle of length L texels and
// width w that is wrong by up to 2^-23 L / w of the slope, and by L times that at its far end. One thinner than a texel wins few cells: its
// neighbours' depths count, so w is taken as 1 at least. Of a triangle longer than CUT_BEYOND maps only
// what the map shows was drawn (pipeline/passes/large_casters.py). `edge_1`, `edge_2` of the triangle.
float interpolation_blur(vec3 grad_s, vec3 grad_t, vec3 edge_1, vec3 edge_2) {
    vec2 e = vec2(dot(grad_s, edge_1), dot(grad_t, edge_1)), f = vec2(dot(grad_s, edge_2), dot(grad_t, edge_2)), g = f - e;
    float longest = sqrt(max(dot(e, e), max(dot(f, f), dot(g, g))));
    float width = max(abs(e.x * f.y - e.y * f.x) / max(longest, 1e-30), 1.0);
    if (longest > CUT_BEYOND * u_map_size) longest = 3.0 * u_map_size;
    return 1.2e-7 * longest * longest / width;
}

// `grad_s`, `grad_t` of texel_gradients; `noise_m` and `ids` of the surface seen, `blur` of its triangle.
Receiver receiver_at(int map, vec4 q, vec3 grad_s, vec3 grad_t, vec3 x_ws, vec3 normal_ws, vec3 light_ws, float noise_m, float blur,
                     uvec2 ids, uint id) {
    Receiver r;
    r.blur = blur;
    r.normal_ws = normal_ws;
    r.light_ws = light_ws;
    r.map = map;
    r.log_warp = maps[map].log_warp;
    r.log_linear = maps[map].log_linear;
    r.facing = dot(normal_ws, light_ws);
    r.noise_m = noise_m;
    r.ids = ids;
    r.id = id;
    // steps: perpendicular to the ray, dual to the gradients
    vec3 along_s = cross(grad_t, light_ws), along_t = cross(light_ws, grad_s);
    r.step_s = along_s / dot(grad_s, along_s);
    r.step_t = along_t / dot(grad_t, along_t);
    return placed_at(r, x_ws, q);
}

// Change of clip_at from the receiver to NDC (s, t, depth).
vec4 clip_offset(Receiver r, vec3 q) {
    vec3 d = q - r.q.xyz;
    if (ANY_LOG == 0 || r.log_warp.w == 0.0) return vec4(d, 0.0);
    float base = r.log_linear.z, slope = r.log_linear.w, grown = r.clip.w * (exp2(d.y / r.log_warp.x) - 1.0);
    float dw = grown * (base + slope * r.clip.w) / (base - slope * grown);
    return vec4(r.log_warp.z == 0.0 ? d.x : q.x * dw + d.x * r.clip.w, r.log_linear.x * dw, d.z, dw);
}

// Metres by which the point of the map at NDC (s, t, depth) stands above the receiver's plane (negative: below).
float height_above(Receiver r, vec3 q) {
    vec4 d = clip_offset(r, q);
    return dot(r.height_row, d) / (r.w + dot(r.w_row, d));
}

// Metres from the receiver towards the light to the point of its own ray with that NDC depth.
float distance_above(Receiver r, float depth) {
    vec4 d = vec4(0.0, 0.0, depth - r.q.z, 0.0);
    return dot(r.distance_row, d) / (r.w + dot(r.w_row, d));
}

// Metres along the ray that one step of the depth format stands for at this place of the warped map (and what interpolating it loses).
float depth_step_m(Receiver r) { return abs(r.distance_row.z / r.w) * 2.4e-7; }

// Height above the plane gained over half a texel, in the worst direction.
float tilt_m(Receiver r) { return 0.5 * (abs(dot(r.normal_ws, r.step_s)) + abs(dot(r.normal_ws, r.step_t))); }

// The longer side of the texel, across the ray.
float footprint_m(Receiver r) { return max(length(r.step_s), length(r.step_t)); }

vec2 cell_ndc(ivec2 cell) { return (vec2(cell) + 0.5) * (2.0 / u_map_size) - 1.0; }

ivec2 clamped_cell(ivec2 cell) { return clamp(cell, ivec2(0), ivec2(int(u_map_size) - 1)); }
