#include "cell/judge/expectation_kind.h"

namespace takt::cell {

std::string ExpectationReader::arm() { return name("arm", keys_of(built.cell.arms)); }

Key arm_key() { return text_key("arm", "Which arm.").optional("the only one"); }
Key below_key() { return number_key("below_N", "N", kPositive, "Upper bound."); }
Key within_m_key() { return number_key("position_within_m", "m", kPositive, "Largest allowed distance."); }
Key within_deg_key() {
  return number_key("angle_within_deg", "degrees", kPositive, "Largest allowed angle.").by_default(180.0);
}

}  // namespace takt::cell
