// The inverse warp where all rays meet one smooth surface: the texel under the ray's meeting with a plane near it, then the texel under its
// meeting with that texel's own plane, until the two are the same.
flat in vec3 v_guess;

ivec2 cell_under(vec2 uv) { return clamp(ivec2(floor(uv)), ivec2(0), u_size - 1); }

Hit trace(vec2 uv) {
    vec2 slope = ray_slope(uv);
    float a = depth_met(v_guess.x + dot(v_guess.yz, uv), v_guess.yz, slope);
    ivec2 cell = cell_under(uv + slope * a);
    for (int i = 0; i < 4; ++i) {
        vec4 layers = texelFetch(u_layers, texel_at(cell), 0);
        a = depth_met(front_at(layers, cell, uv), layers.yz, slope);
        ivec2 under = cell_under(uv + slope * a);
        if (under == cell) break;
        cell = under;
    }
    return Hit(true, cell, vec3(uv + slope * a, a), false);
}
