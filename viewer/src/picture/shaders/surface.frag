#version 300 es
// The surface that a pixel shows, to be shaded once: triangles smaller than pixels would be shaded
// several times each.
precision highp float;

uniform mat3x2 toTexture; // from uv, where a texture of codes is shown

in vec3 worldPosition;
in vec3 worldNormal;
in vec3 worldTangent;
in vec2 uv;
in vec4 opening;
layout(location = 0) out vec4 position; // and 1 + the normal's turn across a pixel; -1 for a back, 0: none
layout(location = 1) out vec4 normal; // and the tangent's angle in its `basis`
layout(location = 2) out vec4 at; // in the texture
layout(location = 3) out vec4 open; // bent normal and openness

#include basis.glsl

void main() {
    vec3 unit = normalize(worldNormal);
    float across = max(length(dFdx(unit)), length(dFdy(unit)));
    position = vec4(worldPosition, gl_FrontFacing ? 1.0 + min(across, 1.5) : -1.0);
    open = vec4(normalize(opening.xyz), opening.w);
    mat3 frame = basis(unit);
    normal = vec4(unit, atan(dot(worldTangent, frame[1]), dot(worldTangent, frame[0])));
    at = vec4(toTexture * vec3(uv, 1.0), 0.0, 0.0);
}
