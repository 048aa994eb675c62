#version 300 es
// A frame's share of the picture, to be blended with what has been gathered.
precision highp float;

uniform sampler2D frame;
uniform float share;

in vec2 place;
out vec4 colour;

void main() {
    colour = vec4(texelFetch(frame, ivec2(gl_FragCoord.xy), 0).rgb, share);
}
