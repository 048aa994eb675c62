#version 300 es
// A face of the environment from a panorama, as Mitsuba turns it: the first row is the zenith, the
// first column +y, and a quarter on is +x.
precision highp float;

uniform sampler2D panorama;
uniform mat3 face;

in vec2 place;
out vec4 colour;

void main() {
    vec3 direction = normalize(face * vec3(place, 1.0));
    vec2 at = vec2(atan(direction.x, direction.y) / 6.28318531,
                   acos(clamp(direction.z, -1.0, 1.0)) / 3.14159265);
    colour = vec4(textureLod(panorama, at, 0.0).rgb, 1.0);
}
