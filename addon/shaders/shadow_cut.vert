// Caster pass of one shadow map: pieces of large triangles, cut and projected in float64 (pipeline/passes/large_casters.py).
#include "common_instance.glsl"
#include "common_caster_id.glsl"
in vec4 in_clip;

void main() {
    pass_id();
    gl_Position = in_clip;
}
