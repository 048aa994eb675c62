// What a pixel shows of the object, and the light there.
const int MOST_LIGHTS = 4;

uniform vec3 eye;
uniform vec2 turn; // cosine and sine of the environment's rotation about z
uniform int samples;
uniform float density; // directions taken so far, for the level of detail
uniform float footprint; // share of a pixel that a frame shows: the mean of more frames needs less
uniform samplerCube environment;
uniform float side; // texels along a side of the environment
uniform vec3 lightDirections[MOST_LIGHTS];
uniform vec3 lightPowers[MOST_LIGHTS]; // irradiance at normal incidence
uniform int lights;

uniform float fade; // height at which the image in the ground fades; 0: it is none
uniform samplerCube irradiance; // over pi, by the normal
uniform sampler2D positions; // of the surface that each pixel shows, see surface.frag
uniform sampler2D normals;
uniform sampler2D openings;

// A pixel's frame, in which z is the normal, and its direction to the eye.
struct Frame {
    vec3 x;
    vec3 y;
    vec3 z;
    vec3 view;
};

vec3 turned(vec3 v) {
    return vec3(turn.x * v.x + turn.y * v.y, turn.x * v.y - turn.y * v.x, v.z);
}

vec3 bent; // the mean direction of the light that the object does not hide
float edge; // cosine of the angle about it beyond which light is hidden
float spread; // how far the normal turns across what is shown
float openness; // share of the light that the object does not hide, by the cosine
vec3 own; // light of the object itself where it hides the environment

// The frame where a pixel shows a position; position: as of surface.frag.
Frame frameAt(ivec2 pixel, vec4 position) {
    float bend = footprint * (position.w - 1.0);
    spread = bend * bend / (bend + 0.15); // next to nothing where the surface hardly bends
    vec3 normal = turned(texelFetch(normals, pixel, 0).xyz);
    vec3 view = turned(normalize(eye - position.xyz));
    float cosine = dot(normal, view);
    // Smooth normals may turn away at the silhouette, where a coarse pixel shows the mean of many.
    float least = max(0.5 * cosine + 0.25 * spread, 0.004);
    if (cosine < least) {
        normal = normalize(normal + (least - cosine) * view);
        cosine = max(dot(normal, view), 0.004);
    }
    vec3 across = view - cosine * normal;
    float size = length(across);
    vec3 tangent = size > 1e-4
        ? across / size
        : normalize(cross(normal, abs(normal.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
    vec4 opening = texelFetch(openings, pixel, 0);
    bent = turned(opening.xyz);
    openness = opening.w;
    // The cosine at the edge of a cone of the openness (Oat and Sander 2007)
    edge = sqrt(max(1.0 - openness / clamp(dot(normal, bent), 0.02, 1.0), 0.0));
    return Frame(tangent, cross(normal, tangent), normal, vec3(size, 0.0, cosine));
}

// The level whose texels are as large as the share of one direction, or as what the pixel reflects:
// thin rims would else be dashed in coarse frames.
float level(vec3 direction, float logPdf) {
    vec3 size = abs(direction);
    float major = max(size.x, max(size.y, size.z));
    float solidAngle = 4.0 * major * major * major / (side * side); // of a texel
    float share = max(exp2(-logPdf) / density, 2.0 * spread * spread);
    return 0.5 * log2(share / solidAngle) + 0.5;
}

// Light on the parts that hide the environment: of all directions, as far as it gets there.
vec3 meanLight(vec3 normal) {
    vec3 both = textureLod(irradiance, normal, 0.0).rgb + textureLod(irradiance, -normal, 0.0).rgb;
    return 0.5 * openness * both;
}

// The share of a direction that is open: of a cone about the bent normal.
float open(vec3 light) {
    float soft = min(edge, 0.25) + 1e-4;
    return openness == 1.0 ? 1.0 : smoothstep(edge - soft, edge + soft, dot(light, bent));
}

// Light from a direction in a frame, drawn by a density.
vec3 incoming(Frame frame, vec3 local, float logPdf) {
    vec3 light = local.x * frame.x + local.y * frame.y + local.z * frame.z;
    return mix(own, textureLod(environment, light, level(light, logPdf)).rgb, open(light));
}

// Light of a surface at a height, times its opacity. Coarse images have no highlights.
vec4 faded(vec3 light, float height) {
    return fade > 0.0 ? vec4(min(light, 2.0), 1.0) * exp(-height / fade) : vec4(light, 1.0);
}
