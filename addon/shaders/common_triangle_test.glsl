// The triangle-exact test (method §8): the map says which triangles are near the light's ray, the ray itself decides.
//
// Dark iff the ray from the receiver towards the light hits a triangle stored in the cells round it (REACH cells each way; its own triangle
// excluded), or everything stored there stands higher above the receiver's plane than far_m: then something whose own edge lies elsewhere,
// or that never won a cell, covers it. No bias: only float32's noise, within which another plane is the same plane (coplanar neighbours,
// coincident faces). Taps of a filter share the candidates: each triangle is fetched once and tested against every ray that is still lit.
uniform sampler2DArray u_shadow_depth;
uniform usampler2DArray u_shadow_ids;
uniform usamplerBuffer u_spans;  // of a slot: its triangles in the pool, first and one past the last
uniform float u_epsilon_far;   // metres along the ray; negative: FAR_TEXELS texels

// A triangle as the parallel rays of one receiver see it. A ray displaced by d hits it iff the edge functions inside + turn . d have one sign.
struct Triangle {
    vec3 inside;         // edge functions of the receiver's own ray
    mat3 turn;           // their change with the displacement, a column an edge
    vec3 normal;         // unit
    float height;        // of its plane over the receiver, along the normal
    float slope;         // normal . light
    float noise;
};

// The block of BLOCK triangles in the index pool that an id lies in: slot + 1, first triangle. Blocks begin with the part.
uvec2 block_of(uvec2 ids) {
    uint first = texelFetch(u_spans, int(ids.x) - 1).x;
    return uvec2(ids.x, ids.y - (ids.y - first) % uint(BLOCK));
}

// Edge functions change sign exactly with the order of the corners, term by term, so that no ray passes between neighbours.
Triangle triangle_seen_from(Receiver r, uvec4 info, uint slot, uint triangle) {
    vec3 a = corner_ws(info, slot, triangle * 3u) - r.position_ws;
    vec3 b = corner_ws(info, slot, triangle * 3u + 1u) - r.position_ws;
    vec3 c = corner_ws(info, slot, triangle * 3u + 2u) - r.position_ws;
    vec3 e1 = b - a, e2 = c - a, n = cross(e1, e2);
    float area = max(length(n), 1e-30);
    Triangle t;
    t.inside = vec3(dot(r.light_ws, cross(a, b)), dot(r.light_ws, cross(b, c)), dot(r.light_ws, cross(c, a)));
    t.turn = mat3(cross(r.light_ws, b - a), cross(r.light_ws, c - b), cross(r.light_ws, a - c));
    t.normal = n / area;
    t.height = dot(t.normal, a);
    t.slope = dot(t.normal, r.light_ws);
    // a sliver's normal is as uncertain as its height is small
    t.noise = r.noise_m + 4.8e-7 * length(e1) * length(e2) * length(a) / area;
    return t;
}

// Does the ray from `offset` (relative to the receiver) hit it, this side of the light, and not as the receiver's own plane?
bool hits(Receiver r, Triangle t, vec3 offset) {
    float height = t.height - dot(t.normal, offset);
    vec3 e = t.inside + offset * t.turn;
    bool one_sign = all(greaterThanEqual(e, vec3(0.0))) || all(lessThanEqual(e, vec3(0.0)));
    bool ahead = abs(height) > t.noise && height * t.slope > 0.0;
    return one_sign && ahead && (u_light.w == 0.0 || abs(height) < abs(t.slope) * distance(u_light.xyz, r.position_ws));
}
