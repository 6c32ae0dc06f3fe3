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
