// Lines over the picture, premultiplied.
uniform sampler2D u_coverage;
uniform vec4 u_edge_color;   // a: strength
out vec4 out_color;

void main() {
    float a = texelFetch(u_coverage, ivec2(gl_FragCoord.xy), 0).r * u_edge_color.a;
    out_color = vec4(u_edge_color.rgb * a, a);
}
