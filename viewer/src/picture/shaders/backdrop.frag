#version 300 es
// What lies behind the object: a ground and a wall in the environment's light, or a panorama out of focus;
// with the object's shadow, and its reflection in the ground.
precision highp float;
precision highp samplerCube;

uniform vec3 eye;
uniform vec3 right; // to the picture's right edge, at the distance of 1
uniform vec3 up;
uniform vec3 forward;
uniform vec2 turn;
uniform samplerCube environment;
uniform samplerCube irradiance; // over pi, by the normal
uniform sampler2D ground; // share of the light that it has
uniform sampler2D mirror; // the object as the ground reflects it, times opacity
uniform vec4 toMirror; // from pixels to its texels: shift and factors; 0: there is none
uniform vec2 size; // radius of the object, and half the side of the square in `ground`
uniform bool isPanorama;
uniform bool isPlain; // whether there are shadow and reflection alone

in vec2 place;
out vec4 colour;

const float BLUR = 4.0; // level of a panorama
const float WIDER = 3.0; // its width relative to the picture's, to show the horizon from above
const vec2 GREY = vec2(0.24, 0.08); // ground and wall, a little in the light's colour

vec3 inEnvironment(vec3 v) {
    return vec3(turn.x * v.x + turn.y * v.y, turn.x * v.y - turn.y * v.x, v.z);
}

// What the ground reflects, times opacity.
vec4 reflection(vec3 direction) {
    vec2 texel = 1.0 / vec2(textureSize(mirror, 0));
    vec2 at = (gl_FragCoord.xy * toMirror.zw + toMirror.xy) * texel;
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 4; k++) {
        sum += textureLod(mirror, at + texel * (vec2(float(k % 2), float(k / 2)) - 0.5), 0.0);
    }
    float share = 0.1 + 0.9 * pow(1.0 - abs(direction.z), 5.0); // of a polished floor, as of Schlick (1994)
    return share * sum / 4.0;
}

void main() {
    vec3 direction = normalize(forward + place.x * right + place.y * up);
    vec3 above = textureLod(irradiance, vec3(0.0, 0.0, 1.0), 0.0).rgb;
    vec3 tint = mix(vec3(1.0), above / max(dot(above, vec3(0.2126, 0.7152, 0.0722)), 1e-4), 0.15);
    vec3 light = GREY.y * tint;
    vec3 shade = vec3(1.0);
    vec4 seen = vec4(0.0);
    if (direction.z < -1e-3 && eye.z > 0.0) {
        vec2 at = (eye - direction * (eye.z / direction.z)).xy;
        float away = length(at) / size.x;
        light = mix(light, GREY.x * tint, 1.0 / (1.0 + 0.05 * away * away)); // a pool of light
        vec2 inside = abs(at) / size.y;
        float border = smoothstep(1.0, 0.8, max(inside.x, inside.y));
        shade = mix(vec3(1.0), textureLod(ground, 0.5 * at / size.y + 0.5, 0.0).rgb, border);
        if (toMirror.z > 0.0 && away < 4.0) {
            seen = reflection(direction);
        }
    }
    if (isPanorama) {
        vec3 wide = normalize(forward + WIDER * (place.x * right + place.y * up));
        light = textureLod(environment, inEnvironment(wide), BLUR).rgb;
    }
    float dark = dot(shade, vec3(0.2126, 0.7152, 0.0722));
    // What is laid over an encoded colour darkens it by the curve of the screen.
    vec4 behind = isPlain ? vec4(vec3(0.0), 1.0 - pow(dark, 1.0 / 2.2)) : vec4(shade * light, 1.0);
    colour = vec4(seen.rgb, seen.a) + (1.0 - seen.a) * behind;
}
