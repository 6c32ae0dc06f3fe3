// Percentage-closer filtering (Reeves): tests first, average after. PCF_SIDE taps per axis, TAP_SPACING apart.
//
// FILTER_UNIT: texels (classical: the softness follows the warp), pixels on the surface seen, or metres across the light's ray: in the last
// two the softness does not change with warp or partition.
const float MOST_TEXELS = 16.0;

// Texel offset of a tap that stands (x, y) units from the middle of the kernel. `on_surface` is the Jacobian of texels over pixels.
mat2 texels_from_unit(Receiver r, mat2 on_surface) {
#if FILTER_UNIT == FILTER_TEXELS
    return mat2(1.0);
#elif FILTER_UNIT == FILTER_PIXELS
    mat2 m = on_surface;
#else
    vec3 u = normalize(r.step_s), v = cross(r.light_ws, u);
    mat2 across = inverse(mat2(dot(r.step_s, u), dot(r.step_s, v), dot(r.step_t, u), dot(r.step_t, v)));
    mat2 m = across;
#endif
#if FILTER_UNIT != FILTER_TEXELS
    float reach = 0.5 * float(PCF_SIDE - 1) * TAP_SPACING * max(abs(m[0].x) + abs(m[1].x), abs(m[0].y) + abs(m[1].y));
    return m * min(1.0, MOST_TEXELS / max(reach, 1e-6));
#endif
}

vec2 tap_offset(mat2 units, int x, int y) { return units * ((vec2(x, y) - 0.5 * float(PCF_SIDE - 1)) * TAP_SPACING); }

#if TEST == TEST_TRIANGLE
#include "common_triangle_test.glsl"

// Light reaching a receiver that faces the light, 0 ... 1.
float light_at(Receiver r, mat2 on_surface) {
    mat2 units = texels_from_unit(r, on_surface);
    const int taps = PCF_SIDE * PCF_SIDE;
    vec3 offsets[PCF_SIDE * PCF_SIDE];
    vec2 low = vec2(0.0), high = vec2(0.0);
    for (int i = 0; i < taps; ++i) {
        vec2 d = tap_offset(units, i % PCF_SIDE, i / PCF_SIDE);
        low = min(low, d);
        high = max(high, d);
        // slid along the light onto the receiver's plane: the ray is the one that PCF's cell stands for
        vec3 across = d.x * r.step_s + d.y * r.step_t;
        offsets[i] = across - r.light_ws * (dot(r.normal_ws, across) / max(r.facing, 1e-3));
    }
    ivec2 first = clamped_cell(ivec2(floor(r.texel + low)) - REACH), last = clamped_cell(ivec2(floor(r.texel + high)) + REACH);
    float far_m = u_epsilon_far >= 0.0 ? u_epsilon_far * r.facing : FAR_TEXELS * footprint_m(r);
    float lowest = 1e30;
    uint dark = 0u;
    uvec2 before = uvec2(0u), block;
    ivec2 cell = first;
    for (;;) {
        bool found = false;
        uvec2 ids;
        while (cell.y <= last.y && !found) {
            ids = texelFetch(u_shadow_ids, ivec3(cell, r.map), 0).rg;
            float depth = texelFetch(u_shadow_depth, ivec3(cell, r.map), 0).r * 2.0 - 1.0;
            lowest = min(lowest, height_above(r, vec3(cell_ndc(cell), depth)));
            block = ids.x == 0u || ids == r.ids ? before : block_of(ids);
            found = block != before;
            cell = cell.x == last.x ? ivec2(first.x, cell.y + 1) : cell + ivec2(1, 0);
        }
        if (!found) break;
        before = block;
        uint slot = block.x - 1u;
        uvec4 info = instance_info(slot);
        uint end = min(block.y + uint(BLOCK), texelFetch(u_spans, int(slot)).y);
        for (uint triangle = block.y; triangle < end; ++triangle) {
            Triangle t = triangle_seen_from(r, info, slot, triangle);
            bool other = uvec2(block.x, triangle) != r.ids;
            for (int i = 0; i < taps; ++i) if (other && hits(r, t, offsets[i])) dark |= 1u << uint(i);
        }
        if (dark == (1u << uint(taps)) - 1u) break;
    }
    int lit = lowest > far_m ? 0 : taps;
    for (int i = 0; i < taps; ++i) lit -= int((dark >> uint(i)) & 1u);
    return float(max(lit, 0)) / float(taps);
}
#else
#include "common_bias.glsl"
#include "common_depth_test.glsl"

// Light reaching a receiver that faces the light, 0 ... 1.
float light_at(Receiver r, mat2 on_surface) {
    mat2 units = texels_from_unit(r, on_surface);
#if TEST == TEST_DEPTH && BIAS == BIAS_NORMAL_OFFSET
    vec3 moved = r.position_ws + r.normal_ws * (u_bias * footprint_m(r) * sqrt(max(1.0 - r.facing * r.facing, 0.0)));
    r = placed_at(r, moved, project(r.map, moved));
#endif
    Limits limits = limits_of(r);
    float lit = 0.0;
    for (int y = 0; y < PCF_SIDE; ++y)
        for (int x = 0; x < PCF_SIDE; ++x)
            lit += light_through(r, limits, ivec2(floor(r.texel + tap_offset(units, x, y))));
    return lit / float(PCF_SIDE * PCF_SIDE);
}
#endif
