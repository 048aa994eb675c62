#version 300 es
// Three environments by formula: a studio, a sky and a room. Radiance without the bright lights.
precision highp float;

uniform mat3 face;
uniform bool isPanorama; // place is that in a panorama as Mitsuba turns it, not that on a face
uniform int which;

in vec2 place;
out vec4 colour;

const float PI = 3.14159265;

// 1 inside a rectangle around `centre` as seen from the origin, with soft edges.
float panel(vec3 direction, vec3 centre, vec2 half_, float tilt, float soft) {
    vec3 axis = normalize(centre);
    vec3 right = normalize(cross(vec3(0.0, 0.0, 1.0), axis));
    vec3 up = cross(axis, right);
    float ahead = dot(direction, axis);
    if (ahead <= 0.0) {
        return 0.0;
    }
    vec2 at = vec2(dot(direction, right), dot(direction, up)) * length(centre) / ahead;
    at = mat2(cos(tilt), sin(tilt), -sin(tilt), cos(tilt)) * at;
    vec2 inside = smoothstep(half_ + soft, half_ - soft, abs(at));
    return inside.x * inside.y;
}

// A black studio: a large soft key in front, brighter at its lower edge, a fill beside the camera, one
// above, strips behind at both sides, and a pool of light on the floor. The black beside them shows the
// contours of metals.
vec3 studio(vec3 d) {
    vec3 light = mix(vec3(0.04), vec3(0.02), smoothstep(0.0, 0.7, d.z));
    float key = panel(d, vec3(-0.7, -3.0, 1.2), vec2(1.9, 1.5), 0.0, 0.3);
    light += vec3(15.0, 14.9, 14.6) * key * mix(1.0, 0.65, smoothstep(0.1, 0.8, d.z));
    light += vec3(1.5, 1.52, 1.56) * panel(d, vec3(2.2, -2.6, 0.9), vec2(0.8, 1.3), 0.0, 0.5);
    light += vec3(3.0, 3.0, 3.0) * panel(d, vec3(0.3, 0.8, 3.2), vec2(1.5, 0.7), 0.0, 0.4);
    light += vec3(6.2, 6.4, 6.8) * panel(d, vec3(3.4, 1.6, 1.3), vec2(0.4, 1.8), 0.0, 0.2);
    light += vec3(4.6, 4.5, 4.3) * panel(d, vec3(-3.4, 1.5, 1.1), vec2(0.3, 1.7), 0.0, 0.2);
    vec2 at = d.xy / max(-d.z, 1e-3) + vec2(0.1, 0.8);
    vec3 floor_ = vec3(0.03) + vec3(1.25, 1.24, 1.22) / (1.0 + 0.7 * dot(at, at));
    return mix(light, floor_, smoothstep(0.0, -0.08, d.z));
}

// Smooth noise in [0, 1]: a random number at each corner of a grid (Perlin 1985, by values).
float noise(vec2 at) {
    vec2 cell = floor(at), part = smoothstep(0.0, 1.0, at - cell);
    vec4 corners;
    for (int k = 0; k < 4; k++) {
        vec2 corner = cell + vec2(float(k % 2), float(k / 2));
        corners[k] = fract(52.9829189 * fract(dot(corner, vec2(0.06711056, 0.00583715))));
    }
    vec2 rows = mix(corners.xz, corners.yw, part.x);
    return mix(rows.x, rows.y, part.y);
}

// Octaves of noise.
float cloudy(vec2 at) {
    float sum = 0.0, share = 0.5;
    for (int octave = 0; octave < 6; octave++) {
        sum += share * noise(at);
        at = mat2(1.6, 1.2, -1.2, 1.6) * at + 7.3;
        share *= 0.5;
    }
    return sum;
}

// A summer's sky with clouds over trees and a meadow, seen from a terrace.
vec3 sky(vec3 d) {
    vec3 sun = normalize(vec3(-0.50, -0.62, 0.60));
    float near = max(dot(d, sun), 0.0);
    float height = max(d.z, 0.0);
    vec3 light = mix(vec3(0.98, 1.06, 1.14), vec3(0.13, 0.29, 0.72), pow(height, 0.42));
    light += vec3(1.0, 0.85, 0.62) * (0.30 * pow(near, 8.0) + 1.6 * pow(near, 90.0));
    vec2 over = 1.3 * d.xy / (height + 0.22);
    float thick = cloudy(over);
    float cloud = smoothstep(0.46, 0.66, thick) * smoothstep(0.02, 0.2, d.z);
    float lit = smoothstep(0.10, -0.10, cloudy(over + 0.25 * sun.xy) - thick); // thinner to the sun
    light = mix(light, mix(vec3(0.66, 0.70, 0.78), vec3(2.0, 1.92, 1.8), lit), cloud);
    float way = atan(d.y, d.x);
    vec2 around = vec2(cos(way), sin(way));
    float trees = 0.035 + 0.09 * cloudy(4.0 * around + 3.0) + 0.02 * noise(60.0 * around);
    vec3 leaves = mix(vec3(0.05, 0.075, 0.035), vec3(0.13, 0.16, 0.06), noise(25.0 * vec2(way, 3.0 * d.z)));
    light = mix(light, leaves, smoothstep(0.004, -0.004, d.z - trees));
    vec2 at = 1.7 * d.xy / max(-d.z, 1e-3);
    vec3 ground = mix(vec3(0.13, 0.17, 0.055), vec3(0.22, 0.26, 0.10), noise(0.5 * at));
    vec2 joint = abs(fract(at / 1.4) - 0.5) * 1.4;
    float joints = smoothstep(0.66, 0.69, max(joint.x, joint.y)) * smoothstep(-0.15, -0.5, d.z);
    float stone = 0.85 + 0.3 * noise(floor(at / 1.4) + 0.5) * (0.7 + 0.3 * noise(9.0 * at));
    vec3 terrace = vec3(0.50, 0.47, 0.42) * stone * (1.0 - 0.5 * joints);
    float edge = max(abs(at.x), abs(at.y));
    ground = mix(ground, terrace, smoothstep(5.65, 5.55, edge));
    return mix(ground, light, smoothstep(-0.004, 0.004, d.z));
}

