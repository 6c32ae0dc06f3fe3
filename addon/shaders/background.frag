// What the pixels without a surface show.
uniform vec4 u_background;
layout(location = 0) out vec4 out_combined;
#if DATA
layout(location = 1) out vec4 out_errors;
layout(location = 2) out vec4 out_normal;
layout(location = 3) out ivec4 out_ids;
#endif

void main() {
    out_combined = u_background;
#if DATA
    out_errors = vec4(-1.0, -1.0, -1.0, 1.0);
    out_normal = vec4(0.0);
    out_ids = ivec4(-1);
#endif
}
