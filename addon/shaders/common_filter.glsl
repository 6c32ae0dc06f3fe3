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

#include "common_bias.glsl"
#if TEST == TEST_TRIANGLE
#include "common_triangle_test.glsl"

// Light reaching a receiver that faces the light, 0 ... 1.
float light_at(Receiver r, mat2 on_surface) {
    mat2 units = texels_from_unit(r, on_surface);
    float lit = 0.0;
    for (int y = 0; y < PCF_SIDE; ++y)
        for (int x = 0; x < PCF_SIDE; ++x) lit += is_dark(r, tap_offset(units, x, y)) ? 0.0 : 1.0;
    return lit / float(PCF_SIDE * PCF_SIDE);
}
#else
#include "common_depth_test.glsl"

#if SHARED_HEIGHTS
// Automatic bias with taps a texel apart: the heights of the cells are looked up once for all taps. Counted from the corner away from the
// receiver's side of its cell, so that the cells round a place are its own and the next.
float light_at(Receiver r, mat2 on_surface) {
    const int cells = PCF_SIDE + 1;
    vec2 at = r.texel + tap_offset(mat2(1.0), 0, 0);
    ivec2 cell = ivec2(floor(at));
    vec2 from_centre = at - vec2(cell) - 0.5;
    ivec2 side = ivec2(from_centre.x < 0.0 ? -1 : 1, from_centre.y < 0.0 ? -1 : 1);
    ivec2 start = cell + ivec2(side.x < 0 ? PCF_SIDE - 1 : 0, side.y < 0 ? PCF_SIDE - 1 : 0);
    float heights[cells * cells];
    for (int i = 0; i < cells * cells; ++i) heights[i] = height_of(r, start + side * ivec2(i % cells, i / cells));
    float bias = automatic_bias_m(r), low = FOOT_TEXELS * footprint_m(r), lit = 0.0;
    for (int i = 0; i < PCF_SIDE * PCF_SIDE; ++i) {
        int k = i % PCF_SIDE + cells * (i / PCF_SIDE);
        vec4 four = vec4(heights[k], heights[k + 1], heights[k + cells], heights[k + cells + 1]);
        lit += is_dark_between(four, greaterThan(four, vec4(bias)), abs(from_centre), low) ? 0.0 : 1.0;
    }
    return lit / float(PCF_SIDE * PCF_SIDE);
}
#else
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
            lit += light_through(r, limits, r.texel + tap_offset(units, x, y));
    return lit / float(PCF_SIDE * PCF_SIDE);
}
#endif
#endif
