// Camera pass: pieces of large triangles, cut and projected in float64 (pipeline/passes/large_surfaces.py).
in vec3 in_seen;   // clip x, clip y, metres behind the near plane
in vec3 in_normal_ws;
in uint in_slot;
in uint in_triangle;
uniform vec4 u_clip_rule;     // clip z and w of a place t metres behind the near plane: x + y t, z + w t
flat out uint v_slot;
flat out uint v_triangle;
out vec3 v_normal_ws;
out float v_behind_near;

void main() {
    v_slot = in_slot;
    v_triangle = in_triangle;
    v_normal_ws = in_normal_ws;
    v_behind_near = in_seen.z;
    gl_Position = vec4(in_seen.xy, u_clip_rule.xz + u_clip_rule.yw * in_seen.z);
}
