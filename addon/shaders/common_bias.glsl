// Does a depth of the map stand before the receiver? BIAS chooses what keeps surfaces from shadowing themselves.
//
// constant, slope-scaled: the receiver's own depth against the cell's, u_bias in metres or texels.
// normal-offset: the same without a bias, the receiver having been moved along its normal (common_filter.glsl) by u_bias texels * sin.
// receiver-plane: against the depth of the receiver's plane at the cell's centre (guarded, clamped), u_bias in texels.
// automatic: height above the receiver's plane against what the map cannot tell from the plane.
uniform float u_bias;

// Share of a texel's tilt by which neighbours on a curved or creased surface, and slivers' interpolated depths, stand up (more on slivers
// that are thousands of texels long); the depth format; rounding.
float automatic_bias_m(Receiver r) { return max(AUTO_TILT, r.blur) * tilt_m(r) + 2.0 * depth_step_m(r) * r.facing + r.noise_m; }

float tangent(Receiver r) { return sqrt(max(1.0 - r.facing * r.facing, 0.0)) / max(r.facing, 1.0 / STEEPEST_TANGENT); }

float bias_m(Receiver r) {
#if BIAS == BIAS_AUTOMATIC
    return automatic_bias_m(r);
#elif BIAS == BIAS_CONSTANT
    return u_bias;
#elif BIAS == BIAS_SLOPE_SCALED
    return u_bias * footprint_m(r) * min(tangent(r), STEEPEST_TANGENT) + depth_step_m(r) + r.noise_m;
#elif BIAS == BIAS_NORMAL_OFFSET
    return depth_step_m(r) + r.noise_m;
#else
    return u_bias * footprint_m(r) + depth_step_m(r) + r.noise_m;
#endif
}

bool stands_before(Receiver r, float bias_m, ivec2 cell, float depth) {
#if BIAS == BIAS_AUTOMATIC
    return height_above(r, vec3(cell_ndc(cell), depth)) > bias_m;
#elif BIAS == BIAS_RECEIVER_PLANE
    // where the plane lies at the cell's centre, towards the light; the determinant is that of (step_s, step_t, plane): facing
    vec2 d = vec2(cell) + 0.5 - r.texel;
    float rise = -dot(r.normal_ws, d.x * r.step_s + d.y * r.step_t) / max(r.facing, 1e-3);
    float most = STEEPEST_TANGENT * length(d.x * r.step_s + d.y * r.step_t);
    return distance_above(r, depth) > clamp(rise, -most, most) + bias_m;
#else
    return distance_above(r, depth) > bias_m;
#endif
}
