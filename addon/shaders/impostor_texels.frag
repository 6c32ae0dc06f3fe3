// From four samples to a texel: the nearest surface among them, as a plane about the texel's centre. A texel of which not all samples lie on
// it is an edge and has the sign of its relief changed; `impostor_edges.frag` says what its other samples show.
#include "common_impostor_samples.glsl"
uniform sampler2D u_back_layers;
uniform usampler2D u_back_ids;
layout(location = 0) out vec4 out_layers;      // as in common_impostor.glsl
layout(location = 1) out vec2 out_normal;      // of the front
layout(location = 2) out uvec4 out_both_ids;
layout(location = 3) out vec4 out_final_layers; // the same, where the edges' samples are put in; the depth lets that pass run on edges alone

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec4 layers[4];
    uvec2 ids[4];
    int own = -1;
    for (int k = 0; k < 4; ++k) {
        layers[k] = texelFetch(u_sample_layers, sample_at(texel, k), 0);
        ids[k] = texelFetch(u_sample_ids, sample_at(texel, k), 0).rg;
        if (ids[k].r > 0u && (own < 0 || layers[k].x < layers[own].x)) own = k;
    }
    out_layers = out_final_layers = vec4(EMPTY, 0.0, 0.0, -1.0);
    gl_FragDepth = 0.0;
    out_normal = vec2(0.0);
    out_both_ids = uvec4(0u);
    if (own < 0) return;
    vec4 nearest = layers[own];
    vec2 slope = limited(2.0 * nearest.yz);
    vec3 normal = from_octahedral(texelFetch(u_sample_normal, sample_at(texel, own), 0).rg), sum = vec3(0.0);
    bool whole = true;
    for (int k = 0; k < 4; ++k) {
        vec3 other = from_octahedral(texelFetch(u_sample_normal, sample_at(texel, k), 0).rg);
        float expected = nearest.x + dot(slope, sample_place(k) - sample_place(own));
        whole = whole && continues(layers[k].x, expected, normal, other, ids[k], ids[own]);
        sum += other;
    }
    float a = nearest.x - dot(slope, sample_place(own));
    if (whole) {
        a = 0.25 * (layers[0].x + layers[1].x + layers[2].x + layers[3].x);
        slope = limited(vec2(layers[1].x + layers[3].x - layers[0].x - layers[2].x, layers[2].x + layers[3].x - layers[0].x - layers[1].x));
        normal = normalize(sum);
    }
    ivec2 at = sample_at(texel, own);
    uvec2 back_ids = texelFetch(u_back_ids, at, 0).rg;
    float back = back_ids.r > 0u ? texelFetch(u_back_layers, at, 0).x : 0.0;
    a = max(a, 0.0);
    out_layers = out_final_layers = vec4(whole ? a : -max(a, 1e-20), slope, max(a, back));
    gl_FragDepth = whole ? 0.0 : 1.0;
    out_normal = octahedral(normal);
    out_both_ids = uvec4(ids[own], back_ids);
}
