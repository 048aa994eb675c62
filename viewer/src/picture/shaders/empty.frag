#version 300 es
// Depth alone: colours are masked.
precision mediump float;

out vec4 colour;

void main() {
    colour = vec4(0.0);
}
