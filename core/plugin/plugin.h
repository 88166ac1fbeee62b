#pragma once

#include "core/base/registration.h"
#include "core/plugin/about.h"

/// Makes a shared object a plug-in of takt; stands once in it, in a source file, outside of namespaces:
///   TAKT_PLUGIN("fan", "1.0.0");
/// Its primitives and kinds of device register themselves, in any of its files, as they do in takt (docs/plugins.md).
#define TAKT_PLUGIN(name, version)                                                                       \
  [[gnu::section(".takt_plugin"), gnu::used]] static constexpr ::takt::plugin::About takt_plugin_about = \
      ::takt::plugin::about_plugin(name, version);                                                       \
  extern "C" [[gnu::visibility("default")]] ::takt::Registration* takt_plugin_registrations() {          \
    return ::takt::own_registrations;                                                                    \
  }                                                                                                      \
  static_assert(true)
