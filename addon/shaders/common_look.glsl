// How a surface answers light beside its colour: four texels a look (scene/looks.py).
uniform samplerBuffer u_looks;
#define HOLDOUT 4u    // flags of scene/looks.py
#define CATCHER 8u
#define UNLIT 16u
#define FLAG_SHIFT 1  // as in pipeline/geometry/draw_list.py
#define LOOK_SHIFT 8

struct Look {
    vec3 emission;
    float weight, metallic, roughness, f0, hole;
    vec3 through;     // of what lies behind, to the eye
};

Look look_of(uvec4 info) {
    int row = int(info.w >> LOOK_SHIFT) * 4;
    vec4 a = texelFetch(u_looks, row), b = texelFetch(u_looks, row + 1), c = texelFetch(u_looks, row + 2);
    return Look(a.rgb, a.a, b.r, b.g, b.b, b.a, c.rgb);
}

// Of the light, which tints its shadow.
vec3 tint_of(uvec4 info) { return texelFetch(u_looks, int(info.w >> LOOK_SHIFT) * 4 + 3).rgb; }

bool has_flag(uvec4 info, uint flag) { return ((info.w >> FLAG_SHIFT) & flag) != 0u; }

// Part of the light from all around that a GGX coat of IOR 1.5 reflects: least squares over its integral, off by at most 0.01 where the
// cosine is above 0.3. q: one less the cosine.
float coat_albedo(float r, float q) {
    float q2 = q * q;
    return 0.0416 - 0.0278 * r * r + q2 * (0.1197 + 0.0388 * r - 0.14 * r * r) + q2 * q2 * q * (0.8596 + r * (1.3692 * r - 2.1695));
}

// The same of one that reflects all: less than 1, because light that meets the coat twice is not in the lobe.
float lobe_albedo(float r, float q) {
    return 1.0 + r * r * (1.1852 - 3.0414 * q + r * (7.8421 * q - 4.4373 + r * (2.5103 - 4.3174 * q)));
}

// π times the GGX coat's value times the cosine, over its reflectance there: D of Walter 2007 (33), Smith's correlated G of Heitz 2014 (99).
float coat_lobe(float roughness, float nl, float nv, float nh) {
    float alpha = max(roughness * roughness, 0.01), a2 = alpha * alpha;
    float d = nh * nh * (a2 - 1.0) + 1.0;
    float shadowing = nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2);
    return a2 / (d * d) * 0.5 / max(shadowing, 1e-6) * nl;
}

// What a surface of `look` and `color` sends to the eye: of `light`, which comes from one direction with the radiance that a white diffuse
// surface facing it would show, of the ambient light on its normal and round its mirror direction, and of its own.
vec3 answered(Look look, vec3 color, vec3 normal, vec3 light_ws, vec3 eye_ws, vec3 light, vec3 ambient, vec3 mirrored) {
    float nv = max(abs(dot(normal, eye_ws)), 1e-3), nl = max(dot(normal, light_ws), 0.0);
    vec3 halfway = normalize(light_ws + eye_ws + 1e-6 * normal);
    float grazing = pow(1.0 - clamp(dot(light_ws, halfway), 0.0, 1.0), 5.0);
    float q = 1.0 - min(nv, 1.0), whole = lobe_albedo(look.roughness, q);
    float coat = clamp(coat_albedo(look.roughness, q) * look.f0 / 0.04, 0.0, 1.0);
    vec3 diffuse = color * ((1.0 - look.metallic) * (1.0 - coat));
    vec3 mirror = mix(vec3(coat), color + (1.0 - color) * (pow(q, 5.0) * (1.0 - look.roughness)), look.metallic);
    vec3 metal = (color + (1.0 - color) * grazing) * (1.0 + color * (1.0 / whole - 1.0));
    vec3 shine = mix(vec3(look.f0 > 0.0 ? look.f0 + (1.0 - look.f0) * grazing : 0.0), metal, look.metallic);
    vec3 lit = diffuse * nl + shine * coat_lobe(look.roughness, nl, nv, max(dot(normal, halfway), 0.0));
    return look.weight * (light * lit + ambient * diffuse + mirrored * mirror) + look.emission;
}
