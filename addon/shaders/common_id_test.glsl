// Combined ID + depth (IDD §5.4): dark iff d_map + far < d, or the ids differ and d_map + near < d.
//
// Distances are metres along the ray. By hand (EPSILONS given): d is the receiver's own depth, as in the text. Automatic, per pixel:
// d is the depth of the receiver's plane at the cell's centre; near is what the map cannot tell from that plane (footprint, slope, depth
// format at this place of the warped map); far is the depth over which a surface of the same object can rise within FAR_TEXELS texels,
// and at most the object's own extent along the light, since no two points of it can be farther apart.
struct Limits {
    float near_m;
    float far_m;
};
uniform float u_epsilon, u_epsilon_far;   // metres; negative: automatic
uniform samplerBuffer u_extents;          // half extents in world space of the object of each slot

float extent_along_light(Receiver r) {
    return 2.0 * dot(abs(r.light_ws), texelFetch(u_extents, int(r.ids.x) - 1).xyz);
}

Limits limits_of(inout Receiver r) {
    float facing = max(r.facing, 1.0 / STEEPEST_TANGENT);
    float near_m = u_epsilon >= 0.0 ? u_epsilon : automatic_bias_m(r) / facing;
    float far_m = u_epsilon_far >= 0.0 ? u_epsilon_far : min(FAR_TEXELS * footprint_m(r) / facing, extent_along_light(r));
    return Limits(near_m, max(near_m, far_m));
}

bool is_dark(Receiver r, Limits limits, ivec2 cell, float height, float depth, uint id) {
    float to_plane = height / max(r.facing, 1.0 / STEEPEST_TANGENT), to_receiver = distance_above(r, depth);
    float near_side = u_epsilon >= 0.0 ? to_receiver : to_plane;
    float far_side = u_epsilon_far >= 0.0 ? to_receiver : to_plane;
    return far_side > limits.far_m || (id != r.id && near_side > limits.near_m);
}

bool is_smoothed() { return u_epsilon < 0.0 && u_epsilon_far < 0.0; }   // by hand: the text's own cell
#include "common_shadow_cells.glsl"
