#version 300 es
// Irradiance over pi by the normal: the mean of the environment, weighted by the cosine.
precision highp float;
precision highp samplerCube;

uniform samplerCube environment;
uniform mat3 face; // to a direction from place on the face
uniform float level; // of the environment whose texels are summed
uniform float side; // texels along a side of that level

in vec2 place;
out vec4 colour;

void main() {
    vec3 normal = normalize(face * vec3(place, 1.0));
    vec4 sum = vec4(0.0);
    for (float y = 1.0 / side - 1.0; y < 1.0; y += 2.0 / side) {
        for (float x = 1.0 / side - 1.0; x < 1.0; x += 2.0 / side) {
            vec3 texel = vec3(x, y, 1.0);
            float solidAngle = pow(dot(texel, texel), -1.5);
            texel = normalize(texel);
            for (int axis = 0; axis < 6; axis++) {
                vec3 light = axis % 3 == 0 ? texel.zxy : axis % 3 == 1 ? texel.yzx : texel;
                light = axis < 3 ? light : -light;
                float weight = max(dot(normal, light), 0.0) * solidAngle;
                sum += vec4(textureLod(environment, light, level).rgb, 1.0) * weight;
            }
        }
    }
    colour = vec4(sum.rgb / sum.a, 1.0);
}
