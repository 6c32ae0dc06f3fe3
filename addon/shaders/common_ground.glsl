// The ground that only catches shadows (scene/ground.py): how they darken what is behind the model, and where they fade out.
#if GROUND
uniform vec4 u_ground;          // middle of the model's footprint relative to u_origin, half its extents
uniform float u_ground_reach;   // metres beside the footprint at which shadows are gone
uniform float u_ground_strength;

float ground_fade(vec2 at) {
    float beside = length(max(abs(at - u_ground.xy) - u_ground.zw, 0.0));
    return 1.0 - smoothstep(0.35, 1.0, beside / u_ground_reach);
}

// Of the light of sun and sky on a white ground: what shadows of the sun (`dark`) and of the sky take of it, and all of it.
vec2 ground_taken(float fade, float dark, float sun) {
    const vec3 brightness = vec3(0.2126, 0.7152, 0.0722);
    float direct = sun * dot(u_light_color.rgb, brightness), sky = dot(u_ambient_sky.rgb, brightness);
    return vec2(u_ground_strength * (dark * direct + fade * clamp(1.0 - sky_reach.x, 0.0, 1.0) * sky), max(direct + sky, 1e-6));
}

// The background less the share of its light that a shadow takes from a white ground: the sun's part of sun and sky. Premultiplied, so that
// over a transparent background what is left is black with the shadow's opacity.
vec4 shadow_caught(float fade, float dark, float sun) {
    vec2 of_all = ground_taken(fade, dark, sun);
    float taken = of_all.x / of_all.y;
    return u_background * (1.0 - taken) + vec4(0.0, 0.0, 0.0, taken);
}
#endif
