// The triangle-exact test (method §8): the map says which triangles are near the light's ray, the ray itself decides.
//
// Dark iff the ray from the receiver towards the light hits the surface of a triangle stored in the cells round it (REACH cells each way;
// its own triangle excluded; with OUTLINES also those whose edges cross these cells, which finds parts thinner than a cell), or everything
// stored there stands higher above the receiver's plane than far_m: then something whose own edge lies elsewhere, or that never won a cell,
// covers it. A surface is followed from the stored triangle over its edges towards the ray,
// so that slivers too thin to win a cell are found; it ends where it has a border or folds back. Where it cannot be followed, the nearest
// cell's depth decides. No bias: only float32's noise, within which another plane is the same plane (coplanar neighbours, coincident faces).
uniform sampler2DArray u_shadow_depth;
uniform usampler2DArray u_shadow_ids;
uniform usampler2DArray u_outline_ids;  // of the triangles whose edges cross each cell: OUTLINES
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

// Does the plane lie on the ray from `offset` (relative to the receiver), this side of the light, and not as the receiver's own plane? That is
// known less well beside the receiver's place: there as for what is seen (common_seen.glsl).
bool is_ahead(Receiver r, Triangle t, vec3 offset) {
    float height = t.height - dot(t.normal, offset), noise = offset == vec3(0.0) ? t.noise : SEEN_NOISE * t.noise;
    return abs(height) > noise && height * t.slope > 0.0
        && (u_light.w == 0.0 || abs(height) < abs(t.slope) * distance(u_light.xyz, r.position_ws));
}

// A walk over one surface towards a ray.
struct Walk {
    uvec2 at;      // slot + 1, triangle
    uint before;   // the triangle come from, NOWHERE at the start
    int steps;
};
const int GOES_ON = 0, HITS = 1, MISSES = 2, UNKNOWN = 3;

// One triangle: does it hold the ray from `offset`? Otherwise on over the edge that the ray is farthest beyond.
int walk_on(Receiver r, vec3 offset, inout Walk w) {
    uint slot = w.at.x - 1u;
    Triangle t = triangle_seen_from(r, instance_info(slot), slot, w.at.y);
    vec3 e = t.inside + offset * t.turn;
    float area = e.x + e.y + e.z;
    e = area < 0.0 ? -e : e;
    if (area == 0.0 || ++w.steps > MOST_STEPS) return UNKNOWN;
    if (all(greaterThanEqual(e, vec3(0.0)))) return w.at != r.ids && is_ahead(r, t, offset) ? HITS : MISSES;
    vec3 beyond = e / max(vec3(length(t.turn[0]), length(t.turn[1]), length(t.turn[2])), vec3(1e-30));
    uint next = NOTHING;
    float farthest = 0.0;
    for (int k = 0; k < 3; ++k) {
        uint across = texelFetch(u_links, int(w.at.y) * 3 + k).r;
        if (across == w.before && e[k] < 0.0) return MISSES;  // folded back: the ray is beyond the edge on both sides
        if (beyond[k] < farthest) {
            farthest = beyond[k];
            next = across;
        }
    }
    w.before = w.at.y;
    w.at.y = next;
    return next == NOTHING ? MISSES : next == SEVERAL ? UNKNOWN : GOES_ON;
}

uvec2 triangle_near(ivec3 at, bool of_outline) {
#if OUTLINES
    if (of_outline) return texelFetch(u_outline_ids, at, 0).rg;
#endif
    return texelFetch(u_shadow_ids, at, 0).rg;
}

// Is the place `step` texels from the receiver's, on its plane, in shadow?
bool is_dark(Receiver r, vec2 step) {
    const int window = 2 * REACH + 1, cells = window * window, places = OUTLINES != 0 ? 2 * cells : cells;
    vec3 offset = offset_on_plane(r, step);
    ivec2 nearest = ivec2(floor(r.texel + step));
    float far_m = u_epsilon_far >= 0.0 ? u_epsilon_far * r.facing : FAR_TEXELS * footprint_m(r);
    float lowest = 1e30, height;
    bool is_walking = false, is_doubtful = false;
    Walk walk;
    uvec2 first = uvec2(0u), last = uvec2(0u);
    int next = 0;
    for (;;) {
        while (!is_walking && next < places) {
            int place = (next + cells / 2) % cells;  // the nearest cell first, outlines after the map
            ivec3 at = ivec3(clamped_cell(nearest + ivec2(place % window, place / window) - REACH), r.map);
            uvec2 ids = triangle_near(at, next >= cells);
            if (next < cells) {
                height = height_above(r, vec3(cell_ndc(at.xy), texelFetch(u_shadow_depth, at, 0).r * 2.0 - 1.0));
                lowest = min(lowest, height);
            }
            is_walking = ids.x != 0u && ids != r.ids && ids != first && ids != last;
            if (next == 0) {
                first = ids;
                is_doubtful = is_walking && height > automatic_bias_m(r);
            }
            last = ids;
            walk = Walk(ids, NOWHERE, 0);
            ++next;
        }
        if (!is_walking) break;
        int found = walk_on(r, offset, walk);
        if (found == HITS) return true;
        is_walking = found == GOES_ON;
        if (next == 1) is_doubtful = is_doubtful && found != MISSES;
    }
    return lowest > far_m || is_doubtful;
}

#define Limits bool   // nothing is worked out before
Limits limits_of(inout Receiver r) { return true; }
float light_through(Receiver r, Limits limits, vec2 step) { return is_dark(r, step) ? 0.0 : 1.0; }
bool stays_on_surface() { return true; }
#include "common_seen_taps.glsl"
