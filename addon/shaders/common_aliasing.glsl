// Aliasing error per pixel (method §1; T4 (11), (12)): pixels covered by one shadow-map texel. Mirrors maths/error/measure.py.

// How the surface point moves with the pixel: `along` is the view ray per metre of view depth, `move` the point's motion at constant depth.
vec3 on_plane(vec3 move, vec3 along, vec3 normal) {
    return move - along * (dot(normal, move) / dot(normal, along));
}

// Rows of J = d(texel s, t) / d(pixel x, y) on the plane with that normal.
mat2 texel_jacobian(vec3 grad_s, vec3 grad_t, vec3 move_x, vec3 move_y, vec3 along, vec3 normal) {
    vec3 dx = on_plane(move_x, along, normal), dy = on_plane(move_y, along, normal);
    return mat2(dot(grad_s, dx), dot(grad_t, dx), dot(grad_s, dy), dot(grad_t, dy));
}

// Total m = 1 / |det J|.
float total_error(mat2 j) { return 1.0 / max(abs(determinant(j)), 1e-30); }

// (m_x, m_z): reciprocal singular values of J, each given to the texel axis its singular vector is closer to.
vec2 directional_errors(mat2 j) {
    float ss = j[0].x * j[0].x + j[1].x * j[1].x, tt = j[0].y * j[0].y + j[1].y * j[1].y, st = j[0].x * j[0].y + j[1].x * j[1].y;
    float larger = 0.5 * (ss + tt) + sqrt(0.25 * (ss - tt) * (ss - tt) + st * st);
    float det = determinant(j);
    float smaller = det * det / max(larger, 1e-30);
    vec2 m = inversesqrt(max(vec2(larger, smaller), vec2(1e-30)));
    return ss >= tt ? m : m.yx;
}
