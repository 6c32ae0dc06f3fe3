// Percentage-closer filtering of exact cell tests (Reeves): test first, average after. PCF is a compile-time 1, 2, 3, 4, 5 (taps per axis).

// Light reaching a receiver that faces it, 0...1.
float light_at(int map, vec4 q, vec3 x_ws, vec3 normal_ws, vec3 light_ws) {
    if (any(greaterThan(abs(q.xy), vec2(1.0)))) return 1.0;
    Receiver r = Receiver(x_ws, normal_ws, map, q, automatic_bias_m(map, q, x_ws, normal_ws, light_ws));
    vec2 texel = (q.xy * 0.5 + 0.5) * u_map_size;
    float lit = 0.0;
    for (int y = 0; y < PCF_SIDE; ++y)
        for (int x = 0; x < PCF_SIDE; ++x)
            lit += lit_by_cell(r, ivec2(floor(texel + vec2(x, y) - 0.5 * float(PCF_SIDE - 1))));
    return lit / float(PCF_SIDE * PCF_SIDE);
}
