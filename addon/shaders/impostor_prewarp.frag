// A warped texel: its relief, and what it looked like.
flat in ivec2 v_texel;
in float v_relief;
uniform sampler2D u_normal;
uniform usampler2D u_ids;
layout(location = 0) out vec4 out_layers;
layout(location = 1) out vec2 out_normal;
layout(location = 2) out uvec2 out_ids;

void main() {
    out_layers = vec4(v_relief, 0.0, 0.0, v_relief);
    out_normal = texelFetch(u_normal, v_texel, 0).rg;
    out_ids = texelFetch(u_ids, v_texel, 0).rg;
}
