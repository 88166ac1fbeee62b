#pragma once

#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "cell/file/description.h"
#include "core/device/device_file.h"

namespace takt::cell::test {

/// The models of the repository.
inline const device::ModelLibrary& models() {
  static const device::ModelLibrary library({"models"});
  return library;
}

/// A description that is right in form; else the test fails, and it is empty.
inline Description parsed(const std::string& text) {
  auto description = parse_description(text);
  if (!description) {
    ADD_FAILURE() << description.error().to_string();
    return {};
  }
  return std::move(*description);
}

}  // namespace takt::cell::test
