// A frame of which z is a normal (Duff et al. 2017).
mat3 basis(vec3 z) {
    float side = z.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (side + z.z), b = z.x * z.y * a;
    vec3 x = vec3(1.0 + side * z.x * z.x * a, side * b, -side * z.x);
    return mat3(x, vec3(b, side + z.y * z.y * a, -z.y), z);
}
