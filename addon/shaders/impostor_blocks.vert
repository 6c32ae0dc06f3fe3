// The part of an impostor's plane under which its object can be seen, in square blocks, without those under which no ray comes near a surface.
// For the others: the depth before which none does. The fragment's depth is the fragment's business, so nothing is clipped by it.
#include "common_impostor.glsl"
#define INVERSE 0
#define PREWARPED 2
uniform vec4 u_extent;              // smallest u, v, largest u, v
uniform mat4 u_clip_from_texel;     // from (u, v, |relief|, 1)
uniform int u_columns;              // blocks in a row
uniform float u_nearest, u_deepest; // between these the whole surface lies
uniform sampler2D u_tiles;          // of every square of TILE × TILE texels, v downwards, with an empty rim: nearest and farthest depth met
out vec2 v_uv;
flat out float v_begin;

const ivec2 CORNERS[6] = ivec2[6](ivec2(0, 0), ivec2(1, 0), ivec2(0, 1), ivec2(0, 1), ivec2(1, 0), ivec2(1, 1));
const float MISSES = 1e9;

// Where the view rays through a corner of the block are at depth a; a sprite's stay where they are.
vec2 at_depth(vec2 uv, float a) { return METHOD == INVERSE ? uv + ray_slope(uv) * a : uv; }

// The depth before which no ray of the block is behind any surface, found in steps over which they move by a tile: the box round all of them
// covers a tile whose nearest depth they reach. None where they always are before or behind all that the tiles hold.
float first_reach(vec2 low, vec2 high) {
    vec2 slope = METHOD == INVERSE ? max(abs(ray_slope(low)), abs(ray_slope(high))) : vec2(0.0);
    float pace = float(TILE) / max(max(slope.x, slope.y), 1e-9), begin = MISSES;
    for (float a = u_nearest; a <= u_deepest; a += pace) {
        float until = min(a + pace, u_deepest);
        vec2 first = min(at_depth(low, a), at_depth(low, until)) - 0.01, last = max(at_depth(high, a), at_depth(high, until)) + 0.01;
        ivec2 from = max(ivec2(floor(first / float(TILE))), ivec2(0)), to = min(ivec2(floor(last / float(TILE))), (u_size - 1) / TILE);
        for (int j = from.y; j <= to.y; ++j)
            for (int i = from.x; i <= to.x; ++i) {
                vec2 reach = texelFetch(u_tiles, ivec2(i, j) + 1, 0).rg;
                if (reach.x > until) continue;
                begin = min(begin, a);
                if (reach.y >= a) return begin;
            }
    }
    return MISSES;
}

void main() {
    int block = gl_VertexID / 6;
    vec2 low = u_extent.xy + float(BLOCK) * vec2(block % u_columns, block / u_columns), high = min(low + float(BLOCK), u_extent.zw);
    v_begin = METHOD == PREWARPED ? 0.0 : first_reach(low, high);
    v_uv = mix(low, high, vec2(CORNERS[gl_VertexID % 6]));
    vec4 clip = u_clip_from_texel * vec4(v_uv, 0.0, 1.0);
    gl_Position = v_begin < MISSES ? vec4(clip.xy, 0.0, clip.w) : vec4(2.0, 2.0, 2.0, 1.0);
}
