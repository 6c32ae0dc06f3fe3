// Caster pass of one shadow map: pieces of large triangles, cut and projected in float64 (pipeline/passes/large_casters.py).
#include "common_instance.glsl"
#include "common_caster_id.glsl"
in vec4 in_clip;
#if IDS == 3
out vec2 v_depth_w;
#endif

void main() {
    pass_id();
    gl_Position = in_clip;
#if IDS == 3
    v_depth_w = gl_Position.zw;
#endif
}
