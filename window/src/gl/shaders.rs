//! Programs of the graphics card, in GLSL 3.30.

/// Vertices of surfaces.
pub(super) const SURFACE_VERTEX: &str = r"#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in float displacement;
layout(location = 2) in vec4 normal;
layout(location = 3) in vec2 texture_place;
layout(location = 4) in uint material;
layout(location = 5) in float painted;
uniform mat4 to_eye;
uniform mat4 projection;
out vec3 eye_normal;
out vec3 eye_place;
out float moved;
out vec2 texture_at;
out float pinned;
out float factor;
flat out uint look;
void main() {
    vec4 place = to_eye * vec4(position, 1.0);
    eye_place = place.xyz;
    eye_normal = mat3(to_eye) * normal.xyz;
    moved = displacement;
    texture_at = texture_place;
    pinned = normal.w;
    factor = painted;
    look = material;
    gl_Position = projection * place;
}
";

/// Pixels of surfaces. `shading`: 0 studio, 1 to 3 a picture of a ball, 4 facets, 5 displacement.
pub(super) const SURFACE_FRAGMENT: &str = r"#version 330 core
in vec3 eye_normal;
in vec3 eye_place;
in float moved;
in vec2 texture_at;
in float pinned;
in float factor;
flat in uint look;
uniform int shading;
uniform bool perspective;
uniform float opacity;
uniform float full_displacement;
uniform bool mark_backs;
uniform sampler2D balls;
uniform bool file_colours;
uniform sampler2D materials;
uniform sampler2DArray images;
out vec4 colour;

vec3 lit(vec3 n, vec3 towards, vec3 base) {
    float key = max(dot(n, normalize(vec3(-0.45, 0.65, 0.62))), 0.0);
    float fill = max(dot(n, normalize(vec3(0.8, 0.05, 0.5))), 0.0);
    float back = max(dot(n, normalize(vec3(0.1, 0.6, -0.8))), 0.0);
    float ambient = 0.22 + 0.10 * n.y;
    vec3 half_way = normalize(normalize(vec3(-0.45, 0.65, 0.62)) + towards);
    float highlight = 0.16 * pow(max(dot(n, half_way), 0.0), 40.0);
    return base * (ambient + 0.72 * key + 0.24 * fill + 0.18 * back) + highlight;
}

vec3 heat(float share) {
    vec3 cold = vec3(0.16, 0.22, 0.55), middle = vec3(0.15, 0.68, 0.60), hot = vec3(0.98, 0.86, 0.25);
    float s = clamp(share, 0.0, 1.0);
    return s < 0.5 ? mix(cold, middle, 2.0 * s) : mix(middle, hot, 2.0 * s - 1.0);
}

void main() {
    vec3 facet = cross(dFdx(eye_place), dFdy(eye_place));
    vec3 towards = perspective ? normalize(-eye_place) : vec3(0.0, 0.0, 1.0);
    bool inside = !gl_FrontFacing;
    // The normal of the triangle on the screen points to the viewer from either side.
    bool is_flat = shading == 4 || dot(eye_normal, eye_normal) < 0.01;
    vec3 n = normalize(is_flat ? facet : inside ? -eye_normal : eye_normal);
    vec3 base = vec3(0.74, 0.72, 0.69);
    // Outside of the branch, for it takes derivatives.
    int material = int(look);
    vec4 entry = texelFetch(materials, ivec2(material % 1024, material / 1024), 0);
    vec3 image = texture(images, vec3(texture_at, max(entry.a, 0.0))).rgb;
    if (file_colours && entry.a > -1.5) base = entry.a < -0.5 ? entry.rgb : image;
    bool cut = look == 1u;
    if (cut) base = vec3(0.78, 0.30, 0.26);
    vec3 shade;
    if (shading >= 1 && shading <= 3) {
        // The normal as seen along the line of sight, so that a ball beside the middle looks like one in it.
        vec3 right = normalize(cross(vec3(0.0, 1.0, 0.0), towards));
        vec3 up = cross(towards, right);
        vec2 place = 0.5 + 0.49 * vec2(dot(right, n), dot(up, n));
        shade = texture(balls, vec2(place.x, (float(shading - 1) + place.y) / 3.0)).rgb;
        if (cut) shade = mix(shade, lit(n, towards, base), 0.75);
    } else if (shading == 5) {
        shade = lit(n, towards, heat(moved / full_displacement));
    } else {
        shade = lit(n, towards, base);
    }
    // What is painted is tinted, amber where the factor is above 1 and teal below; what is pinned is dark.
    vec3 paint = factor > 0.0 ? vec3(0.95, 0.55, 0.12) : vec3(0.10, 0.62, 0.66);
    shade = mix(shade, shade * paint * 1.5, clamp(1.2 * abs(factor), 0.0, 0.85));
    shade = mix(shade, vec3(0.16, 0.17, 0.24) + 0.25 * shade, 0.8 * smoothstep(0.0, 1.0, pinned));
    if (inside && mark_backs) {
        // The back of a surface is blue and striped.
        float stripe = step(4.0, mod(gl_FragCoord.x + gl_FragCoord.y, 8.0));
        shade = mix(shade, vec3(0.25, 0.35, 0.72), 0.55 + 0.2 * stripe);
    }
    colour = vec4(shade * opacity, opacity);
}
";

