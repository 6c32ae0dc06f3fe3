// The part of the picture in which an impostor can be seen, in square blocks of pixels, each a point. Left out are those under which no ray
// comes near a surface. The others are sorted: under a smooth one all rays meet the same surface, without edges, gaps and folds, and a plane
// says about where; they are drawn by a shorter program than the rest. The depth is the fragment's business, so nothing is clipped by it.
#include "common_impostor.glsl"
#define INVERSE 0
#define PREWARPED 2
uniform ivec2 u_picture;            // pixels
uniform ivec2 u_first;              // the first block's place in the picture's grid of blocks
uniform int u_columns;              // blocks in a row
uniform float u_nearest, u_deepest; // between these the whole surface lies
uniform sampler2D u_windows;        // of OVERLAP strides squared of texels: nearest, behind all, all met if smooth (else EMPTY), steepest slope
uniform int u_stride;               // texels from one window to the next
uniform ivec2 u_last_window;
flat out float v_begin;             // depth before which no ray of the block meets anything
flat out vec3 v_guess;              // of a smooth block: the depth of a plane near the surface at u = v = 0, and its gradient

const float MISSES = 1e9, EDGE_ON = 0.9;

struct Block { vec2 low, high; bool is_beyond; };   // its rays' places on the plane; whether some never get there

Block block_at(vec2 pixel) {
    Block block = Block(vec2(1e9), vec2(-1e9), false);
    for (int k = 0; k < 4; ++k) {
        vec3 place = u_plane_from_pixel * vec3(pixel + float(BLOCK) * vec2(k & 1, k >> 1), 1.0);
        block.is_beyond = block.is_beyond || place.z <= 0.0;
        block.low = min(block.low, place.xy / place.z);
        block.high = max(block.high, place.xy / place.z);
    }
    return block;
}

// Where the ray through a place of the plane is at depth a; a sprite's stays where it is.
vec2 at_depth(vec2 uv, float a) { return METHOD == INVERSE ? uv + ray_slope(uv) * a : uv; }

// What the window that holds a box of texels says; of a box that is too large for it: anything may be there.
vec4 reach_of(vec2 first, vec2 last) {
    ivec2 window = ivec2(floor(first / float(u_stride))) + OVERLAP;
    vec4 reach = texelFetch(u_windows, clamp(window, ivec2(0), u_last_window), 0);
    return all(lessThanEqual(last, vec2(window * u_stride))) ? reach : vec4(-1.0, EMPTY, EMPTY, 0.0);
}

// From where on the block's rays may meet something (MISSES: never), and whether all of it is smooth: in steps over which they move by little,
// each judged by the box round all of them.
float first_reach(Block block, out bool is_smooth) {
    vec2 slope = METHOD == INVERSE ? max(abs(ray_slope(block.low)), abs(ray_slope(block.high))) : vec2(0.0), size = block.high - block.low;
    float fastest = max(slope.x, slope.y), room = float((OVERLAP - 1) * u_stride) - max(size.x, size.y) - 0.1;
    float pace = max(room / max(fastest, 1e-9), (u_deepest - u_nearest) / float(MOST_STEPS)), begin = MISSES;
    bool meets = false;
    is_smooth = true;
    int steps = 0;
    for (float a = u_nearest; a <= u_deepest && steps <= MOST_STEPS; a += pace, ++steps) {
        float until = min(a + pace, u_deepest);
        vec2 first = min(at_depth(block.low, a), at_depth(block.low, until)), last = max(at_depth(block.high, a), at_depth(block.high, until));
        vec4 reach = reach_of(first - 0.01, last + 0.01);
        if (reach.x > until) continue;
        begin = min(begin, a);
        meets = meets || reach.y >= a;
        is_smooth = is_smooth && reach.z < EMPTY && reach.w * fastest < EDGE_ON;
        if (is_smooth ? reach.z <= until : meets || SMOOTH == 1) return begin;
    }
    is_smooth = false;
    return meets ? begin : MISSES;
}

// The plane of the texel that the ray through uv meets, known to lie on a smooth surface: depth at u = v = 0 and gradient.
vec3 plane_met(vec2 uv, float a) {
    vec2 slope = ray_slope(uv);
    vec3 plane;
    for (int i = 0; i < 3; ++i) {
        ivec2 cell = clamp(ivec2(floor(uv + slope * a)), ivec2(0), u_size - 1);
        vec4 layers = texelFetch(u_layers, texel_at(cell), 0);
        plane = vec3(front_at(layers, cell, vec2(0.0)), layers.yz);
        a = depth_met(front_at(layers, cell, uv), layers.yz, slope);
    }
    return plane;
}

void main() {
    ivec2 place = BLOCK * (u_first + ivec2(gl_VertexID % u_columns, gl_VertexID / u_columns));
    vec2 middle = min(vec2(place + BLOCK / 2), max(vec2(u_picture - BLOCK / 2), 0.5 * vec2(u_picture)));   // a point is cut off by its middle
    Block block = block_at(middle - 0.5 * float(BLOCK));
    bool is_smooth = false;
    v_begin = METHOD == PREWARPED ? 0.0 : block.is_beyond ? u_nearest : first_reach(block, is_smooth);
#if METHOD == INVERSE
    vec2 uv = 0.5 * (block.low + block.high);
    v_guess = plane_met(uv, v_begin);
    bool is_drawn = v_begin < MISSES && is_smooth == (SMOOTH == 1);
#else
    bool is_drawn = v_begin < MISSES;
#endif
    gl_Position = is_drawn ? vec4(2.0 * middle / vec2(u_picture) - 1.0, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
    gl_PointSize = float(BLOCK);
}
