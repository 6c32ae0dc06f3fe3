// Caster pass of a logarithmic map, exact path: homogeneous coordinates for the geometry stage.
#include "common_vertex.glsl"
#include "common_caster_id.glsl"
uniform mat4 u_clip_from_world;
out vec4 v_clip;

void main() {
    pass_id();
    v_clip = u_clip_from_world * vec4(vertex_ws(), 1.0);
    gl_Position = v_clip;
}
