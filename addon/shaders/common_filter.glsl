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
// The shadow test chosen (settings/shadowing): the type `Limits` of what it works out once for all taps, `Limits limits_of(inout Receiver)`,
// which may move the receiver, and `float light_through(Receiver, Limits, vec2 step)`, the light that reaches it `step` texels beside its
// place. Tests of single cells have is_dark (`height`: metres of the stored depth over the receiver's plane, `depth`: NDC, `id`: stored with
// it) and is_smoothed, and take light_through from common_shadow_cells.glsl. Each ends with common_seen_taps.glsl, before which stands
// `bool stays_on_surface()`: whether taps that nobody sees count as the receiver's own place (not with limits given by hand, the texts' own).
#include SHADOW_TEST

#if SMOOTHING > 1
#include "common_shadow_edge.glsl"
#elif !defined(HAS_OWN_FILTER)
// Light reaching a receiver that faces the light, 0 ... 1.
float light_at(Receiver r, mat2 on_surface) {
    mat2 units = texels_from_unit(r, on_surface);
    Limits limits = limits_of(r);
    float own = light_through(r, limits, vec2(0.0)), lit = 0.0;
    if (PCF_SIDE == 1) return own;
    for (int i = 0; i < PCF_SIDE * PCF_SIDE; ++i) {
        vec2 step = tap_offset(units, i % PCF_SIDE, i / PCF_SIDE);
        lit += 2 * i + 1 == PCF_SIDE * PCF_SIDE ? own : seen_light(r, step, light_through(r, limits, step), own);
    }
    return lit / float(PCF_SIDE * PCF_SIDE);
}
#endif
