// One triangle over the whole target, in the middle of the depths or where u_ndc_depth says.
uniform float u_ndc_depth;
void main() {
    vec2 p = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(p, u_ndc_depth, 1.0);
}
