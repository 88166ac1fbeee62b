#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/diagnostics.h"

namespace takt::sim {

/// An OpenGL 3.3 core context of OSMesa, without a display. Move-only. Thread: current in one thread at a time.
class GlContext {
 public:
  [[nodiscard]] static Result<GlContext> create();
  GlContext(GlContext&& other) noexcept;
  GlContext& operator=(GlContext&& other) noexcept;
  ~GlContext();

  /// Makes the context current in the calling thread; cheap if it is already.
  [[nodiscard]] bool make_current();

 private:
  GlContext() = default;
  void* context_ = nullptr;
  std::unique_ptr<std::uint32_t[]> pixels_;  // OSMesa demands a buffer; pictures are drawn into framebuffer objects
};

/// Compiles and links a program; `defines` goes before both sources, `functions` before
/// the fragment's. The diagnostic carries the compiler's text.
/// The context must be current. @return its OpenGL name
[[nodiscard]] Result<unsigned> build_program(std::string_view defines, const char* vertex_source,
                                             std::string_view functions, const char* fragment_source);

}  // namespace takt::sim
