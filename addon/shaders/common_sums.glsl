// What is added up where a picture is the sum of many hard lights' (passes/light_sums.py); resolve.frag makes the picture of the sums. Every
// light's colour is multiplied by their number, so that the picture is the mean of pictures.
uniform float u_part;                         // of this picture
layout(location = 1) out vec4 out_shares;     // light that arrives, and that would without shadows; of what only catches shadows the
                                              // light that is taken, and all there would be

// The colour of a surface; what has no surface stays at alpha 0, one that is a hole has alpha 1, an opaque one 2.
vec4 summed(vec4 shown) { return u_part * vec4(shown.rgb, 1.0 + shown.a); }

void add_arriving(float arriving, float all) {
    float strength = dot(u_light_color.rgb, vec3(0.2126, 0.7152, 0.0722));
    out_shares.xy += u_part * strength * vec2(arriving, all);
}

void add_caught(float taken, float all) { out_shares.zw = u_part * vec2(taken, all); }
