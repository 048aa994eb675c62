#version 300 es
// A level of the environment from the next finer one: sixteen texels with binomial weights.
precision highp float;
precision highp samplerCube;

uniform samplerCube environment; // its base level is the finer one
uniform mat3 face; // to a direction from place on the face
uniform float side; // texels along a side of the finer level

in vec2 place;
out vec4 colour;

void main() {
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 4; k++) {
            vec2 at = place + (vec2(float(i), float(k)) - 1.5) * (2.0 / side);
            float weight = (i == 1 || i == 2 ? 3.0 : 1.0) * (k == 1 || k == 2 ? 3.0 : 1.0)
                * pow(1.0 + dot(at, at), -1.5);
            sum += vec4(textureLod(environment, face * vec3(at, 1.0), 0.0).rgb, 1.0) * weight;
        }
    }
    colour = vec4(sum.rgb / sum.a, 1.0);
}
