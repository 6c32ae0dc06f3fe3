// View depth in metres, shading normal, and which triangle of which instance: all else is looked up when shading.
#include "common_octahedral.glsl"
#include "common_surface.glsl"
flat in uint v_slot;
in vec3 v_normal_ws;
layout(location = 0) out float out_view_depth;
layout(location = 1) out vec2 out_normal;
layout(location = 2) out uvec2 out_ids;  // slot + 1, triangle in the index pool

void main() {
    out_view_depth = u_near + seen_behind_near();
    out_normal = octahedral(v_normal_ws);
    out_ids = uvec2(v_slot + 1u, seen_triangle());
}
