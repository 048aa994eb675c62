#version 300 es
// Exposure, the neutral tone curve of the Khronos Group (2024), and sRGB.
precision highp float;

uniform sampler2D picture;
uniform float exposure;

in vec2 place;
out vec4 colour;

const float START = 0.8 - 0.04;
const float DESATURATION = 0.15;

vec3 toned(vec3 light) {
    float least = min(light.r, min(light.g, light.b));
    float offset = least < 0.08 ? least - 6.25 * least * least : 0.04;
    light -= offset;
    float peak = max(light.r, max(light.g, light.b));
    if (peak < START) {
        return light;
    }
    float rest = 1.0 - START;
    float lowered = 1.0 - rest * rest / (peak + rest - START);
    light *= lowered / peak;
    float grey = 1.0 - 1.0 / (DESATURATION * (peak - lowered) + 1.0);
    return mix(light, vec3(lowered), grey);
}

// Noise of half a step, against bands in smooth gradients.
float dither(vec2 pixel) {
    return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) - 0.5;
}

void main() {
    vec3 light = max(textureLod(picture, 0.5 * place + 0.5, 0.0).rgb, 0.0) * exposure;
    vec3 shown = clamp(toned(light), 0.0, 1.0);
    vec3 encoded = mix(12.92 * shown, 1.055 * pow(shown, vec3(1.0 / 2.4)) - 0.055,
                       step(0.0031308, shown));
    colour = vec4(encoded + dither(gl_FragCoord.xy) / 255.0, 1.0);
}
