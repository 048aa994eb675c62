#version 300 es
// Exposure, a tone curve, sRGB, and what lies behind the picture; or the colour difference of two
// pictures that lie beside each other.
precision highp float;

uniform sampler2D picture;
uniform float exposure;
uniform int tone; // 0: neutral, 1: filmic, 2: none
uniform vec4 behind; // colour (sRGB) and opacity where the picture is transparent
uniform float scale; // colour difference that is shown by the last colour; 0: one picture, -1: numbers

in vec2 place;
out vec4 colour;

const float START = 0.8 - 0.04;
const float DESATURATION = 0.15;

// "PBR Neutral" of the Khronos Group (2024).
vec3 neutral(vec3 light) {
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

// The Academy's ACES, as fitted by Hill (2017, BakingLab), with the exposure of three.js.
vec3 filmic(vec3 light) {
    mat3 toAces = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    mat3 toRgb = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605,
                      1.07602);
    vec3 x = toAces * light / 0.6;
    return toRgb * ((x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081));
}

// Noise of half a step, against bands in smooth gradients.
float dither(vec2 pixel) {
    return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) - 0.5;
}

// Linear sRGB as it is shown, and opacity, at a place in [0, 1]^2 of the texture.
vec4 shownAt(vec2 at) {
    vec4 texel = max(textureLod(picture, at, 0.0), 0.0);
    float opacity = min(texel.a, 1.0);
    vec3 light = texel.rgb / max(opacity, 1e-4) * exposure;
    if (tone < 2) {
        light = tone == 0 ? neutral(light) : filmic(light);
    }
    return vec4(clamp(light, 0.0, 1.0), opacity);
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
        vec3 between = lab(shownAt(left).rgb) - lab(shownAt(left + vec2(0.5, 0.0)).rgb);
        float size = length(between);
        colour = vec4(scale > 0.0 ? difference(size / scale) : vec3(size), 1.0);
        return;
    }
    vec4 shown = shownAt(0.5 * place + 0.5);
    vec3 encoded = mix(12.92 * shown.rgb, 1.055 * pow(shown.rgb, vec3(1.0 / 2.4)) - 0.055,
                       step(0.0031308, shown.rgb));
    encoded += dither(gl_FragCoord.xy) / 255.0;
    float rest = (1.0 - shown.a) * behind.a;
    colour = vec4(shown.a * encoded + rest * behind.rgb, shown.a + rest); // premultiplied
}
