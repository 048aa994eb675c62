#version 300 es
// The object as the camera sees it.
uniform mat4 projection; // world to clip space
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
out vec3 worldPosition;
out vec3 worldNormal;

void main() {
    worldPosition = position;
    worldNormal = normal;
    gl_Position = projection * vec4(position, 1.0);
}
