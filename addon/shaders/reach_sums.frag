// What reaches a receiver of many lights at infinity, a map each: added to what other maps have brought before (blending).
//
// SUMS 0, TIMES: the weights of the lights that reach the front and the back, then of those that either is turned to. SUMS 1, COSINES, of the
// front, with the cosine: all lights; those above the horizon times their brightness; those below it; all, whatever stands in the way.
#include "common_instance.glsl"
#include "common_plan.glsl"
#include "common_receiver.glsl"
#include "common_triangles.glsl"
#include "common_links.glsl"
#include "common_seen.glsl"
#include "common_filter.glsl"
#define TIMES 0
#define COSINES 1
uniform sampler2D u_places, u_planes;      // of receiver_places.frag
uniform vec4 u_lights[MAX_MAPS];           // direction towards it; weight
uniform vec4 u_brightness[(MAX_MAPS + 3) / 4];
uniform float u_least_facing;              // cosine up to which a surface is not turned to a light
layout(location = 0) out vec4 out_sums;

// Texels by which the rasteriser may misplace the receiver's own triangle; a place that is given without one has none.
float own_blur(uvec2 ids, vec3 grad_s, vec3 grad_t) {
    if (ids.r == 0u) return 0.0;
    uint slot = ids.r - 1u;
    uvec4 info = instance_info(slot);
    vec3 a = corner_ws(info, slot, ids.g * 3u);
    return interpolation_blur(grad_s, grad_t, corner_ws(info, slot, ids.g * 3u + 1u) - a, corner_ws(info, slot, ids.g * 3u + 2u) - a);
}

float light_from(int map, vec4 place, vec3 normal, vec3 light_ws, uvec2 ids) {
    vec4 q = project(map, place.xyz);
    if (any(greaterThan(abs(q.xy), vec2(1.0)))) return 1.0;
    vec3 grad_s, grad_t;
    texel_gradients(map, q, grad_s, grad_t);
    uint id = ids.r == 0u ? 0u : id_of(instance_info(ids.r - 1u));
    Receiver r = receiver_at(map, q, grad_s, grad_t, place.xyz, normal, light_ws, place.w, own_blur(ids, grad_s, grad_t), ids, id);
    return light_at(r, mat2(1.0));
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 place = texelFetch(u_places, at, 0), plane = texelFetch(u_planes, at, 0);
    if (plane.w == 0.0) discard;
    uvec2 ids = texelFetch(u_ids, min(at, textureSize(u_ids, 0) - 1), 0).rg;
    if ((ids.g & FROM_TEXTURE) != 0u) ids = uvec2(0u);
    out_sums = vec4(0.0);
    for (int map = 0; map < u_map_count; ++map) {
        vec4 light = u_lights[map];
        float facing = dot(plane.xyz, light.xyz);
#if SUMS == TIMES
        if (abs(facing) <= u_least_facing) continue;
        float reached = light.w * light_from(map, place, sign(facing) * plane.xyz, light.xyz, ids);
        out_sums += facing > 0.0 ? vec4(reached, 0.0, light.w, 0.0) : vec4(0.0, reached, 0.0, light.w);
#else
        if (facing <= u_least_facing) continue;
        float whole = light.w * facing, reached = whole * light_from(map, place, plane.xyz, light.xyz, ids);
        bool is_sky = light.z > 0.0;
        out_sums += vec4(reached, is_sky ? reached * u_brightness[map / 4][map % 4] : 0.0, is_sky ? 0.0 : reached, whole);
#endif
    }
}
