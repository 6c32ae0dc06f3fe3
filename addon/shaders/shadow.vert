// Caster pass of one shadow map.
#include "common_vertex.glsl"
#include "common_caster_id.glsl"
uniform vec3 u_origin;            // a place near what the map shows
uniform mat4 u_clip_from_world;   // of places relative to it, so that nothing large cancels
#if IDS == 3
out vec2 v_depth_w;
#endif

void main() {
    pass_id();
    gl_Position = u_clip_from_world * vec4(vertex_ws() - u_origin, 1.0);
#if IDS == 3
    v_depth_w = gl_Position.zw;
#endif
}
