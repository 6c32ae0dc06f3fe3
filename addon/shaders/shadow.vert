// Caster pass of one shadow map.
#include "common_vertex.glsl"
#include "common_caster_id.glsl"
uniform mat4 u_clip_from_world;

void main() {
    pass_id();
    gl_Position = u_clip_from_world * vec4(vertex_ws(), 1.0);
}
