#version 300 es
// The share of its light that each place of the ground has beside the object: without the directions in
// which the object hides it.
precision highp float;
precision highp sampler2DArray;

uniform sampler2D lit; // light of the directions, see hemisphere.frag
uniform sampler2DArray shadows; // of a direction each, see core/occlusion.ts
uniform int axes;

out vec4 colour;

void main() {
    vec3 open = vec3(0.0), all = vec3(0.0);
    for (int axis = 0; axis < axes; axis++) {
        vec3 light = texelFetch(lit, ivec2(axis, 0), 0).rgb;
        all += light;
        open += light * (1.0 - texelFetch(shadows, ivec3(gl_FragCoord.xy, axis), 0).r);
    }
    colour = vec4(axes == 0 ? vec3(1.0) : open / max(all, 1e-6), 1.0);
}
