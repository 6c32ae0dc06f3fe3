// A relief texture: per texel the front surface as a small plane (depth a = |relief|, its gradient per texel) and the depth of its back.
const float EMPTY = 1e9;
uniform sampler2D u_layers;         // a, da/du, da/dv, back
uniform ivec2 u_size;
uniform vec3 u_warp;                // K1, K2, K3 with the sign that relief has behind the plane

ivec2 texel_at(ivec2 cell) { return ivec2(cell.x, u_size.y - 1 - cell.y); }  // v runs downwards, GL's rows upwards

vec4 layers_at(ivec2 cell) {
    if (any(lessThan(cell, ivec2(0))) || any(greaterThanEqual(cell, u_size))) return vec4(EMPTY, 0.0, 0.0, -1.0);
    return texelFetch(u_layers, texel_at(cell), 0);
}

float front_at(vec4 layers, ivec2 cell, vec2 uv) { return layers.x + dot(layers.yz, uv - (vec2(cell) + 0.5)); }

// The texture place that the view ray through the plane's point uv crosses at depth a: straight in (u, v, a).
vec2 ray_slope(vec2 uv) { return uv * u_warp.z - u_warp.xy; }
