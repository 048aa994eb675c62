#version 300 es
// Exposure, the neutral tone curve of the Khronos Group (2024), and sRGB; or the colour difference of
// two pictures that lie beside each other.
precision highp float;

uniform sampler2D picture;
uniform float exposure;
uniform float scale; // colour difference that is shown by the last colour; 0: one picture, -1: numbers

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

// Linear sRGB as it is shown, at a place in [0, 1]^2 of the texture.
vec3 shownAt(vec2 at) {
    vec3 light = max(textureLod(picture, at, 0.0).rgb, 0.0) * exposure;
    return clamp(toned(light), 0.0, 1.0);
}

// CIELAB of linear sRGB, with the white of D65 (CIE 15).
vec3 lab(vec3 rgb) {
    mat3 toXyz = mat3(0.4339, 0.2126, 0.0178, 0.3762, 0.7152, 0.1095, 0.1899, 0.0722, 0.8727);
    vec3 xyz = toXyz * rgb; // relative to white
    vec3 t = mix(7.787 * xyz + 16.0 / 116.0, pow(xyz, vec3(1.0 / 3.0)), step(0.008856, xyz));
    return vec3(116.0 * t.y - 16.0, 500.0 * (t.x - t.y), 200.0 * (t.y - t.z));
}

// Colours of a difference from 0 to 1; the legend on the page has the same.
vec3 difference(float x) {
    vec3 colours[5] = vec3[5](vec3(0.0, 0.0, 4.0), vec3(81.0, 18.0, 124.0), vec3(183.0, 55.0, 121.0),
                              vec3(252.0, 137.0, 97.0), vec3(252.0, 253.0, 191.0));
    float at = 4.0 * clamp(x, 0.0, 1.0);
    int low = min(int(at), 3);
    return mix(colours[low], colours[low + 1], at - float(low)) / 255.0;
}

void main() {
    if (scale != 0.0) {
        float border = 0.5 / float(textureSize(picture, 0).x);
        vec2 left = vec2(clamp(0.25 * place.x + 0.25, border, 0.5 - border), 0.5 * place.y + 0.5);
        vec3 between = lab(shownAt(left)) - lab(shownAt(left + vec2(0.5, 0.0)));
        float size = length(between);
        colour = vec4(scale > 0.0 ? difference(size / scale) : vec3(size), 1.0);
        return;
    }
    vec3 shown = shownAt(0.5 * place + 0.5);
    vec3 encoded = mix(12.92 * shown, 1.055 * pow(shown, vec3(1.0 / 2.4)) - 0.055,
                       step(0.0031308, shown));
    colour = vec4(encoded + dither(gl_FragCoord.xy) / 255.0, 1.0);
}
