#version 300 es
// Reflected light: a sum over the table's directions, which looks up the prefiltered environment,
// and the bright lights, which are evaluated directly.
precision highp float;
precision highp samplerCube;
precision highp sampler3D;

#include frame.glsl

uniform sampler2D table; // columns: cosines; rows as in bright_table.ts
uniform sampler3D bright; // ln f by half vector and difference angle

out vec4 colour;

// Light from the direction that is the mirror image of the view in a facet of the table.
vec3 mirrored(Frame frame, vec4 facet) {
    vec3 half_ = normalize(facet.xyz);
    return incoming(frame, 2.0 * dot(frame.view, half_) * half_ - frame.view, facet.w);
}

#ifdef ANISOTROPIC
#include anisotropic.glsl
#else
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

// The mean light of the diffuse part and of the table's directions by their weights, times the albedo:
// a few directions thus reflect as much as all.
vec3 reflected(Frame frame) {
    int columns = textureSize(table, 0).x;
    float column = clamp(frame.view.z * float(columns) - 0.5, 0.0, float(columns) - 1.0);
    int left = int(column);
    int right = min(left + 1, columns - 1);
    float share = column - float(left);
    int last = textureSize(table, 0).y - 2;
    vec3 total = float(samples) * mix(texelFetch(table, ivec2(left, last), 0).rgb,
                                      texelFetch(table, ivec2(right, last), 0).rgb, share);
    vec3 albedo = mix(texelFetch(table, ivec2(left, last + 1), 0).rgb,
                      texelFetch(table, ivec2(right, last + 1), 0).rgb, share);
    vec3 even = textureLod(irradiance, bent, 0.0).rgb;
    own = albedo * meanLight(frame.z);
    vec3 sum = total * mix(own, even, openness);
    for (int i = 0; i < samples; i++) {
        vec4 first = texelFetch(table, ivec2(left, 2 * i), 0);
        vec4 second = texelFetch(table, ivec2(right, 2 * i), 0);
        vec3 firstWeight = texelFetch(table, ivec2(left, 2 * i + 1), 0).rgb;
        vec3 secondWeight = texelFetch(table, ivec2(right, 2 * i + 1), 0).rgb;
        total += mix(firstWeight, secondWeight, share);
        if (dot(first.xyz, second.xyz) > 0.97 && abs(first.w - second.w) < 2.0) {
            vec4 between = mix(first, second, share);
            sum += mix(firstWeight, secondWeight, share) * mirrored(frame, between);
        } else { // of different lobes of the proposal
            sum += (1.0 - share) * firstWeight * mirrored(frame, first);
            sum += share * secondWeight * mirrored(frame, second);
        }
    }
    return max(sum, 0.0) * albedo / max(total, 1e-6);
}

vec3 f(Frame frame, vec3 light) {
    return f(frame.z, frame.view.x * frame.x + frame.view.z * frame.z, light);
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(positions, pixel, 0);
    if (position.w <= 0.0) {
        colour = vec4(0.0, 0.0, 0.0, -position.w); // materials do not reflect on their backs
        return;
    }
    Frame frame = frameAt(pixel, position.xyz);
#ifdef ANISOTROPIC
    frame = tangentFrame(frame, pixel);
#endif
    vec3 sum = reflected(frame);

    for (int i = 0; i < lights; i++) {
        float cosLight = dot(frame.z, lightDirections[i]);
        if (cosLight > 0.0) {
            sum += f(frame, lightDirections[i]) * cosLight * open(lightDirections[i]) * lightPowers[i];
        }
    }
    colour = vec4(sum, 1.0);
}
