// What of the ambient light from above and from below the horizon arrives at a place: of what would without anything in the way.
vec2 sky_reach = vec2(1.0);   // of the surface that is shaded
#if SKY
uniform sampler2D u_sky_sums, u_places, u_planes;   // of reach_sums.frag and receiver_places.frag, at the pixels' centres of one picture
uniform mat4 u_sky_pixel_from_world;                // homogeneous pixels of that picture, of places relative to u_origin
uniform vec3 u_sky_offset;                          // from u_origin to what its places count from
const float LEAST_SHARE = 0.02;   // of sky or ground that a surface is turned to

// `sums` with cosines over a surface with that normal.
vec2 reach_of(vec4 sums, vec3 normal) {
    vec2 open = vec2(0.5 + 0.5 * normal.z, 0.5 - 0.5 * normal.z);
    return sums.yz / (max(sums.w, 1e-9) * max(open, vec2(LEAST_SHARE)));
}

// The mean of the four pixels round a place: of those that show its plane, where one does.
vec2 reach_at(vec3 x_ws, vec3 normal, float view_depth) {
    vec4 h = u_sky_pixel_from_world * vec4(x_ws, 1.0);
    vec2 at = h.xy / h.w - 0.5, part = fract(at), mean = vec2(0.0);
    ivec2 last = textureSize(u_sky_sums, 0) - 1;
    float whole = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 side = ivec2(i & 1, i >> 1), pixel = clamp(ivec2(floor(at)) + side, ivec2(0), last);
        vec4 plane = texelFetch(u_planes, pixel, 0);
        if (plane.w == 0.0) continue;
        vec3 other = texelFetch(u_places, pixel, 0).xyz + u_sky_offset - x_ws;
        vec2 near = mix(1.0 - part, part, vec2(side));
        float beside = abs(dot(normal, other)) / (length(other) + 1e-4 * abs(view_depth)), turned = max(dot(normal, plane.xyz), 0.0);
        float weight = (near.x * near.y + 1e-3) * (pow(turned, 8.0) / (1.0 + 1e3 * beside * beside) + 1e-6);
        mean += weight * reach_of(texelFetch(u_sky_sums, pixel, 0), plane.xyz);
        whole += weight;
    }
    return whole > 0.0 ? mean / whole : vec2(1.0);
}
#endif
