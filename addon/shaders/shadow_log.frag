// Depth of a piece of a triangle in a logarithmic map, and what IDS asks for beside it.
#include "common_shadow_ids.glsl"
flat in float g_level;
noperspective in vec2 g_rise;

void main() {
    float depth = g_level + g_rise.x / g_rise.y;
#if IDS == 3
    write_pane(depth);
#else
    gl_FragDepth = clamp(depth * 0.5 + 0.5, 0.0, 1.0);
    write_ids();
#endif
}
