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

vec3 studio(vec3 d) {
    float height = d.z;
    vec3 light = mix(vec3(0.16, 0.152, 0.146), vec3(0.30, 0.305, 0.32), smoothstep(-0.5, 0.9, height));
    light += vec3(0.12, 0.113, 0.105) * exp(-pow((height + 0.06) * 5.0, 2.0));
    light = mix(light, vec3(0.13, 0.122, 0.116), smoothstep(0.02, -0.30, height));
    light += vec3(12.5, 12.0, 11.3) * panel(d, vec3(2.2, 2.9, 3.0), vec2(1.05, 1.45), 0.12, 0.10)
        * (0.8 + 0.2 * smoothstep(0.3, 1.0, height));
    light += vec3(7.0, 7.7, 8.8) * panel(d, vec3(-1.4, -3.6, 1.2), vec2(0.34, 1.6), 0.0, 0.06);
    light += vec3(5.6, 5.4, 5.2) * panel(d, vec3(3.4, -2.4, 1.5), vec2(0.8, 0.95), 0.0, 0.35);
    light += vec3(3.2, 3.2, 3.3) * panel(d, vec3(-3.0, 1.2, 3.6), vec2(1.3, 0.42), 0.0, 0.12);
    return light;
}

vec3 sky(vec3 d) {
    vec3 sun = normalize(vec3(-0.50, -0.62, 0.60));
    float near = max(dot(d, sun), 0.0);
    float height = max(d.z, 0.0);
    vec3 light = mix(vec3(1.05, 1.12, 1.20), vec3(0.16, 0.34, 0.78), pow(height, 0.45));
    light += vec3(1.0, 0.82, 0.55) * (0.35 * pow(near, 8.0) + 1.4 * pow(near, 90.0));
    float cloud = sin(5.0 * d.x + 2.0 * sin(4.0 * d.y)) * sin(6.0 * d.y + 1.5 * sin(3.0 * d.x + 1.0));
    cloud = smoothstep(0.25, 0.95, cloud) * smoothstep(0.12, 0.4, d.z);
    light = mix(light, vec3(1.35, 1.33, 1.32), 0.55 * cloud);
    vec3 ground = mix(vec3(0.34, 0.32, 0.27), vec3(0.21, 0.185, 0.15), smoothstep(0.0, 0.5, -d.z));
    return mix(ground, light, smoothstep(-0.012, 0.012, d.z));
}

// A room with two windows, seen from a table in it.
vec3 room(vec3 d) {
    vec3 low = vec3(-3.2, -2.6, -0.9), high = vec3(2.6, 2.8, 1.9);
    vec3 far = mix(low, high, step(0.0, d)) / (abs(d) + 1e-6) * sign(d);
    float away = min(far.x, min(far.y, far.z));
    vec3 at = d * away;
    vec3 light;
    if (away == far.z && d.z < 0.0) { // wooden floor
        float board = floor(at.y / 0.28);
        float shade = 0.85 + 0.15 * sin(board * 7.3) + 0.05 * sin(at.x * 9.0 + board * 3.0);
        light = vec3(0.26, 0.15, 0.085) * shade * (0.55 + 1.1 * smoothstep(-2.6, 2.6, at.y));
    } else if (away == far.z) { // ceiling
        light = vec3(0.62, 0.60, 0.56) * (0.55 + 0.45 * smoothstep(-2.6, 2.8, at.y));
    } else {
        light = vec3(0.46, 0.42, 0.36) * (0.6 + 0.35 * smoothstep(-2.6, 2.8, at.y));
        light *= 0.75 + 0.25 * smoothstep(-0.9, -0.3, at.z);
    }
    if (away == far.y && d.y > 0.0) { // windows
        float column = abs(abs(at.x + 0.3) - 1.25);
        vec2 pane = vec2(column, abs(at.z - 0.55));
        float open = smoothstep(0.80, 0.77, pane.x) * smoothstep(0.92, 0.89, pane.y);
        float frame = smoothstep(0.03, 0.045, abs(pane.x)) * smoothstep(0.03, 0.045, abs(at.z - 0.75));
        vec3 outside = mix(vec3(3.4, 3.9, 3.3), vec3(9.0, 10.0, 11.5), smoothstep(-0.3, 0.7, at.z));
        light = mix(light, outside, open * frame);
    }
    if (away == far.x && d.x > 0.0) { // a lamp beside, and a picture
        float lamp = smoothstep(0.34, 0.26, length(vec2(at.y + 1.3, (at.z - 0.35) * 1.1)));
        light = mix(light, vec3(5.5, 4.0, 2.4), lamp);
    }
    if (away == far.x && d.x < 0.0) {
        vec2 print = abs(vec2(at.y - 0.2, at.z - 0.5));
        light = mix(light, vec3(0.10, 0.11, 0.12), smoothstep(0.62, 0.6, print.x) * smoothstep(0.47, 0.45, print.y));
    }
    return light;
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
