// A relief texture: per texel the front surface as a small plane (depth a = |relief|, its gradient per texel) and the depth of its back.
// The relief of an edge texel is negative. Which quarters of it show its own surface (0), which that of a neighbour (1...8) or nothing (15), four
// bits each, say the last eight bits of the two slopes, which is 1/30,000 of them.
uniform sampler2D u_layers;         // ±a, da/du, da/dv, back
uniform ivec2 u_size;
uniform mat3 u_plane_from_pixel;    // homogeneous (u, v) on the plane of a pixel, up to a factor, positive before the eye
uniform vec3 u_warp;                // K1, K2, K3 with the sign that relief has behind the plane

ivec2 texel_at(ivec2 cell) { return ivec2(cell.x, u_size.y - 1 - cell.y); }  // v runs downwards, GL's rows upwards
bool is_outside(ivec2 cell) { return any(lessThan(cell, ivec2(0))) || any(greaterThanEqual(cell, u_size)); }

const vec4 NOTHING = vec4(EMPTY, 0.0, 0.0, -1.0);

vec4 layers_at(ivec2 cell) { return is_outside(cell) ? NOTHING : texelFetch(u_layers, texel_at(cell), 0); }

bool is_empty(vec4 layers) { return layers.x >= EMPTY; }
bool is_edge(vec4 layers) { return layers.x < 0.0; }
float front_at(vec4 layers, ivec2 cell, vec2 uv) { return abs(layers.x) + dot(layers.yz, uv - (vec2(cell) + 0.5)); }

// Offset of the neighbour that a code 0...8 names: 0 the texel itself, then row by row. The numbers hold the offsets + 1, two bits a code.
ivec2 neighbour(uint code) { return ivec2((uvec2(149649u, 173313u) >> (2u * code)) & 3u) - 1; }

uint codes_of(vec4 layers) { return (floatBitsToUint(layers.y) & 255u) | ((floatBitsToUint(layers.z) & 255u) << 8); }

// The code of the quarter of an edge texel in which uv lies.
uint shown_at(vec4 layers, ivec2 cell, vec2 uv) {
    ivec2 quarter = clamp(ivec2(floor((uv - vec2(cell)) * 2.0)), ivec2(0), ivec2(1));
    return (codes_of(layers) >> uint(4 * quarter.x + 8 * quarter.y)) & 15u;
}

// The depth at which a ray meets a plane that lies at depth `front` where the ray starts, and is not seen from behind.
float depth_met(float front, vec2 gradient, vec2 slope) { return front / (1.0 - dot(gradient, slope)); }

// The texture place that the view ray through the plane's point uv crosses at depth a: straight in (u, v, a).
vec2 ray_slope(vec2 uv) { return uv * u_warp.z - u_warp.xy; }
