// What the view ray meets in a relief texture, written like geometry: view depth, ids and depth.
#include "common_impostor.glsl"
#define INVERSE 0
#define SPRITE 1
#define PREWARPED 2
uniform usampler2D u_both_ids;      // of the front, of the back
#if CASTER
uniform mat4 u_clip_from_texel;
#else
#include "common_depth.glsl"
uniform vec4 u_behind_near_from_texel;
uniform float u_near;
uniform vec2 u_section;             // metres behind the near plane between which the camera shows something
#endif
uniform float u_source_w;           // 1 + u_source_w a is the w of a texel's point in plane coordinates
uniform float u_deepest;            // behind this no surface lies
uniform float u_continuous;         // steps of a up to this are one surface
uniform float u_fade;               // share of the pixels to draw, dithered
uniform int u_fade_rest;            // 1: the other share
uniform float u_behind;             // depth of a by which to lie farther back than what is seen
uniform vec2 u_corner;              // plane coordinates of a pre-warped texture's first texel
#if !CASTER
layout(location = 0) out float out_view_depth;
layout(location = 1) out vec2 out_normal;
layout(location = 2) out uvec2 out_ids;
#endif

struct Hit { bool found; ivec2 cell; vec3 place; bool on_back; };
const Hit MISS = Hit(false, ivec2(0), vec3(0.0), false);

#if METHOD == SPRITE
// The texture as it lies on the plane.
Hit trace(vec2 uv) {
    ivec2 cell = ivec2(floor(uv));
    vec4 layers = layers_at(cell);
    if (is_empty(layers)) return MISS;
    if (is_edge(layers)) {
        uint code = shown_at(layers, cell, uv);
        if (code == 15u) return MISS;
        cell += neighbour(code);
        layers = layers_at(cell);
    }
    return Hit(true, cell, vec3(uv, max(front_at(layers, cell, uv), 0.0)), false);
}
#elif METHOD == PREWARPED
// A texture whose texels already lie where this eye sees them; the place in the captured texture follows from the relief found.
Hit trace(vec2 uv) {
    ivec2 cell = ivec2(floor(uv - u_corner));
    vec4 layers = layers_at(cell);
    return Hit(!is_empty(layers), cell, vec3(uv + ray_slope(uv) * layers.x, layers.x), false);
}
#else
#if SMOOTH
#include "impostor_smooth.glsl"
#else
#include "impostor_walk.glsl"
#endif
#endif

#if !CASTER
float behind_near_at(vec4 place) { return dot(u_behind_near_from_texel, place) / (1.0 + u_source_w * place.z); }
#endif

float dither() { return fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))); }

void main() {
    if (u_fade < 1.0 && (dither() < u_fade) == (u_fade_rest == 1)) discard;
    vec3 place_seen = u_plane_from_pixel * vec3(gl_FragCoord.xy, 1.0);
    Hit hit = trace(place_seen.xy / place_seen.z);
    if (!hit.found || place_seen.z <= 0.0) discard;
    ivec2 texel = texel_at(hit.cell);
    vec4 place = vec4(hit.place, 1.0);
    vec4 farther = vec4(place.xy, place.z + u_behind, 1.0);
#if CASTER
    vec4 clip = u_clip_from_texel * farther;
    gl_FragDepth = clamp(0.5 + 0.5 * clip.z / clip.w, 0.0, 1.0);
#else
    float behind_near = behind_near_at(farther);
    if (behind_near < u_section.x || behind_near > u_section.y) discard;
    gl_FragDepth = depth_behind(behind_near);
    out_view_depth = u_near + behind_near_at(place);
    uvec4 ids = texelFetch(u_both_ids, texel, 0);
    out_normal = vec2(0.0);   // shading finds it with the triangle that the ray meets
    out_ids = (hit.on_back ? ids.ba : ids.rg) | uvec2(0u, FROM_TEXTURE);
#endif
}
