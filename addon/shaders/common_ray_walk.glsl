// From a triangle over its edges to the one of the same surface that a view ray passes through.
// Edge functions of the ray through x along `along`, x being near: all of one sign where it passes through the triangle of these corners.
vec3 edges_seen(mat3 corners, vec3 along) {
    vec3 edges = vec3(
        dot(along, cross(corners[0], corners[1])), dot(along, cross(corners[1], corners[2])), dot(along, cross(corners[2], corners[0])));
    return edges.x + edges.y + edges.z < 0.0 ? -edges : edges;
}

mat3 corners_from(uvec4 info, uint slot, uint triangle, vec3 x) {
    uint first = triangle * 3u;
    return mat3(corner_ws(info, slot, first) - x, corner_ws(info, slot, first + 1u) - x, corner_ws(info, slot, first + 2u) - x);
}

// How far the ray is beyond each edge, from the edge functions.
vec3 beyond_edges(vec3 edges, mat3 corners, vec3 along) {
    vec3 ab = cross(along, corners[1] - corners[0]), bc = cross(along, corners[2] - corners[1]), ca = cross(along, corners[0] - corners[2]);
    return edges / max(vec3(length(ab), length(bc), length(ca)), vec3(1e-30));
}

// Over the edge that the ray is farthest beyond, again and again. False where the surface ends or folds back before the ray: then `triangle`
// is the last one that is seen from the ray's side. `last`: the edge functions there.
bool walk_to_ray(uvec4 info, uint slot, vec3 x, vec3 along, inout uint triangle, out vec3 last) {
    uint before = NOWHERE, at = triangle;
    bool is_met = false;
    last = vec3(1.0);
    for (int steps = 0; steps < MOST_FOLLOWED; ++steps) {
        mat3 corners = corners_from(info, slot, at, x);
        vec3 edges = edges_seen(corners, along);
        is_met = all(greaterThanEqual(edges, vec3(0.0)));
        if (is_met) {
            triangle = at;
            last = edges;
            break;
        }
        vec3 beyond = beyond_edges(edges, corners, along);
        uint next = NOTHING;
        float farthest = 0.0;
        bool is_folded = false;
        for (int k = 0; k < 3; ++k) {
            if (edges[k] >= 0.0) continue;
            uint across = texelFetch(u_links, int(at) * 3 + k).r;
            is_folded = is_folded || across == before;
            if (beyond[k] < farthest) {
                farthest = beyond[k];
                next = across;
            }
        }
        if (is_folded) break;
        triangle = before = at;
        last = edges;
        if (next == NOTHING || next == SEVERAL) break;
        at = next;
    }
    return is_met;
}

// Metres of view depth from x to the plane of a triangle along the ray.
float depth_to_plane(uvec4 info, uint slot, uint triangle, vec3 x, vec3 along) {
    vec3 a = corner_ws(info, slot, triangle * 3u), b = corner_ws(info, slot, triangle * 3u + 1u), c = corner_ws(info, slot, triangle * 3u + 2u);
    vec3 n = cross(b - a, c - a);
    float slope = dot(n, along);
    return slope == 0.0 ? 0.0 : dot(n, a - x) / slope;
}
