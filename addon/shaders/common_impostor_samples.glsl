// A texel's four samples at capture (k = 0...3: left to right, top to bottom), and its eight neighbours.
#include "common_octahedral.glsl"
uniform sampler2D u_sample_layers;  // a, its change per sample to the right and downwards, view depth
uniform sampler2D u_sample_normal;
uniform usampler2D u_sample_ids;
uniform float u_unit;               // change of a over a texel's depth

ivec2 sample_at(ivec2 texel, int k) { return texel * 2 + ivec2(k & 1, 1 - (k >> 1)); }   // GL's rows go upwards
vec2 sample_place(int k) { return vec2(k & 1, k >> 1) * 0.5 - 0.25; }                     // from the texel's centre, v downwards
vec2 limited(vec2 slope) { return slope * min(1.0, STEEPEST * u_unit / max(max(abs(slope.x), abs(slope.y)), 1e-30)); }

// Whether a sample lies on a surface: the same triangle, or near its plane with about its normal, on the same object.
bool continues(float a, float expected, vec3 normal, vec3 other, uvec2 ids, uvec2 theirs) {
    return ids.r == theirs.r && (ids.g == theirs.g || (abs(a - expected) <= 0.5 * u_unit && dot(normal, other) > 0.98));
}
