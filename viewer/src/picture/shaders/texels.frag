#version 300 es
// Reflected light of a texture of codes: a texel's material by the exported shader code, directions
// by its proposal with the prefiltered environment, and the bright lights directly.
precision highp float;
precision highp samplerCube;
precision highp sampler2DArray;

#include frame.glsl

float stored[4 * LAYERS]; // bytes of the texel, in [0, 1]

#include material.glsl

uniform sampler2DArray codes; // of the texture
uniform highp sampler3D functions; // of the basis
uniform sampler2D places; // in the texture, see surface.frag
uniform vec3 start; // of the sequence of directions

// Steps of the sequence (Roberts 2018).
const vec3 STEPS = vec3(0.8191725133961645, 0.6710436067037893, 0.5497004779019703);

out vec4 colour;

uvec3 mixed(uvec3 v) {
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// Three numbers in [0, 1) for each pixel: pcg3d of Jarzynski and Olano 2020.
vec3 hash(uvec3 v) {
    v = mixed(v * 1664525u + 1013904223u);
    v = mixed(v ^ (v >> 16u));
    return vec3(v >> 8u) / 16777216.0;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(positions, pixel, 0);
    if (position.w <= 0.0) {
        colour = vec4(0.0);
        return;
    }
    // One texel is drawn in proportion to its weight, so that the mean of the frames filters f and
    // not the code.
    vec2 at = texelFetch(places, pixel, 0).xy;
    vec2 random = fract(hash(uvec3(pixel, 0)).xy + start.zx);
    at += SPREAD * (random - 0.5) / vec2(textureSize(codes, 0).xy);
    for (int layer = 0; layer < LAYERS; layer++) {
        vec4 four = textureLod(codes, vec3(at, float(layer)), 0.0);
        stored[4 * layer] = four.r;
        stored[4 * layer + 1] = four.g;
        stored[4 * layer + 2] = four.b;
        stored[4 * layer + 3] = four.a;
    }
    UrushiMaterial material = urushi_material();
    Frame frame = frameAt(pixel, position);
    UrushiProposal proposal = urushi_proposal(material, frame.view);

    own = 0.5 * meanLight(frame.z); // of an object of average albedo
    vec3 sum = vec3(0.0);
    for (int i = 0; i < samples; i++) {
        vec3 direction = urushi_draw(proposal, frame.view, fract(start + float(i) * STEPS));
        float pdf = urushi_density(proposal, frame.view, direction);
        if (pdf > 0.0) {
            vec3 weight = urushi_f(material, frame.view, direction, functions) * (direction.z / pdf);
            sum += weight * incoming(frame, direction, log2(pdf));
        }
    }
    sum /= float(samples);

    for (int i = 0; i < lights; i++) {
        vec3 light = lightDirections[i];
        vec3 local = vec3(dot(light, frame.x), dot(light, frame.y), dot(light, frame.z));
        if (local.z > 0.0) {
            sum += urushi_f(material, frame.view, local, functions) * local.z * open(light) * lightPowers[i];
        }
    }
    colour = faded(sum, position.z);
}
