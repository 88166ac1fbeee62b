#include "core/activity/motion_options.h"

namespace takt::activity {

BlendingCondition BlendingCondition::at_distance(double metres) {
  return BlendingCondition(motion::Blend{motion::Blend::Kind::kDistance, metres});
}

motion::Blend BlendingCondition::inside() const {
  if (!time_share) return along_path;
  return {motion::Blend::Kind::kFraction, 1.0 - *time_share};
}

}  // namespace takt::activity
