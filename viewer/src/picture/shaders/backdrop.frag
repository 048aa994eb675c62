#version 300 es
// What lies behind the object: the environment, out of focus, and the object's shadow on the ground,
// which is that of an upright cylinder under the main light.
precision highp float;
precision highp samplerCube;

uniform vec3 eye;
uniform vec3 right; // to the picture's right edge, at the distance of 1
uniform vec3 up;
uniform vec3 forward;
uniform vec2 turn;
uniform samplerCube environment;
uniform float blur; // level of detail
uniform float wider; // width relative to the picture's, to show the horizon from above
uniform vec3 size; // of the object: radius of its foot, radius and height
uniform vec3 key; // direction of the main light, in the environment
uniform vec2 keySize; // the light's angular radius, and its share of the light on the ground
uniform bool isPlain; // whether there is the shadow alone

in vec2 place;
out vec4 colour;

vec3 inEnvironment(vec3 v) {
    return vec3(turn.x * v.x + turn.y * v.y, turn.x * v.y - turn.y * v.x, v.z);
}

void main() {
    vec3 direction = normalize(forward + place.x * right + place.y * up);
    vec3 wide = normalize(forward + wider * (place.x * right + place.y * up));
    float shade = 1.0;
    if (direction.z < -1e-3 && eye.z > 0.0) {
        vec3 ground = eye - direction * (eye.z / direction.z);
        float away = length(ground.xy);
        float contact = 0.4 * exp(-pow(max(away - size.x, 0.0) / (0.14 * size.y), 1.2));
        float broad = 0.25 * exp(-pow(away / (1.4 * size.y), 2.0));
        // Where the way to the light passes the axis of the object.
        vec2 at = inEnvironment(ground).xy;
        float way = clamp(-dot(at, key.xy) / dot(key.xy, key.xy), 0.0, size.z / key.z);
        float soft = keySize.x * way + 0.12 * size.y;
        float radius = mix(size.x, size.y, smoothstep(0.0, 0.4 * size.z, way * key.z));
        float hidden = 1.0 - smoothstep(-soft, soft, length(at + way * key.xy) - radius);
        shade = (1.0 - contact) * (1.0 - broad) * (1.0 - keySize.y * hidden);
    }
    if (isPlain) {
        colour = vec4(vec3(0.0), 1.0 - pow(shade, 1.0 / 2.2)); // it is laid over an encoded colour
        return;
    }
    colour = vec4(shade * textureLod(environment, inEnvironment(wide), blur).rgb, 1.0);
}
