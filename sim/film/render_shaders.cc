#include "sim/film/render_shaders.h"

namespace takt::sim {

// One tap of 2x2 texels: at 720p a texel is about a pixel, and more taps cost more than everything else together.
const char* const kShadowFunction = R"glsl(
#ifdef SHADOWS
in vec4 shadow_at;
uniform sampler2DShadow shadow_map;
#ifdef NEAR_SHADOW
float shadow() { return textureProj(shadow_map, shadow_at); }
#else
float shadow() { return texture(shadow_map, shadow_at.xyz); }
#endif
#else
float shadow() { return 1.0; }
#endif
)glsl";

// Colours are squared on their way in and rooted on their way out: light adds up as light does, at the price of one
// square root in place of the sRGB curve.
const char* const kSurfaceVertexShader = R"glsl(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal_in;
layout(location = 2) in vec4 colour_in;
layout(location = 3) in vec4 material_in;
uniform mat4 clip_from_world;
out vec3 world;
out vec3 normal;
flat out vec4 colour;
flat out vec3 material;
#ifdef SHADOWS
uniform mat4 shadow_from_world;
uniform float shadow_offset;
out vec4 shadow_at;
#endif

void main() {
  world = position;
  normal = normal_in;
  colour = vec4(colour_in.rgb * colour_in.rgb, colour_in.a);
  // Strength of the highlight, its width as Schlick's exponent, light of its own.
  material = vec3(material_in.x, 4.0 + 120.0 * material_in.y, material_in.z);
#ifdef SHADOWS
  shadow_at = shadow_from_world * vec4(position + shadow_offset * normal_in, 1.0);
#endif
  gl_Position = clip_from_world * vec4(position, 1.0);
}
)glsl";

const char* const kSurfaceFragmentShader = R"glsl(
in vec3 world;
in vec3 normal;
flat in vec4 colour;
flat in vec3 material;
uniform vec3 eye;
uniform vec3 ambient_up;
uniform vec3 ambient_down;
uniform vec3 light_at[MAX_LIGHTS];  // towards a distant light, or the place of a near one
uniform vec3 light_axis[MAX_LIGHTS];
uniform vec3 light_diffuse[MAX_LIGHTS];
uniform vec3 light_specular[MAX_LIGHTS];
uniform vec4 light_fading[MAX_LIGHTS];  // attenuation, cosine of the cut-off
out vec4 result;

vec3 N, V, diffuse_sum, specular_sum;

void distant(int i, float lit) { diffuse_sum += light_diffuse[i] * (lit * max(dot(N, light_at[i]), 0.0)); }

// Highlight: Schlick, "An inexpensive BRDF model", 1994: t / (n - n t + t) in place of t^n.
void shine(vec3 L, int i, float lit) {
  float t = max(dot(N, normalize(L + V)), 0.0);
  specular_sum += light_specular[i] * (lit * t / (material.y - material.y * t + t));
}

void near(int i, float lit) {
  vec3 to_light = light_at[i] - world;
  float d = length(to_light);
  vec3 L = to_light / d;
  vec4 fading = light_fading[i];
  float strength = step(fading.w, dot(-L, light_axis[i])) / (fading.x + d * (fading.y + d * fading.z));
  diffuse_sum += light_diffuse[i] * (lit * strength * max(dot(N, L), 0.0));
}

void main() {
  vec3 to_eye = eye - world;
  float near_eye = inversesqrt(dot(to_eye, to_eye));
  V = to_eye * near_eye;
  N = normalize(normal);
  diffuse_sum = mix(ambient_down, ambient_up, 0.5 + 0.5 * N.z);
  specular_sum = vec3(0.0);
  LIGHTING
  vec3 light = colour.rgb * (diffuse_sum + material.z) + material.x * specular_sum;
  result = vec4(sqrt(min(light, 1.0)), colour.a);
}
)glsl";

// The endless floor has one normal, so its light is worked out per corner; per pixel remain shadow, lines and haze.
const char* const kFloorVertexShader = R"glsl(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal_in;
layout(location = 2) in vec4 colour_in;
uniform mat4 clip_from_world;
uniform vec3 ambient_up;
uniform vec3 light_at[MAX_LIGHTS];
uniform vec3 light_diffuse[MAX_LIGHTS];
out vec3 world;
flat out vec3 plain;   // colour under all lights but the one with the shadow
flat out vec3 sunlit;  // what that one adds
#ifdef SHADOWS
uniform mat4 shadow_from_world;
out vec4 shadow_at;
#endif

void main() {
  world = position;
  plain = ambient_up;
  sunlit = vec3(0.0);
  for (int i = 0; i < MAX_LIGHTS; ++i) {
    vec3 light = light_diffuse[i] * max(dot(normal_in, light_at[i]), 0.0);
    if (i == SHADOW_LIGHT) sunlit = light; else plain += light;
  }
  plain *= colour_in.rgb * colour_in.rgb;
  sunlit *= colour_in.rgb * colour_in.rgb;
#ifdef SHADOWS
  shadow_at = shadow_from_world * vec4(position, 1.0);
#endif
  gl_Position = clip_from_world * vec4(position, 1.0);
}
)glsl";

const char* const kFloorFragmentShader = R"glsl(
in vec3 world;
flat in vec3 plain;
flat in vec3 sunlit;
uniform vec3 eye;
uniform vec4 haze;  // colour, 1 / distance at which the floor is gone
out vec4 result;

void main() {
  // Lines every metre and, fainter, every quarter; each fades out where it gets thinner than a pixel.
  vec2 width = max(fwidth(world.xy), 1e-5);
  vec2 metre = 0.5 - abs(fract(world.xy) - 0.5);
  vec2 quarter = 0.5 - abs(fract(world.xy * 4.0) - 0.5);
  vec2 thin = 1.0 / width;
  vec2 coarse = clamp(1.2 - (metre - 0.004) * thin, 0.0, 1.0) * min(0.02 * thin, 1.0);
  vec2 fine = clamp(1.0 - (0.25 * quarter - 0.001) * thin, 0.0, 1.0) * min(0.004 * thin, 1.0);
  float lines = (1.0 - 0.30 * max(coarse.x, coarse.y)) * (1.0 - 0.10 * max(fine.x, fine.y));
  vec3 light = lines * (plain + shadow() * sunlit);
  float far = min(haze.w * distance(eye, world), 1.0);
  light = mix(light, haze.rgb, far * far * (3.0 - 2.0 * far));
  result = vec4(sqrt(min(light, 1.0)), 1.0);
}
)glsl";

const char* const kShadowVertexShader = R"glsl(
layout(location = 0) in vec3 position;
uniform mat4 clip_from_world;
void main() { gl_Position = clip_from_world * vec4(position, 1.0); }
)glsl";

const char* const kShadowFragmentShader = R"glsl(
void main() {}
)glsl";

const char* const kSkyVertexShader = R"glsl(
uniform vec3 forward;
uniform vec3 right;
uniform vec3 up;
out vec3 ray;
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  ray = forward + corner.x * right + corner.y * up;
  gl_Position = vec4(corner, 1.0, 1.0);
}
)glsl";

const char* const kSkyFragmentShader = R"glsl(
in vec3 ray;
uniform vec3 horizon;
uniform vec3 zenith;
out vec4 result;
void main() {
  float height = clamp(ray.z * inversesqrt(dot(ray, ray)), 0.0, 1.0);
  float blend = clamp(height * 1.8, 0.0, 1.0);
  result = vec4(sqrt(mix(horizon, zenith, blend * (2.0 - blend))), 1.0);
}
)glsl";

}  // namespace takt::sim
