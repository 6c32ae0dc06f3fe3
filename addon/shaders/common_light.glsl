// What arrives at a surface and what the picture shows of it: DISPLAY is the place in DISPLAYS of settings/groups.py.
uniform vec4 u_light_color;      // rgb times strength; a: 1 = there is a light
uniform mat3 u_spot;              // a spot's own axes, the third towards the light; scaled as the spot is
uniform vec4 u_cone;              // cosine of the half angle (2: no cone), blend; of a panel the tangent of its spread and its normalisation
uniform int u_lamp;               // 0 sun or point, 1 spot, 2 panel
uniform vec4 u_ambient_sky, u_ambient_ground;
uniform vec3 u_error_colors[ERROR_COLORS], u_map_colors[MAX_MAPS], u_no_color;  // sRGB
uniform vec2 u_error_scale;      // log2 m of the first and the last error colour

// Whether a lamp shines that way at all: within a spot's cone.
bool in_cone(vec3 towards) {
    return u_lamp == 0 || normalize(u_spot * towards).z > u_cone.x;
}

// Distance, cone and panel: 1 for a sun. Normalised so that a lamp of strength 1 gives 1 at one metre, on its axis.
float light_falloff(vec3 x_ws) {
    if (u_light.w == 0.0) return 1.0;
    vec3 towards = u_light.xyz - x_ws;
    float falloff = 1.0 / max(dot(towards, towards), 1e-6);
    if (u_lamp == 0) return falloff;
    float cosine = normalize(u_spot * towards).z;
    if (u_lamp == 1) return falloff * smoothstep(0.0, 1.0, (cosine - u_cone.x) / max((1.0 - u_cone.x) * u_cone.y, 1e-5));
    if (cosine <= 1e-4) return 0.0;
    float tangent = sqrt(max(1.0 - cosine * cosine, 0.0)) / cosine;   // Cycles' area_light_spread_attenuation
    return falloff * cosine * (u_cone.w > 0.0 ? max((u_cone.z - tangent) * u_cone.w, 0.0) : 1.0);
}

vec3 linear_from_srgb(vec3 c) {
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

// The heat map's scale, the same as in images/heatmap.py: one colour per doubling of m.
vec3 error_color(float m) {
    if (m < 0.0) return u_no_color;
    float x = clamp(log2(max(m, 1e-6)), u_error_scale.x, u_error_scale.y) - u_error_scale.x;
    int i = min(int(x), ERROR_COLORS - 2);
    return mix(u_error_colors[i], u_error_colors[i + 1], x - float(i));
}

vec3 map_color(int map) { return map < 0 ? u_no_color : u_map_colors[map]; }

// How bright a data colour is drawn, so that shape and shadows stay readable while the colour keeps its meaning.
float data_shade(vec3 normal, float cosine, float light) {
    return 0.5 + 0.2 * (0.5 + 0.5 * normal.z) + 0.3 * cosine * clamp(light, 0.0, 1.0);
}

// Light that comes from the half of the world round a direction: exact for a sky and a ground of one colour each.
vec3 ambient_at(vec3 normal) {
    return mix(u_ambient_ground.rgb * sky_reach.y, u_ambient_sky.rgb * sky_reach.x, 0.5 + 0.5 * normal.z);
}

vec3 displayed(vec3 color, vec3 normal, vec3 light_ws, float light, vec3 errors, int map) {
    float cosine = max(dot(normal, light_ws), 0.0);
#if DISPLAY == 1
    return vec3(light);
#elif DISPLAY == 2
    return linear_from_srgb(error_color(errors.x) * data_shade(normal, cosine, light));
#elif DISPLAY == 3
    return linear_from_srgb(map_color(map) * data_shade(normal, cosine, light));
#else
    return color * (ambient_at(normal) + u_light_color.rgb * (cosine * light));
#endif
}
