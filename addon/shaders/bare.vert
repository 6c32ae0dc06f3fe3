// The yardstick of the benchmark: a plain transform.
in vec3 in_position;
uniform mat4 u_clip_from_world;
#if COLOR
in vec3 in_normal;
in uint in_slot;
uniform vec4 u_view_depth_from_world;
flat out uint v_slot;
out vec3 v_normal_ws;
out float v_view_depth;
#endif

void main() {
#if COLOR
    v_slot = in_slot;
    v_normal_ws = in_normal;
    v_view_depth = dot(u_view_depth_from_world, vec4(in_position, 1.0));
#endif
    gl_Position = u_clip_from_world * vec4(in_position, 1.0);
}
