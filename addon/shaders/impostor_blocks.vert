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
uniform sampler2D u_windows;        // of every WINDOW × WINDOW texels: nearest, behind all, all met if smooth (else EMPTY), steepest slope
flat out float v_begin;             // depth before which no ray of the block meets anything
flat out vec3 v_guess;              // of a smooth block: the depth of a plane near the surface at u = v = 0, and its gradient

const int WINDOWS = WINDOW / STRIDE;
const float MISSES = 1e9, MOST_STEPS = 64.0, EDGE_ON = 0.9;

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

// What the windows that cover a box of texels say together.
vec4 reach_of(vec2 first, vec2 last) {
    vec4 reach = vec4(EMPTY, -1.0, -1.0, 0.0);
    ivec2 most = (u_size + STRIDE - 1) / STRIDE + WINDOWS;
    ivec2 from = max(ivec2(floor(first / float(STRIDE))) + WINDOWS, 0), to = min(ivec2(floor(last / float(STRIDE))) + WINDOWS, most);
    for (int j = min(from.y, most.y); j <= max(to.y, 0); j += WINDOWS)
        for (int i = min(from.x, most.x); i <= max(to.x, 0); i += WINDOWS) {
            vec4 one = texelFetch(u_windows, ivec2(i, j), 0);
            reach = vec4(min(reach.x, one.x), max(reach.yzw, one.yzw));
        }
    return reach;
}

// From where on the block's rays may meet something (MISSES: never), and whether all of it is smooth: in steps over which they move by little,
// each judged by the box round all of them.
float first_reach(Block block, out bool is_smooth) {
    vec2 slope = METHOD == INVERSE ? max(abs(ray_slope(block.low)), abs(ray_slope(block.high))) : vec2(0.0), size = block.high - block.low;
    float fastest = max(slope.x, slope.y);
    float room = max(float(WINDOW - STRIDE) - max(size.x, size.y) - 0.1, 2.0);
    float pace = max(room / max(fastest, 1e-9), (u_deepest - u_nearest) / MOST_STEPS), begin = MISSES;
    bool meets = false;
    is_smooth = true;
    for (float a = u_nearest; a <= u_deepest; a += pace) {
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
