#version 300 es
// What lies behind the object: the environment, out of focus, and the object's shadow on the ground.
precision highp float;
precision highp samplerCube;

uniform vec3 eye;
uniform vec3 right; // to the picture's right edge, at the distance of 1
uniform vec3 up;
uniform vec3 forward;
uniform vec2 turn;
uniform samplerCube environment;
uniform float blur; // level of detail
uniform vec2 shadow; // radius of the object's foot, and of the whole object

in vec2 place;
out vec4 colour;

void main() {
    vec3 direction = normalize(forward + place.x * right + place.y * up);
    vec3 turned = vec3(turn.x * direction.x + turn.y * direction.y,
                       turn.x * direction.y - turn.y * direction.x, direction.z);
    vec3 light = textureLod(environment, turned, blur).rgb;
    if (direction.z < -1e-3 && eye.z > 0.0) {
        vec3 ground = eye - direction * (eye.z / direction.z);
        float away = length(ground.xy);
        float contact = 0.55 * exp(-pow(max(away - shadow.x, 0.0) / (0.16 * shadow.y), 1.2));
        float broad = 0.38 * exp(-pow(away / (1.15 * shadow.y), 2.0));
        light *= (1.0 - contact) * (1.0 - broad);
    }
    colour = vec4(light, 1.0);
}
