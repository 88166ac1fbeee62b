#include "sim/plain/mjcf_text.h"

#include <array>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "sim/model/mujoco_errors.h"

// Not in MuJoCo's headers: without it numbers have six digits. Weak, so that another version links without it.
extern "C" {
[[gnu::weak]] void _mjPRIVATE__set_xml_precision(int digits);
[[gnu::weak]] int _mjPRIVATE__get_xml_precision();
}

namespace takt::sim {
namespace {

constexpr int kAllDigits = 17;

/// While it lives, MuJoCo writes all digits.
class AllDigits {
 public:
  AllDigits() : before_(_mjPRIVATE__get_xml_precision()) { _mjPRIVATE__set_xml_precision(kAllDigits); }
  ~AllDigits() { _mjPRIVATE__set_xml_precision(before_); }
  AllDigits(const AllDigits&) = delete;
  AllDigits& operator=(const AllDigits&) = delete;

 private:
  int before_;
};

}  // namespace

Result<std::string> mjcf_text(mjSpec& spec) {
  if (_mjPRIVATE__set_xml_precision == nullptr || _mjPRIVATE__get_xml_precision == nullptr)
    return failure(Code::kUnsupported, "", "this version of MuJoCo writes six digits only",
                   "Build with the version that docs/decisions names");
  const AllDigits all_digits;
  std::array<char, 1000> error{};
  std::string text(std::size_t{1} << 20, '\0');
  for (int again = 0; again < 2; ++again) {
    const auto written = mujoco_call("", [&] {
      return mj_saveXMLString(&spec, text.data(), static_cast<int>(text.size()), error.data(),
                              static_cast<int>(error.size()));
    });
    if (!written) return std::unexpected(written.error());
    if (*written < 0) return failure(Code::kSystem, "", fmt::format("MuJoCo cannot write it: {}", error.data()));
    if (*written == 0) {
      text.resize(text.find('\0'));
      return text;
    }
    text.assign(static_cast<std::size_t>(*written) + 1, '\0');
  }
  return failure(Code::kSystem, "", fmt::format("MuJoCo cannot write it: {}", error.data()));
}

}  // namespace takt::sim
