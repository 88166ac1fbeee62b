#pragma once

#include "core/activity/context.h"
#include "core/activity/scheduler.h"

namespace takt::languages {

/// While it lives, motions count as run beside others, which are not checked as those that run alone. Inside of a
/// `parallel` none runs alone.
class BesideOthers {
 public:
  BesideOthers(activity::Context& context, bool beside)
      : scheduler_(beside && context.meanwhile.parallel.empty() ? context.scheduler : nullptr) {
    if (scheduler_ != nullptr) scheduler_->set_alone(false);
  }
  ~BesideOthers() {
    if (scheduler_ != nullptr) scheduler_->set_alone(true);
  }
  BesideOthers(const BesideOthers&) = delete;
  BesideOthers& operator=(const BesideOthers&) = delete;

 private:
  activity::Scheduler* scheduler_;
};

}  // namespace takt::languages
