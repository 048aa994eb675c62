#version 300 es
// The object's triangles in the colours that were computed for coarse pixels: the mean of the nearest
// ones that show the same part of the surface (Kopf et al. 2007).
precision highp float;

uniform sampler2D shaded;
uniform sampler2D positions; // and what is above 0; -1 for a back, 0 where there is no surface
uniform sampler2D normals;
uniform vec4 toShaded; // from pixels to coarse ones: shift and factors
uniform float near; // distance from the tangent plane at which a surface is another

in vec3 worldPosition;
in vec3 worldNormal;
out vec4 colour;

vec4 same = vec4(0.0); // sum of colours and of weights, by the part of the surface
vec4 any = vec4(0.0); // whatever they show

// Add a coarse pixel; place: relative to the place of this pixel.
void add(ivec2 texel, vec2 place, vec3 normal) {
    texel = clamp(texel, ivec2(0), textureSize(shaded, 0) - 1);
    vec4 other = texelFetch(positions, texel, 0);
    if (other.w <= 0.0) {
        return;
    }
    vec2 close = max(1.0 - abs(place), 2e-3);
    vec4 light = vec4(texelFetch(shaded, texel, 0).rgb, 1.0) * close.x * close.y;
    float aside = dot(other.xyz - worldPosition, normal) / near;
    float facing = max(dot(normal, texelFetch(normals, texel, 0).xyz), 0.0);
    // By products, since each of the picture's pixels is here
    float facing2 = facing * facing, facing4 = facing2 * facing2;
    float facing8 = facing4 * facing4, facing24 = facing8 * facing8 * facing8;
    any += light * (facing4 + 1e-4);
    same += light * facing24 * exp(-aside * aside);
}

void main() {
    colour = vec4(0.0, 0.0, 0.0, 1.0);
    if (!gl_FrontFacing) {
        return; // materials do not reflect on their backs
    }
    vec3 normal = normalize(worldNormal);
    vec2 at = gl_FragCoord.xy * toShaded.zw + toShaded.xy - 0.5;
    ivec2 first = ivec2(floor(at));
    vec2 share = at - vec2(first);
    for (int k = 0; k < 4; k++) {
        ivec2 step_ = ivec2(k & 1, k >> 1);
        add(first + step_, vec2(step_) - share, normal);
    }
    if (same.a < 1e-3) {
        for (int k = 0; k < 16; k++) {
            ivec2 step_ = ivec2(k & 3, k >> 2) - 1;
            add(first + step_, vec2(step_) - share, normal);
        }
    }
    if (same.a >= 1e-3) {
        colour.rgb = same.rgb / same.a;
    } else if (any.a > 0.0) {
        colour.rgb = any.rgb / any.a;
    }
}