// A room with windows behind and on the left, seen from a table in it.
vec3 room(vec3 d) {
    vec3 low = vec3(-3.2, -2.6, -0.9), high = vec3(2.6, 2.8, 1.9);
    vec3 far = mix(low, high, step(0.0, d)) / (abs(d) + 1e-6) * sign(d);
    float away = min(far.x, min(far.y, far.z));
    vec3 at = d * away;
    vec3 light;
    if (away == far.z && d.z < 0.0) { // wooden floor
        float board = floor(at.y / 0.28);
        float shade = 0.85 + 0.15 * sin(board * 7.3) + 0.05 * sin(at.x * 9.0 + board * 3.0);
        light = vec3(0.40, 0.26, 0.165) * shade * (0.7 + 0.6 * smoothstep(-2.6, 2.6, at.y));
    } else if (away == far.z) { // ceiling
        light = vec3(0.95, 0.92, 0.87) * (0.7 + 0.3 * smoothstep(-2.6, 2.8, at.y));
    } else {
        light = vec3(0.58, 0.53, 0.465) * (0.8 + 0.2 * smoothstep(-2.6, 2.8, at.y));
        light *= 0.7 + 0.3 * smoothstep(-0.9, -0.3, at.z);
        light = mix(light, vec3(0.34, 0.31, 0.28), smoothstep(-0.72, -0.735, at.z)); // skirting
    }
    if (away == far.y && d.y > 0.0) { // windows
        float column = abs(abs(at.x + 0.3) - 1.15);
        float open = smoothstep(0.62, 0.59, column) * smoothstep(0.92, 0.89, abs(at.z - 0.55));
        float frame = smoothstep(0.03, 0.045, column) * smoothstep(0.03, 0.045, abs(at.z - 0.75));
        float trees = 0.35 + 0.9 * cloudy(vec2(1.7 * at.x, 0.0));
        vec3 leaves = mix(vec3(0.35, 0.5, 0.2), vec3(0.85, 1.0, 0.5), noise(vec2(14.0 * at.x, 14.0 * at.z)));
        vec3 outside = mix(leaves, vec3(3.0, 3.4, 3.9), smoothstep(-0.06, 0.06, at.z - trees));
        light = mix(light, outside, open * frame);
        float curtain = smoothstep(0.62, 0.66, column) * smoothstep(0.86, 0.82, column);
        vec3 cloth = vec3(1.05, 1.0, 0.9) * (0.75 + 0.25 * sin(55.0 * at.x));
        light = mix(light, cloth, curtain);
    }
    if (away == far.x && d.x > 0.0) { // a lamp beside
        float lamp = smoothstep(0.34, 0.26, length(vec2(at.y + 1.3, (at.z - 0.35) * 1.1)));
        light = mix(light, vec3(5.5, 4.0, 2.4), lamp);
    }
    if (away == far.x && d.x < 0.0) { // a wide window with four panes
        vec2 pane = abs(vec2(at.y + 0.7, at.z - 0.65));
        float open = smoothstep(1.62, 1.55, pane.x) * smoothstep(1.02, 0.95, pane.y);
        float frame = smoothstep(0.03, 0.06, pane.x) * smoothstep(0.03, 0.06, pane.y);
        light = mix(light, vec3(7.6, 8.0, 8.6), open * frame);
    }
    return 2.0 * light; // as bright on a white object as the sky
}

void main() {
    vec3 direction = normalize(face * vec3(place, 1.0));
    if (isPanorama) {
        float phi = PI * (place.x + 1.0), theta = 0.5 * PI * (place.y + 1.0);
        direction = vec3(sin(theta) * sin(phi), sin(theta) * cos(phi), cos(theta));
    }
    vec3 light = which == 0 ? studio(direction) : which == 1 ? sky(direction) : room(direction);
    colour = vec4(light, 1.0);
}
