// Depth of a piece of a triangle in a logarithmic map, and what IDS asks for beside it.
#include "common_shadow_ids.glsl"
flat in float g_level;
noperspective in vec2 g_rise;

void main() {
    gl_FragDepth = clamp((g_level + g_rise.x / g_rise.y) * 0.5 + 0.5, 0.0, 1.0);
    write_ids();
}
