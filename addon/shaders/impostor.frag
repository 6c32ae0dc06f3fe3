// What the view ray meets in a relief texture, written like geometry: view depth, normal, ids and depth.
#include "common_impostor.glsl"
#define INVERSE 0
#define SPRITE 1
#define PREWARPED 2
in vec2 v_uv;
uniform sampler2D u_normal;
uniform usampler2D u_ids;
uniform sampler2D u_back_normal;
uniform sampler2D u_tiles;          // nearest depth of every square of TILE × TILE texels, v downwards
uniform usampler2D u_back_ids;
uniform mat4 u_clip_from_texel;
uniform vec4 u_view_depth_from_texel;
uniform float u_source_w;           // 1 + u_source_w a is the w of a texel's point in plane coordinates
uniform float u_nearest, u_deepest; // between these the whole surface lies
uniform float u_continuous;         // steps of a up to this are one surface
uniform float u_fade;               // share of the pixels to draw, dithered
uniform int u_fade_rest;            // 1: the other share
uniform vec2 u_corner;              // plane coordinates of a pre-warped texture's first texel
layout(location = 0) out float out_view_depth;
layout(location = 1) out vec2 out_normal;
layout(location = 2) out uvec2 out_ids;

struct Hit { bool found; ivec2 cell; vec3 place; bool on_back; };

#if METHOD == SPRITE
// The texture as it lies on the plane.
Hit trace(vec2 uv) {
    ivec2 cell = ivec2(floor(uv));
    vec4 layers = layers_at(cell);
    return Hit(layers.x < EMPTY, cell, vec3(uv, front_at(layers, cell, uv)), false);
}
#elif METHOD == PREWARPED
// A texture whose texels already lie where this eye sees them; the place in the captured texture follows from the relief found.
Hit trace(vec2 uv) {
    ivec2 cell = ivec2(floor(uv - u_corner));
    vec4 layers = layers_at(cell);
    return Hit(layers.x < EMPTY, cell, vec3(uv + ray_slope(uv) * layers.x, layers.x), false);
}
#else
// Walks the texels under the ray one by one, and leaps over squares of them that the ray passes wholly before their surface. In each texel,
// the solid is what lies between front and back; the ray enters it through the front, through the back (a wall that the back layer shows
// from within), or through the side of a column.
Hit trace(vec2 uv) {
    Hit miss = Hit(false, ivec2(0), vec3(0.0), false);
    vec2 slope = ray_slope(uv);
    vec2 speed = max(abs(slope), vec2(1e-9));
    vec2 towards = vec2(slope.x < 0.0 ? -1.0 : 1.0, slope.y < 0.0 ? -1.0 : 1.0);
    vec2 to_low = -uv * towards / speed, to_high = (vec2(u_size) - uv) * towards / speed;
    vec2 first = min(to_low, to_high), last = max(to_low, to_high);
    float a = max(u_nearest, max(first.x, first.y)), end = min(u_deepest, min(last.x, last.y));
    if (a > end) return miss;
    ivec2 cell = clamp(ivec2(floor(uv + slope * (a + 1e-6 * u_deepest))), ivec2(0), u_size - 1);
    ivec2 stride = ivec2(towards);
    bool was_behind = false;
    for (int i = 0; i < u_size.x + u_size.y; ++i) {
        ivec2 low, came_from = ivec2(-1);
        for (int j = 0; j < u_size.x + u_size.y; ++j) {
            low = cell / TILE * TILE;
            vec2 far_side = (vec2(low) + max(towards, 0.0) * float(TILE) - uv) * towards / speed;
            float beyond = min(far_side.x, far_side.y);
            if (min(beyond, end) >= texelFetch(u_tiles, low / TILE, 0).r) break;
            if (beyond >= end) return miss;
            a = beyond;
            came_from = clamp(ivec2(floor(uv + slope * a)), low, low + TILE - 1);
            bool across_u = far_side.x < far_side.y;
            cell = ivec2(across_u ? (stride.x > 0 ? low.x + TILE : low.x - 1) : came_from.x,
                         across_u ? came_from.y : (stride.y > 0 ? low.y + TILE : low.y - 1));
            came_from = cell - (across_u ? ivec2(stride.x, 0) : ivec2(0, stride.y));
        }
        if (came_from.x >= 0) was_behind = layers_at(came_from).x >= EMPTY;
        vec2 border = (vec2(cell) + max(towards, 0.0) - uv) * towards / speed;   // a at which the ray leaves the cell, per axis
        for (int j = 0; j < 2 * TILE; ++j) {
            float leave = min(end, min(border.x, border.y));
            vec4 layers = texelFetch(u_layers, texel_at(cell), 0);
            vec2 at = uv + slope * a, to = uv + slope * leave;
            float above = front_at(layers, cell, at) - a, below = leave - front_at(layers, cell, to);
            if (above >= 0.0 && below >= 0.0) {
                float t = above + below > 0.0 ? above / (above + below) : 0.0;
                return Hit(true, cell, mix(vec3(at, a), vec3(to, leave), t), false);
            }
            bool joins = -above <= u_continuous + 0.5 * (abs(layers.y) + abs(layers.z));
            if (above < 0.0 && (joins || a <= layers.w)) return Hit(true, cell, vec3(at, a), was_behind && !joins);
            was_behind = above < 0.0 || layers.x >= EMPTY;
            if (leave >= end) return miss;
            a = leave;
            if (border.x < border.y) { cell.x += stride.x; border.x += 1.0 / speed.x; }
            else { cell.y += stride.y; border.y += 1.0 / speed.y; }
            if (any(notEqual(cell / TILE * TILE, low)) || any(lessThan(cell, ivec2(0))) || any(greaterThanEqual(cell, u_size))) break;
        }
        if (any(lessThan(cell, ivec2(0))) || any(greaterThanEqual(cell, u_size))) return miss;
    }
    return miss;
}
#endif

float dither() { return fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))); }

void main() {
    if (u_fade < 1.0 && (dither() < u_fade) == (u_fade_rest == 1)) discard;
    Hit hit = trace(v_uv);
    if (!hit.found) discard;
    ivec2 texel = texel_at(hit.cell);
    vec4 place = vec4(hit.place, 1.0);
    vec4 clip = u_clip_from_texel * place;
    float depth = 0.5 + 0.5 * clip.z / clip.w;
    if (depth < 0.0 || depth > 1.0) discard;
    gl_FragDepth = depth;
    out_view_depth = dot(u_view_depth_from_texel, place) / (1.0 + u_source_w * place.z);
    out_normal = hit.on_back ? texelFetch(u_back_normal, texel, 0).rg : texelFetch(u_normal, texel, 0).rg;
    out_ids = hit.on_back ? texelFetch(u_back_ids, texel, 0).rg : texelFetch(u_ids, texel, 0).rg;
}
