#version 300 es
// The surface that a pixel shows, to be shaded once: triangles smaller than pixels would be shaded
// several times each.
precision highp float;

in vec3 worldPosition;
in vec3 worldNormal;
layout(location = 0) out vec4 position; // and 1; 0 where there is no surface
layout(location = 1) out vec4 normal;

void main() {
    position = vec4(worldPosition, 1.0);
    normal = vec4(worldNormal, 0.0);
}
