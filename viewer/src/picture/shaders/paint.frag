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

void main() {
    colour = vec4(0.0, 0.0, 0.0, 1.0);
    if (!gl_FrontFacing) {
        return; // materials do not reflect on their backs
    }
    vec3 normal = normalize(worldNormal);
    vec2 at = gl_FragCoord.xy * toShaded.zw + toShaded.xy - 0.5;
    ivec2 first = ivec2(floor(at)), last = textureSize(shaded, 0) - 1;
    vec2 share = at - vec2(first);
    vec4 sum = vec4(0.0);
    vec4 any = vec4(0.0);
    for (int reach = 0; reach < 2 && sum.a < 1e-3; reach++) {
        for (int y = -reach; y <= 1 + reach; y++) {
            for (int x = -reach; x <= 1 + reach; x++) {
                ivec2 texel = clamp(first + ivec2(x, y), ivec2(0), last);
                vec4 other = texelFetch(positions, texel, 0);
                if (other.w <= 0.0) {
                    continue;
                }
                vec2 apart = abs(share - vec2(x, y));
                float weight = max(1.0 - apart.x, 2e-3) * max(1.0 - apart.y, 2e-3);
                vec3 light = texelFetch(shaded, texel, 0).rgb;
                float aside = dot(other.xyz - worldPosition, normal) / near;
                float facing = max(dot(normal, normalize(texelFetch(normals, texel, 0).xyz)), 0.0);
                // By products, since each of the picture's pixels is here
                float facing2 = facing * facing, facing4 = facing2 * facing2;
                float facing8 = facing4 * facing4, facing24 = facing8 * facing8 * facing8;
                any += vec4(light, 1.0) * weight * (facing4 + 1e-4);
                sum += vec4(light, 1.0) * weight * facing24 * exp(-aside * aside);
            }
        }
    }
    if (sum.a >= 1e-3) {
        colour.rgb = sum.rgb / sum.a;
    } else if (any.a > 0.0) {
        colour.rgb = any.rgb / any.a;
    }
}
