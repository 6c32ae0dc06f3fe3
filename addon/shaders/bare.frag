// The yardstick of the benchmark: the G-buffer's targets written plainly.
flat in uint v_slot;
in vec3 v_normal_ws;
in float v_view_depth;
layout(location = 0) out float out_view_depth;
layout(location = 1) out vec2 out_normal;
layout(location = 2) out uvec2 out_ids;

void main() {
    out_view_depth = v_view_depth;
    out_normal = v_normal_ws.xy;
    out_ids = uvec2(v_slot, uint(gl_PrimitiveID));
}
