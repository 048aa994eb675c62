#version 300 es
// The object as the camera sees it.
uniform mat4 projection; // world to clip space
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 coordinates;
layout(location = 3) in vec3 tangent;
layout(location = 4) in vec4 bent; // bent normal, 0 before it is known, and openness
out vec3 worldPosition;
out vec3 worldNormal;
out vec3 worldTangent;
out vec2 uv;
out vec4 opening;

void main() {
    worldPosition = position;
    worldNormal = normal;
    worldTangent = tangent;
    uv = coordinates;
    opening = vec4(bent.xyz == vec3(0.0) ? normal : bent.xyz, max(bent.w, 0.02));
    gl_Position = projection * vec4(position, 1.0);
}