/// Vertices of edges: a little nearer to the viewer than the surface they lie on.
pub(super) const EDGE_VERTEX: &str = r"#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 to_eye;
uniform mat4 projection;
void main() {
    vec4 place = to_eye * vec4(position, 1.0);
    place.xyz *= 0.9985;
    gl_Position = projection * place;
}
";

/// Pixels of edges.
pub(super) const EDGE_FRAGMENT: &str = r"#version 330 core
uniform vec4 tint;
out vec4 colour;
void main() { colour = vec4(tint.rgb * tint.a, tint.a); }
";

/// Vertices of lines in the scene.
pub(super) const LINE_VERTEX: &str = r"#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 tint;
uniform mat4 to_eye;
uniform mat4 projection;
out vec4 shade;
void main() {
    shade = tint;
    gl_Position = projection * (to_eye * vec4(position, 1.0));
}
";

/// Pixels of lines in the scene.
pub(super) const LINE_FRAGMENT: &str = r"#version 330 core
in vec4 shade;
out vec4 colour;
void main() { colour = vec4(shade.rgb * shade.a, shade.a); }
";

/// The background: one triangle over all of the picture.
pub(super) const BACKGROUND_VERTEX: &str = r"#version 330 core
out float height;
void main() {
    vec2 corner = vec2(float(gl_VertexID / 2) * 4.0 - 1.0, float(gl_VertexID % 2) * 4.0 - 1.0);
    height = 0.5 * corner.y + 0.5;
    gl_Position = vec4(corner, 0.0, 1.0);
}
";

/// Pixels of the background.
pub(super) const BACKGROUND_FRAGMENT: &str = r"#version 330 core
in float height;
uniform vec3 top;
uniform vec3 bottom;
out vec4 colour;
void main() { colour = vec4(mix(bottom, top, clamp(height, 0.0, 1.0)), 1.0); }
";

/// A picture in the scene: a strip of two triangles with a corner for each vertex.
pub(super) const PICTURE_VERTEX: &str = r"#version 330 core
uniform mat4 to_eye;
uniform mat4 projection;
uniform vec3 corners[4];
out vec2 texture_at;
void main() {
    texture_at = vec2(float(gl_VertexID % 2), float(gl_VertexID / 2));
    gl_Position = projection * (to_eye * vec4(corners[gl_VertexID], 1.0));
}
";

/// Pixels of a picture in the scene.
pub(super) const PICTURE_FRAGMENT: &str = r"#version 330 core
in vec2 texture_at;
uniform sampler2D image;
uniform float opacity;
out vec4 colour;
void main() {
    vec4 pixel = texture(image, texture_at);
    float a = pixel.a * opacity;
    colour = vec4(pixel.rgb * a, a);
}
";
