// What the samples of an edge texel show, put into its slopes: `common_impostor.glsl` says how. Runs on edge texels alone.
#include "common_impostor.glsl"
#include "common_impostor_samples.glsl"
uniform sampler2D u_both_normals;
uniform usampler2D u_both_ids;
layout(location = 0) out vec4 out_layers;

// A slope with eight bits of codes in place of its last; never so small that it would be taken for 0.
float carrying(float slope, uint code) {
    return uintBitsToFloat((floatBitsToUint(abs(slope) < 1e-30 ? 1e-30 : slope) & ~255u) | code);
}

// How unlike a sample and the surface of a texel (plane coordinates) are: texels of depth, turns of the normal, another object.
float unlike(ivec2 cell, vec2 uv, float a, vec3 normal, uint slot) {
    vec4 layers = layers_at(cell);
    if (is_empty(layers)) return 1e9;
    ivec2 texel = texel_at(cell);
    float apart = min(abs(front_at(layers, cell, uv) - a) / u_unit, 50.0);
    float turned = 4.0 - 4.0 * dot(normal, from_octahedral(texelFetch(u_both_normals, texel, 0).rg));
    return apart + turned + (texelFetch(u_both_ids, texel, 0).r == slot ? 0.0 : 100.0);
}

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy), cell = ivec2(texel.x, u_size.y - 1 - texel.y);
    vec4 layers = layers_at(cell);
    uint codes = 0u;
    for (int k = 0; k < 4; ++k) {
        ivec2 at = sample_at(texel, k);
        uint slot = texelFetch(u_sample_ids, at, 0).r, code = 15u;
        if (slot > 0u) {
            float a = texelFetch(u_sample_layers, at, 0).x, least = 1e10;
            vec3 normal = from_octahedral(texelFetch(u_sample_normal, at, 0).rg);
            for (uint c = 0u; c < 9u; ++c) {
                float cost = unlike(cell + neighbour(c), vec2(cell) + 0.5 + sample_place(k), a, normal, slot);
                if (cost < least) { least = cost; code = c; }
            }
        }
        codes |= code << uint(4 * k);
    }
    out_layers = vec4(layers.x, carrying(layers.y, codes & 255u), carrying(layers.z, codes >> 8), layers.w);
}
