// Exact coverage and depth of a triangle at the texel centre of a logarithmic map: t is inverted, the rest is straight.
#define v_id g_id
#include "common_shadow_ids.glsl"
uniform vec4 u_log_warp;
uniform float u_map_size;
flat in vec2 g_origin, g_side1, g_side2;
flat in vec3 g_depth;
const float TOLERANCE = 2e-6;  // of a side: neighbours overlap rather than leave a crack, which is harmless under a minimum

float crossed(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

void main() {
    vec2 st = gl_FragCoord.xy * (2.0 / u_map_size) - 1.0;
    float w = exp2((st.y - u_log_warp.y) / u_log_warp.x);
    vec2 p = vec2(u_log_warp.z == 0.0 ? st.x : st.x * w, w) - g_origin;
    float area = crossed(g_side1, g_side2);
    float u = crossed(p, g_side2) / area, v = crossed(g_side1, p) / area;
    if (u < -TOLERANCE || v < -TOLERANCE || u + v > 1.0 + TOLERANCE) discard;
    gl_FragDepth = clamp((g_depth.x + u * g_depth.y + v * g_depth.z) * 0.5 + 0.5, 0.0, 1.0);
    write_ids();
}
