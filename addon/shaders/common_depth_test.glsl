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

// Height of the occluder where the receiver's ray is, not where the cell's centre is: in a concave corner the wall that a cell shows rises
// from the receiver's own place. Followed back with the rise towards the cell beyond, RISE times, at most half a texel; never upwards.
float height_at_ray(Receiver r, ivec2 cell, float depth) {
    vec2 d = vec2(cell) + 0.5 - r.texel;
    float h = height_above(r, vec3(cell_ndc(cell), depth));
    vec2 rise = vec2(height_of(r, cell + ivec2(d.x < 0.0 ? -1 : 1, 0)), height_of(r, cell + ivec2(0, d.y < 0.0 ? -1 : 1))) - h;
    return h - RISE * dot(max(rise, vec2(0.0)), min(abs(d), vec2(0.5)));
}
#endif

float light_through(Receiver r, Limits limits, ivec2 cell) {
    ivec3 at = ivec3(clamped_cell(cell), r.map);
#if DEPTHS == 1
    float depth = texelFetch(u_shadow_depth, at, 0).r * 2.0 - 1.0;
#if TEST == TEST_ID_DEPTH
    return is_dark(r, limits, height_at_ray(r, cell, depth), depth, texelFetch(u_shadow_ids, at, 0).r) ? 0.0 : 1.0;
#elif BIAS == BIAS_AUTOMATIC
    return height_at_ray(r, cell, depth) > limits ? 0.0 : 1.0;
#else
    return stands_before(r, limits, cell, depth) ? 0.0 : 1.0;
#endif
#else
    vec4 depths[2];
    depths[0] = texelFetch(u_cells_0, at, 0);
    depths[1] = DEPTHS > 4 ? texelFetch(u_cells_1, at, 0) : vec4(0.0);
#if TEST == TEST_ID_DEPTH
    uvec4 ids[2];
    ids[0] = texelFetch(u_cell_ids_0, at, 0);
    ids[1] = DEPTHS > 4 ? texelFetch(u_cell_ids_1, at, 0) : uvec4(0u);
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
