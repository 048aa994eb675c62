#version 300 es
// The object as the camera sees it.
uniform mat4 projection; // world to clip space
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 coordinates;
layout(location = 3) in vec3 tangent;
out vec3 worldPosition;
out vec3 worldNormal;
out vec3 worldTangent;
out vec2 uv;

void main() {
    worldPosition = position;
    worldNormal = normal;
    worldTangent = tangent;
    uv = coordinates;
    gl_Position = projection * vec4(position, 1.0);
}
