#include "sim/film/render_gl.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
// After osmesa.h, which brings gl.h.
#include <GL/glext.h>
#include <fmt/format.h>

namespace takt::sim {
namespace {

constexpr int kDummySide = 16;

// All contexts of a process share one rasteriser, which fills one picture at a time: threads of its own let it keep all
// cores busy while our workers prepare the next ones (docs/film.md, "Speed"). No picture should wait for a shader cache
// on disk. The user's own settings win.
void set_driver_defaults() {
  static const bool done = [] {
    const unsigned cores = std::clamp(std::thread::hardware_concurrency(), 1u, 4u);
    setenv("LP_NUM_THREADS", std::to_string(cores).c_str(), 0);
    setenv("GALLIUM_DRIVER", "llvmpipe", 0);
    setenv("MESA_SHADER_CACHE_DISABLE", "true", 0);
    return true;
  }();
  (void)done;
}

/// True if the process may have as many more threads. Where it may not, the rasteriser waits for ever for the thread
/// that it did not get.
bool can_have_threads(unsigned count) {
  std::atomic<bool> done = false;
  std::vector<std::jthread> threads;
  bool all = true;
  try {
    for (unsigned i = 0; i < count; ++i) threads.emplace_back([&done] { done.wait(false); });
  } catch (const std::system_error&) {
    all = false;
  }
  done = true;
  done.notify_all();
  return all;
}

Result<unsigned> compile(GLenum kind, std::string_view defines, const char* source) {
  const std::string text = fmt::format("#version 330 core\n{}\n{}", defines, source);
  const char* lines = text.c_str();
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &lines, nullptr);
  glCompileShader(shader);
  GLint compiled = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_TRUE) return shader;
  std::array<char, 2048> log{};
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  glDeleteShader(shader);
  return failure(Code::kSystem, "", fmt::format("the graphics driver refuses a shader: {}", log.data()));
}

}  // namespace

Result<GlContext> GlContext::create() {
  set_driver_defaults();
  constexpr unsigned kThreads = 5;  // of the rasteriser at most, and one of the driver
  if (!can_have_threads(kThreads))
    return failure(Code::kSystem, "", fmt::format("no threads to draw with: {} are needed", kThreads),
                   "Raise the limit of processes (ulimit -u)");
  constexpr std::array kAttributes = {OSMESA_FORMAT,
                                      OSMESA_RGBA,
                                      OSMESA_DEPTH_BITS,
                                      0,
                                      OSMESA_PROFILE,
                                      OSMESA_CORE_PROFILE,
                                      OSMESA_CONTEXT_MAJOR_VERSION,
                                      3,
                                      OSMESA_CONTEXT_MINOR_VERSION,
                                      3,
                                      0};
  GlContext made;
  made.context_ = OSMesaCreateContextAttribs(kAttributes.data(), nullptr);
  if (made.context_ == nullptr) {
    return failure(Code::kSystem, "", "OSMesa gives no OpenGL 3.3 core context",
                   "Install libosmesa6, and unset GALLIUM_DRIVER");
  }
  made.pixels_ = std::make_unique<std::uint32_t[]>(kDummySide * kDummySide);
  if (!made.make_current())
    return failure(Code::kSystem, "", "the OSMesa context cannot be made current", "Install libosmesa6");
  return made;
}

GlContext::GlContext(GlContext&& other) noexcept
    : context_(std::exchange(other.context_, nullptr)), pixels_(std::move(other.pixels_)) {}

GlContext& GlContext::operator=(GlContext&& other) noexcept {
  std::swap(context_, other.context_);
  std::swap(pixels_, other.pixels_);
  return *this;
}

GlContext::~GlContext() {
  if (context_ == nullptr) return;
  const auto context = static_cast<OSMesaContext>(context_);
  // A later context at the same address must not pass for the current one.
  if (OSMesaGetCurrentContext() == context) OSMesaMakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
  OSMesaDestroyContext(context);
}

bool GlContext::make_current() {
  const auto context = static_cast<OSMesaContext>(context_);
  if (OSMesaGetCurrentContext() == context) return true;
  return OSMesaMakeCurrent(context, pixels_.get(), GL_UNSIGNED_BYTE, kDummySide, kDummySide) == GL_TRUE;
}

Result<unsigned> build_program(std::string_view defines, const char* vertex_source, std::string_view functions,
                               const char* fragment_source) {
  // Mesa 22 reads the folders for replaced shaders into static memory, without a lock, when it compiles the first one.
  static std::mutex compiling;
  const std::lock_guard lock(compiling);
  const Result<unsigned> vertex = compile(GL_VERTEX_SHADER, defines, vertex_source);
  if (!vertex) return vertex;
  const Result<unsigned> fragment =
      compile(GL_FRAGMENT_SHADER, fmt::format("{}{}", defines, functions), fragment_source);
  if (!fragment) return fragment;
  const GLuint program = glCreateProgram();
  glAttachShader(program, *vertex);
  glAttachShader(program, *fragment);
  glLinkProgram(program);
  glDeleteShader(*vertex);
  glDeleteShader(*fragment);
  GLint linked = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return program;
  std::array<char, 2048> log{};
  glGetProgramInfoLog(program, static_cast<GLsizei>(log.size()), nullptr, log.data());
  return failure(Code::kSystem, "", fmt::format("the graphics driver refuses a program: {}", log.data()));
}

}  // namespace takt::sim

#if defined(__SANITIZE_ADDRESS__)
// OSMesa keeps a few hundred bytes for every context that ever was, until the process ends.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa.so\n"; }
#endif
