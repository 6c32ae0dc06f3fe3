// One receiver against one cell of the map: the share of the light that the cell lets through, 0 ... 1.
//
// DEPTHS = n > 1: the cell holds its own depth and n - 1 of its neighbours' (SMMVP §4.5, written by nsm.frag) and the answer is the
// composite test's s / n, counted as light. Each depth is compared where it was stored, so a tilted plane does not shadow itself.
#if TEST == TEST_ID_DEPTH
#include "common_id_test.glsl"
#else
#define Limits float
Limits limits_of(Receiver r) { return bias_m(r); }
#endif
#if DEPTHS == 1
uniform sampler2DArray u_shadow_depth;
#else
#include "common_neighbours.glsl"
uniform sampler2DArray u_cells_0, u_cells_1;
#endif
#if TEST == TEST_ID_DEPTH
#if DEPTHS == 1
uniform usampler2DArray u_shadow_ids;
#else
uniform usampler2DArray u_cell_ids_0, u_cell_ids_1;
#endif
#endif

#if DEPTHS == 1
float depth_of(Receiver r, ivec2 cell) { return texelFetch(u_shadow_depth, ivec3(clamped_cell(cell), r.map), 0).r * 2.0 - 1.0; }

float height_of(Receiver r, ivec2 cell) { return height_above(r, vec3(cell_ndc(cell), depth_of(r, cell))); }

// At the foot of something low the map cannot tell the lit side from the dark one: of the four cells round the place `at` one shows the
// receiver's own plane (or what lies below it), another something less than FOOT_TEXELS texels above it. Such a place is lit: a dark dot
// on a lit crease is seen, a shadow that begins half a texel later is not.
bool is_at_foot(Receiver r, float bias, vec2 at, ivec2 cell, float height) {
    if (height > FOOT_TEXELS * footprint_m(r)) return false;
    vec2 d = at - vec2(cell) - 0.5;
    ivec2 side = ivec2(d.x < 0.0 ? -1 : 1, d.y < 0.0 ? -1 : 1);
    float lowest = min(height_of(r, cell + ivec2(side.x, 0)), min(height_of(r, cell + ivec2(0, side.y)), height_of(r, cell + side)));
    return lowest <= bias;
}
#endif

// `at`: the place of the tap, in texels.
float light_through(Receiver r, Limits limits, vec2 at) {
    ivec2 cell = ivec2(floor(at));
    ivec3 stored = ivec3(clamped_cell(cell), r.map);
#if DEPTHS == 1
    float depth = texelFetch(u_shadow_depth, stored, 0).r * 2.0 - 1.0;
#if TEST == TEST_ID_DEPTH || BIAS == BIAS_AUTOMATIC
    float height = height_above(r, vec3(cell_ndc(cell), depth));
#endif
#if TEST == TEST_ID_DEPTH
    bool dark = is_dark(r, limits, height, depth, texelFetch(u_shadow_ids, stored, 0).r);
    return dark && !(u_epsilon < 0.0 && is_at_foot(r, automatic_bias_m(r), at, cell, height)) ? 0.0 : 1.0;
#elif BIAS == BIAS_AUTOMATIC
    return height > limits && !is_at_foot(r, limits, at, cell, height) ? 0.0 : 1.0;
#else
    return stands_before(r, limits, cell, depth) ? 0.0 : 1.0;
#endif
#else
    vec4 depths[2];
    depths[0] = texelFetch(u_cells_0, stored, 0);
    depths[1] = DEPTHS > 4 ? texelFetch(u_cells_1, stored, 0) : vec4(0.0);
#if TEST == TEST_ID_DEPTH
    uvec4 ids[2];
    ids[0] = texelFetch(u_cell_ids_0, stored, 0);
    ids[1] = DEPTHS > 4 ? texelFetch(u_cell_ids_1, stored, 0) : uvec4(0u);
#endif
    int lit = 0;
    for (int i = 0; i < DEPTHS; ++i) {
        ivec2 place = cell + place_of(i, depths[0]);
        float depth = depths[i / 4][i % 4] * 2.0 - 1.0;
#if TEST == TEST_ID_DEPTH
        lit += is_dark(r, limits, height_above(r, vec3(cell_ndc(place), depth)), depth, ids[i / 4][i % 4]) ? 0 : 1;
#else
        lit += stands_before(r, limits, place, depth) ? 0 : 1;
#endif
    }
    return float(lit) / float(DEPTHS);
#endif
}
