// Second layer of an impostor's capture: the nearest surface behind the first, where the solid seen first ends.
// An open sheet has no such end: there the layer repeats the first one's depth, and the solid has no thickness.
#include "common_octahedral.glsl"
flat in uint v_slot;
in vec3 v_normal_ws;
in float v_view_depth;
uniform int u_first_triangle;
uniform sampler2D u_view_depth;    // first layer, metres
uniform mat3 u_along_from_pixel;
uniform float u_apart;             // metres that tell two surfaces apart
layout(location = 0) out float out_view_depth;
layout(location = 1) out vec2 out_normal;
layout(location = 2) out uvec2 out_ids;

void main() {
    float front = texelFetch(u_view_depth, ivec2(gl_FragCoord.xy), 0).r;
    if (v_view_depth <= front + u_apart) discard;
    bool faces_away = dot(v_normal_ws, u_along_from_pixel * vec3(gl_FragCoord.xy, 1.0)) > 0.0;
    out_view_depth = faces_away ? v_view_depth : front;
    out_normal = octahedral(v_normal_ws);
    out_ids = uvec2(v_slot + 1u, uint(u_first_triangle + gl_PrimitiveID));
}
