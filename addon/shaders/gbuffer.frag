// View depth in metres, shading normal, and which triangle of which instance: all else is looked up when shading.
#include "common_octahedral.glsl"
#include "common_surface.glsl"
#if PEEL   // of the surfaces before what is there already, the nearest behind those of the layer before (depth peeling, Everitt 2001)
uniform sampler2D u_view_depth, u_peeled_depth;
uniform int u_is_first;

void peel(float depth) {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float whole = texelFetch(u_view_depth, pixel, 0).r;
    if (whole != 0.0 && depth >= whole) discard;
    if (u_is_first == 0) {
        float before = texelFetch(u_peeled_depth, pixel, 0).r;
        if (before == 0.0 || depth <= before) discard;
    }
}
#endif
flat in uint v_slot;
in vec3 v_normal_ws;
layout(location = 0) out float out_view_depth;
layout(location = 1) out vec2 out_normal;
layout(location = 2) out uvec2 out_ids;  // slot + 1, triangle in the index pool

void main() {
    out_view_depth = u_near + seen_behind_near();
#if PEEL
    peel(out_view_depth);
#endif
    out_normal = octahedral(v_normal_ws);
    out_ids = uvec2(v_slot + 1u, seen_triangle());
}
