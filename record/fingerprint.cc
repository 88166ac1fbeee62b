#include <fmt/format.h>
#include <google/protobuf/stubs/common.h>
#include <xxhash.h>
#include <zstd.h>

#include "core/base/version.h"
#include "record/recorder.h"

// The build states what it is; see record/CMakeLists.txt.
#ifndef TAKT_FLAGS
#define TAKT_FLAGS ""
#endif

namespace takt::record {

namespace {

/// The features of the processor that libraries under us choose their code by (libm, MuJoCo).
std::string cpu_features() {
  std::string features;
#if defined(__x86_64__)
  __builtin_cpu_init();
  const auto add = [&](bool has, std::string_view name) {
    if (!has) return;
    if (!features.empty()) features += ' ';
    features += name;
  };
  add(__builtin_cpu_supports("sse4.2") != 0, "sse4.2");
  add(__builtin_cpu_supports("avx") != 0, "avx");
  add(__builtin_cpu_supports("fma") != 0, "fma");
  add(__builtin_cpu_supports("avx2") != 0, "avx2");
  add(__builtin_cpu_supports("avx512f") != 0, "avx512f");
  add(__builtin_cpu_supports("avx512dq") != 0, "avx512dq");
  add(__builtin_cpu_supports("avx512vl") != 0, "avx512vl");
  return "x86_64: " + features;
#elif defined(__aarch64__)
  return "aarch64";
#else
  return "other";
#endif
}

}  // namespace

std::map<std::string, std::string> fingerprint(std::map<std::string, std::string> more) {
  more.emplace("takt", TAKT_VERSION);
#if defined(__clang__)
  more.emplace("compiler", fmt::format("clang {}", __clang_version__));
#else
  more.emplace("compiler", fmt::format("gcc {}", __VERSION__));
#endif
  more.emplace("flags", TAKT_FLAGS);
  more.emplace("cpu", cpu_features());
  more.emplace("protobuf", google::protobuf::internal::VersionString(GOOGLE_PROTOBUF_VERSION));
  more.emplace("zstd", ZSTD_versionString());
  return more;
}

std::string content_hash(std::string_view data) {
  return fmt::format("xxh3-64:{:016x}", XXH3_64bits(data.data(), data.size()));
}

}  // namespace takt::record
