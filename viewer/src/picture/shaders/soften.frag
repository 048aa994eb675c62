#version 300 es
// The ground's light with the steps between directions smoothed, the more the farther from the object.
precision highp float;

uniform sampler2D sharp;
uniform float contact; // radius of the object relative to half the square

in vec2 place;
out vec4 colour;

void main() {
    float radius = 0.12 * max(length(place) - 0.5 * contact, 0.01);
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 24; k++) {
        float angle = 2.39996323 * float(k);
        vec2 shift = radius * sqrt((float(k) + 0.5) / 24.0) * vec2(cos(angle), sin(angle));
        sum += textureLod(sharp, 0.5 * (place + shift) + 0.5, 0.0);
    }
    colour = sum / 24.0;
}
