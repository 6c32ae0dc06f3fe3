// One pass over a layer of the shadow map: the n depths of every cell (SMMVP §4.5), four to a target, with their ids in the ID modes.
#include "common_neighbours.glsl"
uniform sampler2DArray u_shadow_depth;
uniform usampler2DArray u_shadow_ids;
uniform int u_layer;
layout(location = 0) out vec4 out_depths_0;
#if DEPTHS > 4
layout(location = 1) out vec4 out_depths_1;
#endif
#if WITH_IDS && DEPTHS > 4
layout(location = 2) out uvec4 out_ids_0;
layout(location = 3) out uvec4 out_ids_1;
#elif WITH_IDS
layout(location = 1) out uvec4 out_ids_0;
#endif

ivec3 cell_at(ivec2 place) {
    return ivec3(clamp(ivec2(gl_FragCoord.xy) + place, ivec2(0), textureSize(u_shadow_depth, 0).xy - 1), u_layer);
}
float depth_at(ivec2 place) { return texelFetch(u_shadow_depth, cell_at(place), 0).r; }
#if WITH_IDS
uint id_at(ivec2 place) { return texelFetch(u_shadow_ids, cell_at(place), 0).r; }
#endif

void main() {
    vec4 depths[2] = vec4[2](vec4(0.0), vec4(0.0));
    depths[0].x = depth_at(ivec2(0));
#if DEPTHS <= 3
    int largest = 4, smallest = 4;
    float high = depths[0].x, low = depths[0].x;
    for (int i = 0; i < 9; ++i) {
        float depth = depth_at(of_nine(i));
        if (depth > high) { high = depth; largest = i; }
        if (depth < low) { low = depth; smallest = i; }
    }
    depths[0].y = high;
    if (DEPTHS == 3) depths[0].z = low;
    depths[0][DEPTHS] = float(9 * largest + smallest);
#else
    for (int i = 1; i < DEPTHS; ++i) depths[i / 4][i % 4] = depth_at(neighbours[i - 1]);
#endif
    out_depths_0 = depths[0];
#if DEPTHS > 4
    out_depths_1 = depths[1];
#endif
#if WITH_IDS
    uvec4 ids[2] = uvec4[2](uvec4(0u), uvec4(0u));
    for (int i = 0; i < DEPTHS; ++i) ids[i / 4][i % 4] = id_at(place_of(i, depths[0]));
    out_ids_0 = ids[0];
#if DEPTHS > 4
    out_ids_1 = ids[1];
#endif
#endif
}
