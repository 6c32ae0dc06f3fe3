// A triangle whose edges are curves in a logarithmic map becomes the box that holds it; the fragment stage decides exactly.
// s = X/w is extremal at corners (a projective map with w > 0) and t is monotonic in w, so the corners' box is the triangle's box.
layout(triangles) in;
layout(triangle_strip, max_vertices = 4) out;
uniform vec4 u_log_warp;   // as ShadowMap.log_warp
uniform float u_map_size;
in vec4 v_clip[];
#if IDS
flat in uint v_id[];
flat out uint g_id;
#endif
flat out vec2 g_origin, g_side1, g_side2;   // the triangle in (X, w), where its edges are straight and its depth is affine
flat out vec3 g_depth;                      // depth at the origin and its change along the sides

float s_of(float x, float w) { return u_log_warp.z == 0.0 ? x : x / w; }
float t_of(float w) { return u_log_warp.x * log2(w) + u_log_warp.y; }

void main() {
    g_origin = v_clip[0].xw;
    g_side1 = v_clip[1].xw - g_origin;
    g_side2 = v_clip[2].xw - g_origin;
    if (g_side1.x * g_side2.y == g_side1.y * g_side2.x) return;
    g_depth = vec3(v_clip[0].z, v_clip[1].z - v_clip[0].z, v_clip[2].z - v_clip[0].z);
    // what lies before the map's first row (w < w_first) is cut off there, so that w stays positive
    float w_first = exp2((-1.0 - u_log_warp.y) / u_log_warp.x) * 0.999;
    vec2 low = vec2(1e30), high = vec2(-1e30);
    for (int i = 0; i < 3; ++i) {
        vec2 a = v_clip[i].xw, b = v_clip[(i + 1) % 3].xw;
        if (a.y >= w_first) {
            vec2 st = vec2(s_of(a.x, a.y), t_of(a.y));
            low = min(low, st);
            high = max(high, st);
        }
        if ((a.y < w_first) != (b.y < w_first)) {
            float x = mix(a.x, b.x, (w_first - a.y) / (b.y - a.y));
            vec2 st = vec2(s_of(x, w_first), t_of(w_first));
            low = min(low, st);
            high = max(high, st);
        }
    }
    if (any(greaterThan(low, vec2(1.0))) || any(lessThan(high, vec2(-1.0)))) return;
    float spare = 0.05 / u_map_size;
    low = max(low - spare, vec2(-1.0));
    high = min(high + spare, vec2(1.0));
    vec2 corners[4] = vec2[4](low, vec2(high.x, low.y), vec2(low.x, high.y), high);
    for (int i = 0; i < 4; ++i) {
        gl_Position = vec4(corners[i], 0.0, 1.0);
        gl_PrimitiveID = gl_PrimitiveIDIn;
#if IDS
        g_id = v_id[0];
#endif
        EmitVertex();
    }
    EndPrimitive();
}
