// What the samples of an edge texel show, put into its slopes: `common_impostor.glsl` says how. Runs on edge texels alone.
#include "common_impostor.glsl"
#include "common_impostor_samples.glsl"
uniform sampler2D u_front_normals;
uniform usampler2D u_both_ids;
layout(location = 0) out vec4 out_layers;

// A slope with eight bits of codes in place of its last; never so small that it would be taken for 0.
float carrying(float slope, uint code) {
    return uintBitsToFloat((floatBitsToUint(abs(slope) < 1e-30 ? 1e-30 : slope) & ~255u) | code);
}

// How unlike the samples and the surface of a texel of these layers are: texels of depth, turns of the normal, another object.
vec4 unlike(vec4 layers, ivec2 cell, vec3 normal, uint slot, vec2 centre, vec4 a, vec3 normals[4], uvec4 slots) {
    vec4 cost;
    for (int k = 0; k < 4; ++k) {
        float apart = min(abs(front_at(layers, cell, centre + sample_place(k)) - a[k]) / u_unit, 50.0);
        float turned = 4.0 - 4.0 * dot(normals[k], normal);
        cost[k] = apart + turned + (slot == slots[k] ? 0.0 : 100.0);
    }
    return is_empty(layers) ? vec4(1e9) : cost;
}

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy), cell = ivec2(texel.x, u_size.y - 1 - texel.y);
    vec2 centre = vec2(cell) + 0.5;
    vec4 a, least = vec4(1e10);
    vec3 normals[4];
    uvec4 slots, code = uvec4(15u);
    for (int k = 0; k < 4; ++k) {
        ivec2 at = sample_at(texel, k);
        slots[k] = texelFetch(u_sample_ids, at, 0).r;
        a[k] = texelFetch(u_sample_layers, at, 0).x;
        normals[k] = from_octahedral(texelFetch(u_sample_normal, at, 0).rg);
    }
    for (uint c = 0u; c < 9u; ++c) {
        ivec2 there = cell + neighbour(c);
        vec3 normal = from_octahedral(texelFetch(u_front_normals, texel_at(there), 0).rg);
        vec4 cost = unlike(layers_at(there), there, normal, texelFetch(u_both_ids, texel_at(there), 0).r, centre, a, normals, slots);
        for (int k = 0; k < 4; ++k)
            if (slots[k] > 0u && cost[k] < least[k]) { least[k] = cost[k]; code[k] = c; }
    }
    uint codes = code.x | code.y << 4u | code.z << 8u | code.w << 12u;
    vec4 layers = layers_at(cell);
    out_layers = vec4(layers.x, carrying(layers.y, codes & 255u), carrying(layers.z, codes >> 8u), layers.w);
}
