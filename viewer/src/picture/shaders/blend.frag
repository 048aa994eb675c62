#version 300 es
// A frame, to be blended with what has been gathered.
precision highp float;

uniform sampler2D frame;

in vec2 place;
out vec4 colour;

void main() {
    colour = texelFetch(frame, ivec2(gl_FragCoord.xy), 0);
}
