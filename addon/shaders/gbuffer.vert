// Camera pass: what each pixel centre sees.
#include "common_vertex.glsl"
#include "common_octahedral.glsl"
in uint in_normal;  // octahedral, two signed 16-bit numbers
#if !INSTANCED
in uint in_slot;
#endif
uniform mat4 u_clip_from_world;
uniform vec4 u_view_depth_from_world;  // row: view depth of a world point
flat out uint v_slot;
out vec3 v_normal_ws;
out float v_view_depth;

void main() {
    vec4 p = vec4(vertex_ws(), 1.0);
#if INSTANCED
    v_slot = vertex_slot();
    v_normal_ws = normalize(turned_normal_ws(v_slot, unpacked_octahedral(in_normal)));
#else
    v_slot = in_slot;
    v_normal_ws = unpacked_octahedral(in_normal);
#endif
    v_view_depth = dot(u_view_depth_from_world, p);
    gl_Position = u_clip_from_world * p;
}
