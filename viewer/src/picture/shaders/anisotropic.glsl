// The parts of object.frag for anisotropic materials: tables by the cosine and the azimuth of the view,
// in the frame of the material's tangent.
uniform int azimuths; // the table's columns are the cosines of one azimuth after the other
uniform vec3 lobe[7]; // numbers of the material's lobe
uniform vec3 stretches; // of the channels
uniform float rotation; // of the material's tangent [radians]

#include basis.glsl

// The frame along the tangent, mirrored so that the view is in the first quadrant.
Frame tangentFrame(Frame frame, ivec2 pixel) {
    vec4 stored = texelFetch(normals, pixel, 0);
    mat3 axes = basis(stored.xyz);
    float angle = stored.w + rotation;
    vec3 tangent = turned(cos(angle) * axes[0] + sin(angle) * axes[1]);
    tangent = normalize(tangent - dot(tangent, frame.z) * frame.z);
    vec3 bitangent = cross(frame.z, tangent);
    vec3 view = frame.view.x * frame.x + frame.view.z * frame.z;
    vec2 flat_ = vec2(dot(view, tangent), dot(view, bitangent));
    vec2 side = vec2(flat_.x < 0.0 ? -1.0 : 1.0, flat_.y < 0.0 ? -1.0 : 1.0);
    return Frame(side.x * tangent, side.y * bitangent, frame.z, vec3(abs(flat_), frame.view.z));
}

vec3 reflected(Frame frame) {
    int columns = textureSize(table, 0).x / azimuths;
    float column = clamp(frame.view.z * float(columns) - 0.5, 0.0, float(columns) - 1.0);
    float row = atan(frame.view.y, frame.view.x + 1e-9) / 1.5707963 * float(azimuths - 1);
    int left = int(column), below = min(int(row), azimuths - 2);
    int right = min(left + 1, columns - 1);
    float across = column - float(left), up = clamp(row - float(below), 0.0, 1.0);
    ivec4 places = ivec4(left, right, left, right) + ivec2(below, below + 1).xxyy * columns;
    vec4 shares = vec4((1.0 - across) * (1.0 - up), across * (1.0 - up), (1.0 - across) * up, across * up);
    int last = textureSize(table, 0).y - 2;
    vec3 total = vec3(0.0), albedo = vec3(0.0);
    for (int k = 0; k < 4; k++) {
        total += float(samples) * shares[k] * texelFetch(table, ivec2(places[k], last), 0).rgb;
        albedo += shares[k] * texelFetch(table, ivec2(places[k], last + 1), 0).rgb;
    }
    vec3 even = textureLod(irradiance, bent, 0.0).rgb;
    own = albedo * meanLight(frame.z);
    vec3 sum = total * mix(own, even, openness);
    for (int i = 0; i < samples; i++) {
        vec4 facets[4], between = vec4(0.0);
        vec3 weights[4], weight = vec3(0.0);
        bool isOne = true;
        for (int k = 0; k < 4; k++) {
            facets[k] = texelFetch(table, ivec2(places[k], 2 * i), 0);
            weights[k] = texelFetch(table, ivec2(places[k], 2 * i + 1), 0).rgb;
            isOne = isOne && dot(facets[0].xyz, facets[k].xyz) > 0.97
                && abs(facets[0].w - facets[k].w) < 2.0;
            between += shares[k] * facets[k];
            weight += shares[k] * weights[k];
        }
        total += weight;
        if (isOne) {
            sum += weight * mirrored(frame, between);
        } else { // of different lobes of the proposal
            for (int k = 0; k < 4; k++) {
                sum += shares[k] * weights[k] * mirrored(frame, facets[k]);
            }
        }
    }
    return max(sum, 0.0) * albedo / max(total, 1e-6);
}

vec3 f(Frame frame, vec3 light) {
    vec3 local = vec3(dot(light, frame.x), dot(light, frame.y), dot(light, frame.z));
    vec3 wide[7] = lobe; // over the normals of the pixel
    for (int k = 0; k < 7; k += 6) wide[k] = sqrt(lobe[k] * lobe[k] + 0.25 * spread * spread);
    vec3 one = material_f2(wide, stretches.r, rest, frame.view, local);
    if (stretches.r == stretches.g && stretches.r == stretches.b) return one;
    return vec3(one.r, material_f2(wide, stretches.g, rest, frame.view, local).g,
                material_f2(wide, stretches.b, rest, frame.view, local).b);
}
