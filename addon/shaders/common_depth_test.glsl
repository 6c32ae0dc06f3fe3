// One receiver against one cell of the map.
//
// The stored occluder is put back into world space on the light ray through the cell's centre, and its height above the receiver's
// plane decides: h = N . (X_occluder - X_receiver) > bias. A planar receiver never shadows itself, whatever the warp, and the bias is in metres.
uniform sampler2DArray u_shadow_depth;

struct Receiver {
    vec3 position_ws;
    vec3 normal_ws;      // geometric, on the lit side
    int map;
    vec4 q;              // project(map, position)
    float bias_m;        // height above the plane that counts as above
};

float stored_depth(int map, ivec2 cell) {
    ivec2 clamped = clamp(cell, ivec2(0), ivec2(int(u_map_size) - 1));
    return texelFetch(u_shadow_depth, ivec3(clamped, map), 0).r * 2.0 - 1.0;
}

vec2 cell_ndc(ivec2 cell) { return (vec2(cell) + 0.5) * (2.0 / u_map_size) - 1.0; }

// Metres by which the occluder stored in that cell stands above the receiver's plane (negative: below).
float occluder_height(Receiver r, ivec2 cell) {
    vec3 occluder_ws = unproject(r.map, vec3(cell_ndc(cell), stored_depth(r.map, cell)));
    return dot(r.normal_ws, occluder_ws - r.position_ws);
}

float lit_by_cell(Receiver r, ivec2 cell) { return occluder_height(r, cell) > r.bias_m ? 0.0 : 1.0; }

// The automatic bias, metres above the plane: what the map cannot tell from the plane itself. Terms: the rasteriser's snapping and the share
// of a texel by which curved neighbours stand up (AUTO_TEXELS of the footprint, as far as the surface tilts against the light), one step of
// the depth format at this place of the warped map, and the rounding of float32 positions.
float automatic_bias_m(int map, vec4 q, vec3 x_ws, vec3 normal_ws, vec3 light_ws) {
    vec3 grad_s, grad_t;
    texel_gradients(map, q, grad_s, grad_t);
    // world vectors of one texel step, perpendicular to the light ray: columns of the pseudo-inverse of (grad_s, grad_t)
    vec3 gs = grad_s - light_ws * dot(grad_s, light_ws), gt = grad_t - light_ws * dot(grad_t, light_ws);
    float a = dot(gs, gs), b = dot(gs, gt), d = dot(gt, gt);
    float det = max(a * d - b * b, 1e-30);
    vec3 step_s = (d * gs - b * gt) / det, step_t = (a * gt - b * gs) / det;
    float tilt = abs(dot(normal_ws, step_s)) + abs(dot(normal_ws, step_t));
    vec3 deeper = unproject(map, vec3(q.xy, q.z + 2.0e-3));
    float metres_per_depth = length(deeper - x_ws) / 2.0e-3;
    float depth_step = metres_per_depth * 2.4e-7 * abs(dot(normal_ws, light_ws));
    float rounding = 5.0e-7 * (abs(x_ws.x) + abs(x_ws.y) + abs(x_ws.z));
    return AUTO_TEXELS * tilt + 2.0 * depth_step + rounding;
}
