// Caster pass of one shadow map.
#include "common_vertex.glsl"
#include "common_caster_id.glsl"
uniform mat4 u_clip_from_world;
#if LOGARITHMIC
uniform vec4 u_log_warp;  // as ShadowMap.log_warp
#endif

void main() {
    pass_id();
    vec4 c = u_clip_from_world * vec4(vertex_ws(), 1.0);
#if LOGARITHMIC
    float w = max(c.w, 1e-6);
    c = vec4(u_log_warp.z == 0.0 ? c.x : c.x / w, u_log_warp.x * log2(w) + u_log_warp.y, c.z, 1.0);
#endif
    gl_Position = c;
}
