// For the tests that compare one receiver with the cells of the map: the share of the light that the map lets through, 0 ... 1.
//
// Before it the test's file has is_dark, which judges one stored depth, and is_smoothed. DEPTHS = n > 1: the cell holds its own depth and
// n - 1 of its neighbours' (SMMVP §4.5, written by nsm.frag) and the answer is the composite test's s / n, counted as light. Each depth is
// compared where it was stored, so a tilted plane does not shadow itself.
#if DEPTHS == 1
uniform sampler2DArray u_shadow_depth;
#else
#include "common_neighbours.glsl"
uniform sampler2DArray u_cells_0, u_cells_1;
#endif
#if IDS == 1 && DEPTHS == 1
uniform usampler2DArray u_shadow_ids;
#elif IDS == 1
uniform usampler2DArray u_cell_ids_0, u_cell_ids_1;
#endif

#if DEPTHS == 1
float height_of(Receiver r, ivec2 cell) {
    ivec3 at = ivec3(clamped_cell(cell), r.map);
    return height_above(r, vec3(cell_ndc(at.xy), texelFetch(u_shadow_depth, at, 0).r * 2.0 - 1.0));
}

// Smoothed: whether a place is dark follows from the four cells round it, weighted by how near their centres are, so that an edge
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

// A cell beyond the border has what the border's has.
bool is_dark_in(Receiver r, Limits limits, ivec2 cell, out float height) {
    ivec3 place = ivec3(clamped_cell(cell), r.map);
    float depth = texelFetch(u_shadow_depth, place, 0).r * 2.0 - 1.0;
    height = height_above(r, vec3(cell_ndc(place.xy), depth));
#if IDS == 1
    uint id = texelFetch(u_shadow_ids, place, 0).r;
#else
    uint id = 0u;
#endif
    return is_dark(r, limits, cell, height, depth, id);
}
#endif

// `step`: of the tap from the receiver's place, in texels.
float light_through(Receiver r, Limits limits, vec2 step) {
    vec2 at = r.texel + step;
    ivec2 cell = ivec2(floor(at));
#if DEPTHS == 1
    if (!is_smoothed()) {
        float height;
        return is_dark_in(r, limits, cell, height) ? 0.0 : 1.0;
    }
    vec2 from_centre = at - vec2(cell) - 0.5;
    ivec2 side = ivec2(from_centre.x < 0.0 ? -1 : 1, from_centre.y < 0.0 ? -1 : 1);
    vec4 heights;
    bvec4 dark;
    for (int i = 0; i < 4; ++i) {
        float height;
        dark[i] = is_dark_in(r, limits, cell + side * ivec2(i & 1, i >> 1), height);
        heights[i] = height;
    }
    return is_dark_between(heights, dark, abs(from_centre), FOOT_TEXELS * footprint_m(r)) ? 0.0 : 1.0;
#else
    ivec3 stored = ivec3(clamped_cell(cell), r.map);
    vec4 depths[2];
    depths[0] = texelFetch(u_cells_0, stored, 0);
    depths[1] = DEPTHS > 4 ? texelFetch(u_cells_1, stored, 0) : vec4(0.0);
    uvec4 ids[2];
#if IDS == 1
    ids[0] = texelFetch(u_cell_ids_0, stored, 0);
    ids[1] = DEPTHS > 4 ? texelFetch(u_cell_ids_1, stored, 0) : uvec4(0u);
#else
    ids[0] = ids[1] = uvec4(0u);
#endif
    int lit = 0, hidden = 0;
    float own_height = 0.0;
    for (int i = 0; i < DEPTHS; ++i) {
        ivec2 place = cell + place_of(i, depths[0]);
        float depth = depths[i / 4][i % 4] * 2.0 - 1.0, height = height_above(r, vec3(cell_ndc(place), depth));
        bool dark = is_dark(r, limits, place, height, depth, ids[i / 4][i % 4]);
        lit += dark ? 0 : 1;
        if (i == 0) own_height = height;
        if (dark && is_smoothed() && is_hidden(r, offset_on_plane(r, vec2(place) + 0.5 - r.texel))) ++hidden;
    }
    // depths where nobody sees the receiver's plane count as most of the others do; where there are none, it is a foot if the own one is low
    bool mostly_lit = lit + hidden == DEPTHS && lit == 0 ? own_height <= FOOT_TEXELS * footprint_m(r) : 2 * lit + hidden >= DEPTHS;
    return float(mostly_lit ? lit + hidden : lit) / float(DEPTHS);
#endif
}

bool stays_on_surface() { return is_smoothed(); }
#include "common_seen_taps.glsl"
