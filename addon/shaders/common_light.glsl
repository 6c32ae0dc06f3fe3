// What arrives at a surface and what the picture shows of it.
uniform vec4 u_light_color;      // rgb times strength; a: 1 = there is a light
uniform vec4 u_spot;             // axis towards the light, cosine of the half angle; cosine 2 = no cone
uniform float u_spot_blend;
uniform vec4 u_ambient_sky, u_ambient_ground;
uniform int u_display;           // DISPLAYS of pipeline/settings.py

// Distance and cone: 1 for a sun. Normalised so that a point light of strength 1 gives 1 at one metre.
float light_falloff(vec3 x_ws) {
    if (u_light.w == 0.0) return 1.0;
    vec3 towards = u_light.xyz - x_ws;
    float falloff = 1.0 / max(dot(towards, towards), 1e-6);
    if (u_spot.w > 1.0) return falloff;
    float cosine = dot(normalize(towards), u_spot.xyz);
    return falloff * smoothstep(0.0, 1.0, (cosine - u_spot.w) / max((1.0 - u_spot.w) * u_spot_blend, 1e-5));
}

vec3 error_color(float m) {
    if (m < 0.0) return vec3(0.5);
    float x = clamp(log2(max(m, 1e-6)) / 4.0, -1.0, 1.0);  // 1/16 ... 16
    vec3 cold = vec3(0.16, 0.33, 0.75), good = vec3(0.93, 0.93, 0.90), hot = vec3(0.78, 0.10, 0.08);
    return x < 0.0 ? mix(good, cold, -x) : mix(good, hot, x);
}

vec3 map_color(int map) {
    if (map < 0) return vec3(0.5);
    float hue = fract(float(map) * 0.61803398875) * 6.0;
    vec3 rgb = clamp(abs(mod(hue + vec3(0.0, 4.0, 2.0), 6.0) - 3.0) - 1.0, 0.0, 1.0);
    return mix(vec3(0.85), rgb, 0.55);
}

vec3 displayed(vec3 color, vec3 normal, vec3 light_ws, float light, vec3 errors, int map) {
    vec3 ambient = mix(u_ambient_ground.rgb, u_ambient_sky.rgb, 0.5 + 0.5 * normal.z);
    float cosine = max(dot(normal, light_ws), 0.0);
    vec3 arriving = ambient + u_light_color.rgb * (cosine * light);
    if (u_display == 1) return vec3(light);
    if (u_display == 2) return error_color(errors.x) * (0.4 + 0.6 * arriving / max(max(arriving.r, arriving.g), max(arriving.b, 1.0)));
    if (u_display == 3) return map_color(map) * arriving;
    return color * arriving;
}
