#pragma once

#include <cstddef>
#include <string_view>

#include <fmt/core.h>
#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "core/base/version.h"
#include "core/plugin/interface_hash.h"

/// What a plug-in says of itself, and what it was built with, as text in a section of its file: the program reads it
/// without running any of the plug-in's code (docs/plugins.md).
namespace takt::plugin {

/// The section of the shared object that holds an About.
inline constexpr std::string_view kSection = ".takt_plugin";
/// First line of the text.
inline constexpr std::string_view kMagic = "takt plug-in 1\n";

/// Text of fixed size, written while compiling: a line "KEY VALUE" each, then zeros.
struct About {
  static constexpr std::size_t kSize = 1024;
  char text[kSize] = {};
  std::size_t length = 0;

  constexpr void append(std::string_view more) {
    for (const char c : more) text[length++] = c;  // past the end is an error of the compiler
  }
  constexpr void append(long long number) {
    if (number < 0) {
      append("-");
      number = -number;
    }
    if (number >= 10) append(number / 10);
    const char digit[] = {static_cast<char>('0' + number % 10), 0};
    append(digit);
  }
  constexpr void line(std::string_view key, auto value) {
    append(key);
    append(" ");
    append(value);
    append("\n");
  }
  [[nodiscard]] constexpr std::string_view view() const { return {text, length}; }
};

/// What two builds must have in common to share objects: the interface itself, and whatever changes the layout of
/// classes or the meaning of inline code. Keys are the words that a refused plug-in is told.
constexpr void append_build(About& about) {
  about.line("interface", TAKT_INTERFACE_HASH);
#ifdef __clang__
  about.line("compiler", "clang");
#else
  about.line("compiler", "gcc");
#endif
  about.line("cxx_abi", static_cast<long long>(__GXX_ABI_VERSION));
  about.line("cxx_standard", static_cast<long long>(__cplusplus));
#ifdef _GLIBCXX_RELEASE
  about.line("libstdcxx", static_cast<long long>(_GLIBCXX_RELEASE));
#endif
#ifdef _GLIBCXX_USE_CXX11_ABI
  about.line("libstdcxx_cxx11_abi", static_cast<long long>(_GLIBCXX_USE_CXX11_ABI));
#endif
#ifdef _GLIBCXX_DEBUG
  about.line("libstdcxx_debug", 1LL);
#else
  about.line("libstdcxx_debug", 0LL);
#endif
  about.line("eigen",
             static_cast<long long>(EIGEN_WORLD_VERSION * 10000 + EIGEN_MAJOR_VERSION * 100 + EIGEN_MINOR_VERSION));
  about.line("eigen_alignment", static_cast<long long>(EIGEN_MAX_ALIGN_BYTES));
  about.line("eigen_static_alignment", static_cast<long long>(EIGEN_MAX_STATIC_ALIGN_BYTES));
  about.line("fmt", static_cast<long long>(FMT_VERSION));
  about.line("json", static_cast<long long>(NLOHMANN_JSON_VERSION_MAJOR * 10000 + NLOHMANN_JSON_VERSION_MINOR * 100 +
                                            NLOHMANN_JSON_VERSION_PATCH));
#if defined(__SANITIZE_ADDRESS__)
  about.line("sanitizer", "address");
#elif defined(__SANITIZE_THREAD__)
  about.line("sanitizer", "thread");
#else
  about.line("sanitizer", "none");
#endif
#ifdef __FAST_MATH__
  about.line("floating_point", "fast");
#else
  about.line("floating_point", "exact");
#endif
}

/// @param name     of the plug-in, one word
/// @param version  of the plug-in, for people
constexpr About about_plugin(std::string_view name, std::string_view version) {
  About about;
  about.append(kMagic);
  about.line("name", name);
  about.line("version", version);
  about.line("takt", std::string_view(TAKT_VERSION));
  append_build(about);
  return about;
}

}  // namespace takt::plugin
