#version 300 es
// The object's triangles in the colours that were computed for their pixels.
precision highp float;

uniform sampler2D shaded; // alpha: 0 where the middle of the pixel shows no surface
uniform vec2 mirror; // share of a reflection in the ground, and the height at which it fades

in vec3 worldPosition;
out vec4 colour;

void main() {
    ivec2 place = ivec2(gl_FragCoord.xy);
    ivec2 last = textureSize(shaded, 0) - 1;
    colour = texelFetch(shaded, place, 0);
    if (colour.a == 0.0) { // an edge: the neighbours' colour
        vec4 sum = vec4(0.0);
        for (int i = 0; i < 9; i++) {
            ivec2 beside = clamp(place + ivec2(i % 3 - 1, i / 3 - 1), ivec2(0), last);
            sum += texelFetch(shaded, beside, 0);
        }
        if (sum.a == 0.0) {
            discard;
        }
        colour = sum / sum.a;
    }
    colour.a = mirror.y > 0.0 ? mirror.x * exp(-worldPosition.z / mirror.y) : 1.0;
}
