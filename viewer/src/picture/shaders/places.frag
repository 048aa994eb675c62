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

// A light cyclorama, a large soft key above on the left, strips at both sides for the edges, and cards
// low in front, which what faces the floor reflects.
vec3 studio(vec3 d) {
    vec3 light = mix(vec3(0.52, 0.515, 0.505), vec3(0.34, 0.345, 0.36), smoothstep(0.0, 0.9, d.z));
    light = mix(light, vec3(0.24, 0.235, 0.228), smoothstep(-0.05, -0.60, d.z));
    light += vec3(9.6, 9.35, 9.0) * panel(d, vec3(-2.4, -1.6, 3.0), vec2(1.85, 1.45), 0.0, 0.45);
    light += vec3(6.2, 6.4, 6.8) * panel(d, vec3(3.6, 1.0, 1.4), vec2(0.55, 1.7), 0.0, 0.25);
    light += vec3(4.6, 4.5, 4.3) * panel(d, vec3(-3.7, 0.9, 1.0), vec2(0.42, 1.7), 0.0, 0.22);
    light += vec3(2.2, 2.2, 2.25) * panel(d, vec3(2.4, -3.4, 1.2), vec2(1.5, 1.5), 0.0, 0.7);
    light += vec3(1.9, 1.87, 1.82) * panel(d, vec3(-2.6, -2.4, -1.7), vec2(0.8, 1.5), 0.0, 0.6);
    light += vec3(1.5, 1.53, 1.58) * panel(d, vec3(3.0, -1.6, -1.5), vec2(0.45, 1.4), 0.0, 0.4);
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
    vec3 ground = mix(vec3(0.46, 0.44, 0.40), vec3(0.27, 0.255, 0.23), smoothstep(0.0, 0.5, -d.z));
    return mix(ground, light, smoothstep(-0.012, 0.012, d.z));
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
        light = vec3(0.72, 0.68, 0.62) * (0.8 + 0.2 * smoothstep(-2.6, 2.8, at.y));
        light *= 0.75 + 0.25 * smoothstep(-0.9, -0.3, at.z);
    }
    if (away == far.y && d.y > 0.0) { // windows
        float column = abs(abs(at.x + 0.3) - 1.25);
        vec2 pane = vec2(column, abs(at.z - 0.55));
        float open = smoothstep(0.80, 0.77, pane.x) * smoothstep(0.92, 0.89, pane.y);
        float frame = smoothstep(0.03, 0.045, abs(pane.x)) * smoothstep(0.03, 0.045, abs(at.z - 0.75));
        vec3 outside = mix(vec3(2.0, 2.2, 1.9), vec3(4.2, 4.6, 5.2), smoothstep(-0.3, 0.7, at.z));
        light = mix(light, outside, open * frame);
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
