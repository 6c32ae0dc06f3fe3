// Camera pass: what each pixel centre sees. Places are relative to an anchor near what is seen (maths/anchored_camera.py).
#include "common_vertex.glsl"
#include "common_octahedral.glsl"
in uint in_normal;  // octahedral, two signed 16-bit numbers
#if !INSTANCED
in uint in_slot;
#endif
uniform vec3 u_anchor;
uniform mat3x4 u_rows;        // clip x, clip y, metres behind the near plane
uniform vec4 u_clip_rule;     // clip z and w of a place t metres behind the near plane: x + y t, z + w t
flat out uint v_slot;
out vec3 v_normal_ws;
out float v_behind_near;

void main() {
    vec4 p = vec4(vertex_from(u_anchor), 1.0);
#if INSTANCED
    v_slot = vertex_slot();
    v_normal_ws = normalize(turned_normal_ws(v_slot, unpacked_octahedral(in_normal)));
#else
    v_slot = in_slot;
    v_normal_ws = unpacked_octahedral(in_normal);
#endif
    vec3 seen = p * u_rows;
    v_behind_near = seen.z;
    gl_Position = vec4(seen.xy, u_clip_rule.xz + u_clip_rule.yw * seen.z);
}
