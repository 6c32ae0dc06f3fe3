// One layer of an impostor's capture, sample by sample: relief with its slope, normal, ids. LAYER 1 is the nearest surface behind the first,
// where the solid seen first ends. An open sheet has no such end: there the layer repeats the first one, and the solid has no thickness.
#include "common_octahedral.glsl"
#include "common_surface.glsl"
flat in uint v_slot;
in vec3 v_normal_ws;
uniform float u_plane;             // metres from the near plane to the impostor's
#if LAYER
uniform sampler2D u_sample_layers; // first layer
uniform usampler2D u_sample_ids;
uniform mat3 u_along_from_pixel;
uniform float u_apart;             // metres that tell two surfaces apart
#endif
layout(location = 0) out vec4 out_layers;   // a = |relief|, its change per pixel to the right and downwards, view depth
layout(location = 1) out vec2 out_normal;
layout(location = 2) out uvec2 out_ids;

void main() {
    float behind = seen_behind_near(), view_depth = u_near + behind, a = behind - u_plane;
    if (PERSPECTIVE) a /= view_depth;
    out_layers = vec4(max(a, 0.0), dFdx(a), -dFdy(a), view_depth);
    out_normal = octahedral(v_normal_ws);
    out_ids = uvec2(v_slot + 1u, seen_triangle());
#if LAYER
    vec4 first = texelFetch(u_sample_layers, ivec2(gl_FragCoord.xy), 0);
    if (texelFetch(u_sample_ids, ivec2(gl_FragCoord.xy), 0).r == 0u || view_depth <= first.w + u_apart) discard;
    bool faces_away = dot(v_normal_ws, u_along_from_pixel * vec3(gl_FragCoord.xy, 1.0)) > 0.0;
    if (!faces_away) out_layers = first;
#endif
}
