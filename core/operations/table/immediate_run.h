#pragma once

#include <functional>
#include <utility>

#include "core/operations/table/step.h"

namespace takt::operations {

/// The execution of a step that does its work at once, without a net. Realtime: setup.
class ImmediateRun final : public StepRun {
 public:
  explicit ImmediateRun(std::function<bool(activity::Context&, Diagnostics&)> work) : work_(std::move(work)) {}
  Progress advance(activity::Context& context, Diagnostics& diagnostics) override {
    return work_(context, diagnostics) ? Progress::kDone : Progress::kFailed;
  }

 private:
  std::function<bool(activity::Context&, Diagnostics&)> work_;
};

}  // namespace takt::operations
