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
float height_of(Receiver r, ivec2 cell) {
    ivec3 at = ivec3(clamped_cell(cell), r.map);
    return height_above(r, vec3(cell_ndc(at.xy), texelFetch(u_shadow_depth, at, 0).r * 2.0 - 1.0));
}

// Automatic tests: whether a place is dark follows from the four cells round it, weighted by how near their centres are, so that an edge
// passes between centres and not along cells. At the foot of something less than FOOT_TEXELS texels above the plane the map cannot tell
// the lit side from the dark one: there the dark cells must outweigh the lit ones by more, so that no dark dots lie along lit creases.
// `within`: from the own cell's centre towards the others', 0 ... 0.5. Order: own, next in s, next in t, next in both.
bool is_dark_between(vec4 heights, bvec4 dark, vec2 within, float low) {
    vec2 own = 1.0 - within;
    float share = dot(vec4(dark), vec4(own.x * own.y, within.x * own.y, own.x * within.y, within.x * within.y));
    vec4 standing = mix(vec4(1e30), heights, vec4(dark));
    float lowest = min(min(standing.x, standing.y), min(standing.z, standing.w));
    return share >= (lowest <= low ? FOOT_SHARE : EDGE_SHARE);
}
#endif

// `at`: the place of the tap, in texels.
float light_through(Receiver r, Limits limits, vec2 at) {
    ivec2 cell = ivec2(floor(at));
    ivec3 stored = ivec3(clamped_cell(cell), r.map);
#if DEPTHS == 1
#if TEST == TEST_ID_DEPTH || BIAS == BIAS_AUTOMATIC
    vec2 from_centre = at - vec2(cell) - 0.5;
    ivec2 side = ivec2(from_centre.x < 0.0 ? -1 : 1, from_centre.y < 0.0 ? -1 : 1);
    vec4 heights;
    bvec4 dark;
    for (int i = 0; i < 4; ++i) {
        ivec3 place = ivec3(clamped_cell(cell + side * ivec2(i & 1, i >> 1)), r.map);
        float depth = texelFetch(u_shadow_depth, place, 0).r * 2.0 - 1.0;
        heights[i] = height_above(r, vec3(cell_ndc(place.xy), depth));
#if TEST == TEST_ID_DEPTH
        dark[i] = is_dark(r, limits, heights[i], depth, texelFetch(u_shadow_ids, place, 0).r);
#else
        dark[i] = heights[i] > limits;
#endif
    }
#if TEST == TEST_ID_DEPTH
    if (u_epsilon >= 0.0 || u_epsilon_far >= 0.0) return dark[0] ? 0.0 : 1.0;  // by hand: the text's own cell
#endif
    return is_dark_between(heights, dark, abs(from_centre), FOOT_TEXELS * footprint_m(r)) ? 0.0 : 1.0;
#else
    return stands_before(r, limits, cell, texelFetch(u_shadow_depth, stored, 0).r * 2.0 - 1.0) ? 0.0 : 1.0;
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
