#version 300 es
// Reflected light: a sum over the table's directions, which looks up the prefiltered environment,
// and the bright lights, which are evaluated directly.
precision highp float;
precision highp samplerCube;
precision highp sampler3D;

#include frame.glsl

uniform sampler2D table; // columns: cosines; rows as in direction_table.ts

out vec4 colour;

// Light from the direction that is the mirror image of the view in a facet of the table.
vec3 mirrored(Frame frame, vec4 facet) {
    vec3 half_ = normalize(facet.xyz);
    return incoming(frame, 2.0 * dot(frame.view, half_) * half_ - frame.view, facet.w);
}

#include material.glsl

uniform sampler3D rest; // the material's table

#ifdef ANISOTROPIC
#include anisotropic.glsl
#else
uniform vec3 lobe[6]; // numbers of the material's lobe

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
    vec3 local = vec3(dot(light, frame.x), dot(light, frame.y), dot(light, frame.z));
    vec3 wide[6] = lobe; // over the normals of the pixel (Kaplanyan et al. 2016)
    wide[0] = sqrt(lobe[0] * lobe[0] + 0.25 * spread * spread);
    return material_f(wide, rest, frame.view, local);
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(positions, pixel, 0);
    if (position.w <= 0.0) {
        colour = vec4(0.0);
        return;
    }
    Frame frame = frameAt(pixel, position);
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
    colour = faded(sum, position.z);
}
