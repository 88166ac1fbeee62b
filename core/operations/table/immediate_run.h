#pragma once

#include <functional>
#include <utility>

#include "core/operations/table/step.h"

namespace takt::activity {

/// The execution of a step that does its work at once, without a net. Realtime: setup.
class ImmediateRun final : public StepRun {
 public:
  explicit ImmediateRun(std::function<bool(Context&, Diagnostics&)> work) : work_(std::move(work)) {}
  Progress advance(Context& context, Diagnostics& diagnostics) override {
    return work_(context, diagnostics) ? Progress::kDone : Progress::kFailed;
  }

 private:
  std::function<bool(Context&, Diagnostics&)> work_;
};

}  // namespace takt::activity
