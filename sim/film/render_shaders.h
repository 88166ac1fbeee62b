#pragma once

namespace takt::sim {

/// GLSL sources of the renderer, without their version line and defines (docs/film.md, "The picture").
///   surface   opaque and transparent geoms; LIGHTING is the code of the scene's lights
///   floor     the endless plane under distant lights; SHADOW_LIGHT is the index of the one with the shadow
///   shadow    depth only, seen from the light
///   sky       gradient behind everything
extern const char* const
    kShadowFunction;  ///< goes before the fragment shaders of surface and floor; SHADOWS switches it
extern const char* const kSurfaceVertexShader;
extern const char* const kSurfaceFragmentShader;
extern const char* const kFloorVertexShader;
extern const char* const kFloorFragmentShader;
extern const char* const kShadowVertexShader;
extern const char* const kShadowFragmentShader;
extern const char* const kSkyVertexShader;
extern const char* const kSkyFragmentShader;

}  // namespace takt::sim
