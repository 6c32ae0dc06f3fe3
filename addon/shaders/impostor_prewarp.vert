// The texts' pre-warp: every texel moves to its place on the plane, nearer ones win. MESH: the squares between four texels are drawn too, which
// fills the holes by interpolation; else the texels alone, as points.
#include "common_impostor.glsl"
uniform vec4 u_extent;              // the part of the plane that the target shows
uniform float u_deepest;
flat out ivec2 v_texel;
out float v_relief;

const ivec2 CORNERS[6] = ivec2[6](ivec2(0, 0), ivec2(1, 0), ivec2(0, 1), ivec2(0, 1), ivec2(1, 0), ivec2(1, 1));

// Whether half of a texel or more shows something.
bool holds(ivec2 cell) {
    vec4 layers = layers_at(cell);
    if (is_empty(layers)) return false;
    if (!is_edge(layers)) return true;
    uint codes = codes_of(layers);
    int shown = 0;
    for (int k = 0; k < 4; ++k) shown += ((codes >> uint(4 * k)) & 15u) < 15u ? 1 : 0;
    return shown >= 2;
}

void main() {
#if MESH
    int square = gl_VertexID / 6, columns = u_size.x - 1;
    ivec2 base = ivec2(square % columns, square / columns), cell = base + CORNERS[gl_VertexID % 6];
    bool whole = true;
    for (int i = 0; i < 4; ++i) whole = whole && holds(base + ivec2(i & 1, i >> 1));
#else
    ivec2 cell = ivec2(gl_VertexID % u_size.x, gl_VertexID / u_size.x);
    bool whole = holds(cell);
#endif
    float relief = abs(layers_at(cell).x);
    vec2 warped = (vec2(cell) + 0.5 + u_warp.xy * relief) / (1.0 + u_warp.z * relief);
    vec2 place = (warped - u_extent.xy) / (u_extent.zw - u_extent.xy) * 2.0 - 1.0;
    v_texel = texel_at(cell);
    v_relief = relief;
    gl_Position = whole ? vec4(place.x, -place.y, relief / u_deepest * 2.0 - 1.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
    gl_PointSize = 1.0;
}
