// Percentage-closer filtering (Reeves): tests first, average after. PCF_SIDE taps per axis, TAP_SPACING apart.
//
// FILTER_UNIT: texels (classical: the softness follows the warp), pixels on the surface seen, or metres across the light's ray: in the last
// two the softness does not change with warp or partition.
// Texels per unit of the filter at the receiver. `on_surface` is the Jacobian of texels over pixels.
mat2 texels_from_unit(Receiver r, mat2 on_surface) {
#if FILTER_UNIT == FILTER_TEXELS
    return mat2(1.0);
#elif FILTER_UNIT == FILTER_PIXELS
    return on_surface;
#else
    vec3 u = normalize(r.step_s), v = cross(r.light_ws, u);
    return inverse(mat2(dot(r.step_s, u), dot(r.step_s, v), dot(r.step_t, u), dot(r.step_t, v)));
#endif
}

// Texel offset of tap (x, y) from the middle of the kernel.
vec2 tap_offset(mat2 units, int x, int y) { return units * ((vec2(x, y) - 0.5 * float(PCF_SIDE - 1)) * TAP_SPACING); }

#if TEST == TEST_TRIANGLE
#include "common_triangle_test.glsl"

// Light reaching a receiver that faces the light, 0 ... 1.
float light_at(Receiver r, mat2 on_surface) {
    mat2 units = texels_from_unit(r, on_surface);
    const int taps = PCF_SIDE * PCF_SIDE, window = 2 * REACH + 1;
    vec2 steps[PCF_SIDE * PCF_SIDE];
    vec3 offsets[PCF_SIDE * PCF_SIDE];
    for (int i = 0; i < taps; ++i) {
        steps[i] = tap_offset(units, i % PCF_SIDE, i / PCF_SIDE);
        // slid along the light onto the receiver's plane: the ray is the one that PCF's cell stands for
        vec3 across = steps[i].x * r.step_s + steps[i].y * r.step_t;
        offsets[i] = across - r.light_ws * (dot(r.normal_ws, across) / max(r.facing, 1e-3));
    }
    // cells: the box round all taps where they stand a texel apart, else the window round each
#if FILTER_UNIT == FILTER_TEXELS
    ivec2 first = ivec2(floor(r.texel + steps[0])) - REACH, box = ivec2(floor(r.texel + steps[taps - 1])) + REACH + 1 - first;
    int cells = box.x * box.y;
#else
    int cells = taps * window * window;
#endif
    float far_m = u_epsilon_far >= 0.0 ? u_epsilon_far * r.facing : FAR_TEXELS * footprint_m(r);
    float lowest = 1e30;
    uint dark = 0u;
    uvec2 before = uvec2(0u), block;
    int next = 0;
    for (;;) {
        bool found = false;
        while (next < cells && !found) {
#if FILTER_UNIT == FILTER_TEXELS
            ivec2 cell = first + ivec2(next % box.x, next / box.x);
#else
            int place = next % (window * window);
            ivec2 cell = ivec2(floor(r.texel + steps[next / (window * window)])) + ivec2(place % window, place / window) - REACH;
#endif
            ivec3 at = ivec3(clamped_cell(cell), r.map);
            uvec2 ids = texelFetch(u_shadow_ids, at, 0).rg;
            float depth = texelFetch(u_shadow_depth, at, 0).r * 2.0 - 1.0;
            lowest = min(lowest, height_above(r, vec3(cell_ndc(at.xy), depth)));
            block = ids.x == 0u || ids == r.ids ? before : block_of(ids);
            found = block != before;
            ++next;
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
