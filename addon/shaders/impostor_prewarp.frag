// A warped texel: its relief, and what it looked like.
flat in ivec2 v_texel;
in float v_relief;
uniform float u_deepest;
uniform usampler2D u_both_ids;
layout(location = 0) out vec4 out_layers;
layout(location = 1) out uvec4 out_both_ids;

void main() {
    gl_FragDepth = clamp(v_relief / u_deepest, 0.0, 1.0);   // of a float's digits near 0 the rasteriser would leave none
    out_layers = vec4(v_relief, 0.0, 0.0, v_relief);
    out_both_ids = texelFetch(u_both_ids, v_texel, 0);
}
