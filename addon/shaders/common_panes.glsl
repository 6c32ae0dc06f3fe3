// What panes, surfaces that let light through, leave of the light that reaches a receiver: the product of the tints of those above its plane
// (pipeline/passes/panes.py). Between the centres of the four cells round a place it is interpolated.
#if PANES
uniform usampler2DArray u_panes;   // layer k of map i is image k * u_pane_stride + i; an empty one lies behind the far plane
uniform int u_pane_layers, u_pane_stride;
const float PANE_TILT = 0.05;      // share of half a cell's tilt by which a bent pane may stand above its own plane

vec3 pane_tint(uint bits) { return vec3(uvec3(bits, bits >> 10, bits >> 20) & 1023u) / 1023.0; }

vec3 tint_in(Receiver r, ivec2 cell, vec2 ndc, float least) {
    vec3 tint = vec3(1.0);
    for (int k = 0; k < u_pane_layers; ++k) {
        uvec2 pane = texelFetch(u_panes, ivec3(cell, k * u_pane_stride + r.map), 0).rg;
        float depth = uintBitsToFloat(pane.r);
        if (depth > 1.0) break;
        if (height_above(r, vec3(ndc, depth)) > least) tint *= pane_tint(pane.g);
    }
    return tint;
}

vec3 tint_at(Receiver r) {
    int side = textureSize(u_panes, 0).x;
    vec2 at = (r.q.xy * 0.5 + 0.5) * float(side) - 0.5;
    ivec2 first = ivec2(floor(at));
    vec2 part = at - vec2(first);
    float least = PANE_TILT * tilt_m(r) * u_map_size / float(side) + 2.0 * depth_step_m(r) * r.facing + r.noise_m;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1), cell = clamp(first + step, ivec2(0), ivec2(side - 1));
        vec2 share = mix(1.0 - part, part, vec2(step));
        sum += share.x * share.y * tint_in(r, cell, (vec2(cell) + 0.5) * (2.0 / float(side)) - 1.0, least);
    }
    return sum;
}
#endif
