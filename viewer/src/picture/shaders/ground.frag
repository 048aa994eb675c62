#version 300 es
// The share of its light that each place of the ground has beside the object: the environment in many
// directions, by their cosines, without those in which the object hides it.
precision highp float;
precision highp samplerCube;
precision highp sampler2DArray;

const int MOST_LIGHTS = 4;
const float PI = 3.14159265;

uniform samplerCube environment;
uniform sampler2DArray shadows; // of a direction each, see core/occlusion.ts
uniform int axes;
uniform vec2 turn;
uniform vec3 lightDirections[MOST_LIGHTS];
uniform vec3 lightPowers[MOST_LIGHTS];
uniform int lights;

in vec2 place;
out vec4 colour;

void main() {
    vec3 open = vec3(0.0), all = vec3(1e-6);
    float count = float(axes);
    float level = 8.0 - 0.5 * log2(max(count, 1.0)); // its texels are as large as the share of one direction
    for (int axis = 0; axis < axes; axis++) {
        float z = (float(axis) + 0.5) / count;
        float phi = float(axis) * PI * (3.0 - sqrt(5.0));
        vec3 direction = vec3(sqrt(1.0 - z * z) * vec2(cos(phi), sin(phi)), z);
        direction.xy = vec2(turn.x * direction.x + turn.y * direction.y,
                            turn.x * direction.y - turn.y * direction.x);
        vec3 light = z * textureLod(environment, direction, level).rgb;
        for (int i = 0; i < lights; i++) { // spread over the directions beside it
            float narrow = 0.4 * count;
            float near = exp((dot(direction, lightDirections[i]) - 1.0) * narrow);
            light += lightPowers[i] * lightDirections[i].z * near * narrow * count / (4.0 * PI * PI);
        }
        all += light;
        open += light * (1.0 - texelFetch(shadows, ivec3(gl_FragCoord.xy, axis), 0).r);
    }
    colour = vec4(axes == 0 ? vec3(1.0) : open / all, 1.0);
}
