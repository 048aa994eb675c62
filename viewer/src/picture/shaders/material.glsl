// Written by `python viewer/formulas.py` from the formulas of Python. Do not edit it.

// The share of light that passes the topmost interface, for a direction.
float material_transmittance(float spread, float factor, float eta, float k, float cosine) {
    if (eta >= 1.0) { return 1.0; }
    float index = (k > 0.0 ? 1.0 : eta);
    float thinner = max(min(index, 1.0), 0.001);
    float above = max(cosine, 0.005);
    float critical2 = max(1.0 - thinner * thinner, 0.0);
    float beyond = above - sqrt(critical2);
    float root_beyond = sqrt(beyond * beyond + spread);
    float high_beyond = 0.5 * (abs(beyond) + root_beyond);
    float ramp_beyond = (beyond > 0.0 ? high_beyond : 0.25 * spread / high_beyond);
    float root_all = sqrt(above * above + spread);
    float high_all = 0.5 * (abs(above) + root_all);
    float ramp_all = (above > 0.0 ? high_all : 0.25 * spread / high_all);
    float per_index = 1.0 / (thinner * thinner);
    float straight2 = (above * above - critical2) * per_index;
    float blur2 = 4.0 * spread * critical2 * per_index * per_index + 1.0e-12;
    float root_inside = sqrt(straight2 * straight2 + blur2);
    float high_inside = 0.5 * (abs(straight2) + root_inside);
    float ramp_inside = (straight2 > 0.0 ? high_inside : 0.25 * blur2 / high_inside);
    float inside = sqrt(min(ramp_inside, 1.0));
    float across = above + thinner * inside;
    float along = thinner * above + inside;
    float transmittance = 2.0 * thinner * above * inside * (1.0 / (across * across) + 1.0 / (along *
        along)) * (ramp_beyond * root_all) / (root_beyond * ramp_all);
    return (1.0 > index ? 1.0 - factor * (1.0 - transmittance) : 1.0);
}
// f [1/sr] of a material of one GGX width by its lobe and the table of its rest.
vec3 material_f(vec3 numbers[6], highp sampler3D table, vec3 wi, vec3 wo) {
    // The lobe: D G / (4 cos_i cos_o) of GGX with the separable Smith term, where
    // wi + wo stands for the half vector.
    float above_i = max(wi.z, 0.0);
    float above_o = max(wo.z, 0.0);
    float half_x = wi.x + wo.x;
    float half_y = wi.y + wo.y;
    float half_z = above_i + above_o;
    float half_xy2 = half_x * half_x + half_y * half_y;
    float half_z2 = half_z * half_z;
    vec3 alpha2 = numbers[0] * numbers[0];
    vec3 remaining = 1.0 - alpha2;
    vec3 ratio = (half_xy2 + half_z2) / (half_xy2 + alpha2 * half_z2 + 1.0e-18);
    vec3 masking_i = above_i + sqrt(alpha2 + remaining * (above_i * above_i));
    vec3 masking_o = above_o + sqrt(alpha2 + remaining * (above_o * above_o));
    vec3 lobe_shape = alpha2 / 3.1415927 * (ratio * ratio) / (masking_i * masking_o);
    float cos_facet = min(0.5 * sqrt(half_x * half_x + half_y * half_y + half_z * half_z), 1.0);
    // Its Fresnel term at the cosine to the facet.
    float away_facet = 1.0 - cos_facet;
    float away2_facet = away_facet * away_facet;
    float fifth_facet = away2_facet * away2_facet * away_facet;
    float cos2_facet = cos_facet * cos_facet;
    float sin2_facet = 1.0 - cos2_facet;
    vec3 difference_facet = (numbers[4] - 1.0) * (numbers[4] + 1.0) - numbers[5] * numbers[5] +
        cos2_facet;
    vec3 size_facet = sqrt(difference_facet * difference_facet + 4.0 * (numbers[4] * numbers[4]) *
        (numbers[5] * numbers[5]));
    vec3 root_facet = sqrt(0.5 * max(size_facet + difference_facet, vec3(0.0, 0.0, 0.0)));
    vec3 imaginary2_facet = 0.5 * max(size_facet - difference_facet, vec3(0.0, 0.0, 0.0));
    vec3 less_facet = root_facet - cos_facet;
    vec3 more_facet = root_facet + cos_facet;
    vec3 across_facet = (less_facet * less_facet + imaginary2_facet) / (more_facet * more_facet +
        imaginary2_facet);
    vec3 product_facet = root_facet * cos_facet;
    vec3 far_facet = imaginary2_facet * cos2_facet + 1.0e-12;
    vec3 third_facet = product_facet - sin2_facet;
    vec3 fourth_facet = product_facet + sin2_facet;
    vec3 parallel_facet = (third_facet * third_facet + far_facet) / (fourth_facet * fourth_facet +
        far_facet);
    vec3 fresnel_facet = numbers[1] * (1.0 - fifth_facet) + numbers[2] * fifth_facet + numbers[3] *
        (0.5 * across_facet * (1.0 + parallel_facet));
    vec3 lobe = lobe_shape * fresnel_facet;
    // The table's coordinates, from the first node to the last.
    vec3 both = wi + wo;
    vec3 apart = wi - wo;
    float z2 = max(both.z * both.z, 1.0e-18);
    float squared = both.x * both.x + both.y * both.y + z2;
    float cos_d = min(0.5 * sqrt(squared), 1.0);
    float across = both.x * both.x + both.y * both.y;
    float node0 = clamp((log(across / z2 + 1.0e-5) - (-11.512925)) * 0.05428681, 0.0, 1.0) * 95.0;
    float node1 = clamp(sqrt(1.0 - cos_d), 0.0, 1.0) * 31.0;
    float node2 = clamp(1.0 - sqrt(1.0 - min(0.5 * abs(apart.z) / max(min(0.5 * both.z, sqrt(across
        / squared * ((1.0 - cos_d) * (1.0 + cos_d)))), 1.0e-9), 1.0)), 0.0, 1.0) * 7.0;
    float place0 = (node0 + 0.5) * 0.010416667;
    float place1 = (node1 + 0.5) * 0.03125;
    float first = node2 + 0.5;
    vec3 texel0_0_place = vec3(first * 0.125, place1, place0);
    vec4 texel0_0 = textureLod(table, texel0_0_place, 0.0);
    vec3 rest = exp(texel0_0.rgb);
    vec3 spread2_passed_i = max(numbers[0] * numbers[0] * (1.0 - wi.z * wi.z), vec3(1.0e-9, 1.0e-9,
        1.0e-9));
    vec3 passed_i = vec3(material_transmittance(spread2_passed_i.x, numbers[3].x, numbers[4].x,
        numbers[5].x, wi.z), material_transmittance(spread2_passed_i.y, numbers[3].y, numbers[4].y,
        numbers[5].y, wi.z), material_transmittance(spread2_passed_i.z, numbers[3].z, numbers[4].z,
        numbers[5].z, wi.z));
    vec3 spread2_passed_o = max(numbers[0] * numbers[0] * (1.0 - wo.z * wo.z), vec3(1.0e-9, 1.0e-9,
        1.0e-9));
    vec3 passed_o = vec3(material_transmittance(spread2_passed_o.x, numbers[3].x, numbers[4].x,
        numbers[5].x, wo.z), material_transmittance(spread2_passed_o.y, numbers[3].y, numbers[4].y,
        numbers[5].y, wo.z), material_transmittance(spread2_passed_o.z, numbers[3].z, numbers[4].z,
        numbers[5].z, wo.z));
    return lobe + passed_i * passed_o * rest;
}
// f [1/sr] of a material of two GGX widths by its lobe and the table of its rest.
vec3 material_f2(vec3 numbers[7], float stretch, highp sampler3D table, vec3 wi, vec3 wo) {
    // The lobe: D G / (4 cos_i cos_o) of GGX with the separable Smith term, where
    // wi + wo stands for the half vector.
    float above_i = max(wi.z, 0.0);
    float above_o = max(wo.z, 0.0);
    float half_x = wi.x + wo.x;
    float half_y = wi.y + wo.y;
    float half_z = above_i + above_o;
    float half_xy2 = half_x * half_x + half_y * half_y;
    float half_z2 = half_z * half_z;
    vec3 alpha2 = numbers[0] * numbers[6];
    vec3 u_over_v = numbers[0] / numbers[6];
    vec3 v_over_u = numbers[6] / numbers[0];
    vec3 ratio = (half_xy2 + half_z2) / (half_x * half_x * v_over_u + half_y * half_y * u_over_v +
        alpha2 * half_z2 + 1.0e-18);
    vec3 masking_i = above_i + sqrt(alpha2 * (wi.x * wi.x * u_over_v + wi.y * wi.y * v_over_u) +
        above_i * above_i);
    vec3 masking_o = above_o + sqrt(alpha2 * (wo.x * wo.x * u_over_v + wo.y * wo.y * v_over_u) +
        above_o * above_o);
    vec3 lobe_shape = alpha2 / 3.1415927 * (ratio * ratio) / (masking_i * masking_o);
    float cos_facet = min(0.5 * sqrt(half_x * half_x + half_y * half_y + half_z * half_z), 1.0);
    // Its Fresnel term at the cosine to the facet.
    float away_facet = 1.0 - cos_facet;
    float away2_facet = away_facet * away_facet;
    float fifth_facet = away2_facet * away2_facet * away_facet;
    float cos2_facet = cos_facet * cos_facet;
    float sin2_facet = 1.0 - cos2_facet;
    vec3 difference_facet = (numbers[4] - 1.0) * (numbers[4] + 1.0) - numbers[5] * numbers[5] +
        cos2_facet;
    vec3 size_facet = sqrt(difference_facet * difference_facet + 4.0 * (numbers[4] * numbers[4]) *
        (numbers[5] * numbers[5]));
    vec3 root_facet = sqrt(0.5 * max(size_facet + difference_facet, vec3(0.0, 0.0, 0.0)));
    vec3 imaginary2_facet = 0.5 * max(size_facet - difference_facet, vec3(0.0, 0.0, 0.0));
    vec3 less_facet = root_facet - cos_facet;
    vec3 more_facet = root_facet + cos_facet;
    vec3 across_facet = (less_facet * less_facet + imaginary2_facet) / (more_facet * more_facet +
        imaginary2_facet);
    vec3 product_facet = root_facet * cos_facet;
    vec3 far_facet = imaginary2_facet * cos2_facet + 1.0e-12;
    vec3 third_facet = product_facet - sin2_facet;
    vec3 fourth_facet = product_facet + sin2_facet;
    vec3 parallel_facet = (third_facet * third_facet + far_facet) / (fourth_facet * fourth_facet +
        far_facet);
    vec3 fresnel_facet = numbers[1] * (1.0 - fifth_facet) + numbers[2] * fifth_facet + numbers[3] *
        (0.5 * across_facet * (1.0 + parallel_facet));
    vec3 lobe = lobe_shape * fresnel_facet;
    // The table's coordinates, from the first node to the last.
    vec3 both = wi + wo;
    vec3 apart = wi - wo;
    float stretched_z2 = max(both.z * both.z, 1.0e-18);
    float stretched_across = both.x * both.x * (stretch * stretch) + both.y * both.y / (stretch *
        stretch);
    float apart_across = apart.x * apart.x + apart.y * apart.y;
    float stretched_size = stretched_across + 1.0e-5 * stretched_z2;
    float apart_size = apart_across + 4.0e-5;
    float cos_2_psi = (both.x * both.x * (stretch * stretch) - both.y * both.y / (stretch *
        stretch)) / stretched_size;
    float cos_2_p = (apart.x * apart.x - apart.y * apart.y) / apart_size;
    float psi_seen = stretched_across / stretched_size;
    float p_seen = apart_across / apart_size;
    float z2 = max(both.z * both.z, 1.0e-18);
    float squared = both.x * both.x + both.y * both.y + z2;
    float cos_d = min(0.5 * sqrt(squared), 1.0);
    float across = both.x * both.x + both.y * both.y;
    float factor2 = 2.0 * cos_2_psi * cos_2_psi - psi_seen * psi_seen;
    float factor3 = 2.0 * cos_2_p * cos_2_p - p_seen * p_seen;
    float factor4 = cos_2_psi * cos_2_p;
    float node0 = clamp((log(stretched_across / stretched_z2 + 1.0e-5) - (-11.512925)) * 0.05428681,
        0.0, 1.0) * 95.0;
    float node1 = clamp(sqrt(1.0 - cos_d), 0.0, 1.0) * 31.0;
    float node2 = clamp(1.0 - sqrt(1.0 - min(0.5 * abs(apart.z) / max(min(0.5 * both.z, sqrt(across
        / squared * ((1.0 - cos_d) * (1.0 + cos_d)))), 1.0e-9), 1.0)), 0.0, 1.0) * 7.0;
    float place0 = (node0 + 0.5) * 0.010416667;
    float place1 = (node1 + 0.5) * 0.03125;
    float first = node2 + 0.5;
    vec3 texel0_0_place = vec3(first * 0.020833334, place1, place0);
    vec4 texel0_0 = textureLod(table, texel0_0_place, 0.0);
    vec3 texel1_0_place = vec3((first + 8.0) * 0.020833334, place1, place0);
    vec4 texel1_0 = textureLod(table, texel1_0_place, 0.0);
    vec3 texel2_0_place = vec3((first + 16.0) * 0.020833334, place1, place0);
    vec4 texel2_0 = textureLod(table, texel2_0_place, 0.0);
    vec3 texel3_0_place = vec3((first + 24.0) * 0.020833334, place1, place0);
    vec4 texel3_0 = textureLod(table, texel3_0_place, 0.0);
    vec3 texel4_0_place = vec3((first + 32.0) * 0.020833334, place1, place0);
    vec4 texel4_0 = textureLod(table, texel4_0_place, 0.0);
    vec3 texel5_0_place = vec3((first + 40.0) * 0.020833334, place1, place0);
    vec4 texel5_0 = textureLod(table, texel5_0_place, 0.0);
    vec3 rest = exp(texel0_0.rgb + cos_2_psi * texel1_0.rgb + cos_2_p * texel2_0.rgb + factor2 *
        texel3_0.rgb + factor3 * texel4_0.rgb + factor4 * texel5_0.rgb);
    vec3 spread2_passed_i = max(numbers[0] * wi.x * (numbers[0] * wi.x) + numbers[6] * wi.y *
        (numbers[6] * wi.y), vec3(1.0e-9, 1.0e-9, 1.0e-9));
    vec3 passed_i = vec3(material_transmittance(spread2_passed_i.x, numbers[3].x, numbers[4].x,
        numbers[5].x, wi.z), material_transmittance(spread2_passed_i.y, numbers[3].y, numbers[4].y,
        numbers[5].y, wi.z), material_transmittance(spread2_passed_i.z, numbers[3].z, numbers[4].z,
        numbers[5].z, wi.z));
    vec3 spread2_passed_o = max(numbers[0] * wo.x * (numbers[0] * wo.x) + numbers[6] * wo.y *
        (numbers[6] * wo.y), vec3(1.0e-9, 1.0e-9, 1.0e-9));
    vec3 passed_o = vec3(material_transmittance(spread2_passed_o.x, numbers[3].x, numbers[4].x,
        numbers[5].x, wo.z), material_transmittance(spread2_passed_o.y, numbers[3].y, numbers[4].y,
        numbers[5].y, wo.z), material_transmittance(spread2_passed_o.z, numbers[3].z, numbers[4].z,
        numbers[5].z, wo.z));
    return lobe + passed_i * passed_o * rest;
}
