#version 300 es
// Reflected light: a sum over the table's directions, which looks up the prefiltered environment,
// and the bright lights, which are evaluated directly.
precision highp float;
precision highp samplerCube;
precision highp sampler3D;

const int MOST_LIGHTS = 4;

uniform vec3 eye;
uniform vec2 turn; // cosine and sine of the environment's rotation about z
uniform sampler2D table; // columns: cosines; rows: half vector and log2 pdf, weight, in turn
uniform int samples;
uniform float density; // directions taken so far, for the level of detail
uniform samplerCube environment;
uniform float side; // texels along a side of the environment
uniform sampler3D bright; // ln f by half vector and difference angle
uniform vec3 lightDirections[MOST_LIGHTS];
uniform vec3 lightPowers[MOST_LIGHTS]; // irradiance at normal incidence
uniform int lights;

uniform sampler2D positions; // of the surface that each pixel shows, see surface.frag
uniform sampler2D normals;

out vec4 colour;

vec3 turned(vec3 v) {
    return vec3(turn.x * v.x + turn.y * v.y, turn.x * v.y - turn.y * v.x, v.z);
}

// The level whose texels are as large as the share of one direction.
float level(vec3 direction, float logPdf) {
    vec3 size = abs(direction);
    float major = max(size.x, max(size.y, size.z));
    float solidAngle = 4.0 * major * major * major / (side * side); // of a texel
    return 0.5 * (-logPdf - log2(density * solidAngle)) + 0.5;
}

// A pixel's frame, in which z is the normal, and its direction to the eye.
struct Frame {
    vec3 x;
    vec3 y;
    vec3 z;
    vec3 view;
};

// Light from the direction that is the mirror image of the view in a facet of the table.
vec3 incoming(Frame frame, vec4 facet) {
    vec3 half_ = normalize(facet.xyz);
    vec3 local = 2.0 * dot(frame.view, half_) * half_ - frame.view;
    vec3 light = local.x * frame.x + local.y * frame.y + local.z * frame.z;
    return textureLod(environment, light, level(light, facet.w)).rgb;
}

// f for directions whose half vector and difference angle lie in the table.
vec3 f(vec3 normal, vec3 view, vec3 light) {
    float cosView = dot(normal, view), cosLight = dot(normal, light);
    vec3 half_ = view + light;
    float halfLength = length(half_);
    float cosDifference = min(0.5 * halfLength, 1.0);
    float sinDifference = sqrt(max(1.0 - cosDifference * cosDifference, 0.0));
    float cosHalf = clamp((cosView + cosLight) / halfLength, 1e-3, 1.0);
    float sinHalf = length(cross(normal, half_)) / halfLength;
    float tangent = sinHalf / cosHalf;
    float x = log2(1.0 + tangent / NEAR) / log2(1.0 + FAR / NEAR);
    float y = acos(cosDifference) * (2.0 / 3.14159265);
    float z = abs(cosView - cosLight) / (2.0 * sinHalf * sinDifference + 1e-6);
    vec3 size = vec3(textureSize(bright, 0));
    vec3 at = (clamp(vec3(x, y, z), 0.0, 1.0) * (size - 1.0) + 0.5) / size;
    return exp(texture(bright, at).rgb);
}

void main() {
    vec4 position = texelFetch(positions, ivec2(gl_FragCoord.xy), 0);
    if (position.w == 0.0) {
        colour = vec4(0.0);
        return;
    }
    vec3 normal = turned(normalize(texelFetch(normals, ivec2(gl_FragCoord.xy), 0).xyz));
    vec3 view = turned(normalize(eye - position.xyz));
    float cosine = dot(normal, view);
    if (cosine < 0.004) { // smooth normals may turn away at the silhouette
        normal = normalize(normal + (0.004 - cosine) * view);
        cosine = max(dot(normal, view), 0.004);
    }
    vec3 across = view - cosine * normal;
    float size = length(across);
    vec3 tangent = size > 1e-4
        ? across / size
        : normalize(cross(normal, abs(normal.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
    vec3 bitangent = cross(normal, tangent);

    Frame frame = Frame(tangent, bitangent, normal, vec3(size, 0.0, cosine));
    int columns = textureSize(table, 0).x;
    float column = clamp(cosine * float(columns) - 0.5, 0.0, float(columns) - 1.0);
    int left = int(column);
    int right = min(left + 1, columns - 1);
    float share = column - float(left);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < samples; i++) {
        vec4 first = texelFetch(table, ivec2(left, 2 * i), 0);
        vec4 second = texelFetch(table, ivec2(right, 2 * i), 0);
        vec3 firstWeight = texelFetch(table, ivec2(left, 2 * i + 1), 0).rgb;
        vec3 secondWeight = texelFetch(table, ivec2(right, 2 * i + 1), 0).rgb;
        if (dot(first.xyz, second.xyz) > 0.97 && abs(first.w - second.w) < 2.0) {
            vec4 between = mix(first, second, share);
            sum += mix(firstWeight, secondWeight, share) * incoming(frame, between);
        } else { // of different lobes of the proposal
            sum += (1.0 - share) * firstWeight * incoming(frame, first);
            sum += share * secondWeight * incoming(frame, second);
        }
    }
    sum /= float(samples);

    for (int i = 0; i < lights; i++) {
        float cosLight = dot(normal, lightDirections[i]);
        if (cosLight > 0.0) {
            sum += f(normal, view, lightDirections[i]) * cosLight * lightPowers[i];
        }
    }
    colour = vec4(sum, 1.0);
}
