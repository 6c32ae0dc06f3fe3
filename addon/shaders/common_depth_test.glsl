// The depth test: the map's depth against the receiver's, with the bias of common_bias.glsl.
#define Limits float   // the bias, metres

Limits limits_of(inout Receiver r) {
#if BIAS == BIAS_NORMAL_OFFSET
    vec3 moved = r.position_ws + r.normal_ws * (u_bias * footprint_m(r) * sqrt(max(1.0 - r.facing * r.facing, 0.0)));
    r = placed_at(r, moved, project(r.map, moved));
#endif
    return bias_m(r);
}

bool is_dark(Receiver r, Limits bias, ivec2 cell, float height, float depth, uint id) {
#if BIAS == BIAS_AUTOMATIC
    return height > bias;
#else
    return stands_before(r, bias, cell, depth);
#endif
}

bool is_smoothed() { return BIAS == BIAS_AUTOMATIC; }
#include "common_shadow_cells.glsl"

#if BIAS == BIAS_AUTOMATIC && DEPTHS == 1 && IS_TEXEL_APART
// The heights of the cells are looked up once for all taps. Counted from the corner away from the receiver's side of its cell, so that the
// cells round a place are its own and the next.
#define HAS_OWN_FILTER
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
    float own = PCF_SIDE > 1 ? light_through(r, bias, vec2(0.0)) : 1.0;
    for (int i = 0; i < PCF_SIDE * PCF_SIDE; ++i) {
        int k = i % PCF_SIDE + cells * (i / PCF_SIDE);
        vec4 four = vec4(heights[k], heights[k + 1], heights[k + cells], heights[k + cells + 1]);
        float through = is_dark_between(four, greaterThan(four, vec4(bias)), abs(from_centre), low) ? 0.0 : 1.0;
        ivec2 tap = start + side * ivec2(i % PCF_SIDE, i / PCF_SIDE) - cell;
        lit += PCF_SIDE > 1 ? seen_light(r, tap_offset(mat2(1.0), tap.x, tap.y), through, own) : through;
    }
    return lit / float(PCF_SIDE * PCF_SIDE);
}
#endif
