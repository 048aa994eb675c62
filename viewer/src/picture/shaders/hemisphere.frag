#version 300 es
// Radiance from each of many directions of the upper hemisphere, by their cosines: the environment's, and
// the bright lights', which lobes of the integral 1 spread over the directions beside them.
precision highp float;
precision highp samplerCube;

const int MOST_LIGHTS = 4;
const float PI = 3.14159265;

uniform samplerCube environment;
uniform int axes;
uniform vec2 turn;
uniform vec3 lightDirections[MOST_LIGHTS];
uniform vec3 lightPowers[MOST_LIGHTS];
uniform int lights;

out vec4 colour;

void main() {
    float count = max(float(axes), 1.0), axis = floor(gl_FragCoord.x);
    float level = 8.0 - 0.5 * log2(count); // its texels are as large as the share of one direction
    float z = min((axis + 0.5) / count, 1.0); // see core/occlusion.ts
    float phi = axis * PI * (3.0 - sqrt(5.0));
    vec2 xy = sqrt(1.0 - z * z) * vec2(cos(phi), sin(phi));
    vec3 direction = vec3(turn.x * xy.x + turn.y * xy.y, turn.x * xy.y - turn.y * xy.x, z);
    vec3 light = z * textureLod(environment, direction, level).rgb;
    for (int i = 0; i < lights; i++) {
        float narrow = 0.4 * count;
        float near = exp((dot(direction, lightDirections[i]) - 1.0) * narrow);
        light += lightPowers[i] * lightDirections[i].z * near * narrow / (2.0 * PI);
    }
    colour = vec4(light, 1.0);
}
