// Any bytes as a URDF lead to a robot, or to diagnostics with reasons; a robot has kinematics and dynamics of finite
// numbers.
#include <string>
#include <string_view>
#include <vector>

#include "core/base/random.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/inverse.h"
#include "core/kinematics/robot_model.h"
#include "core/kinematics/solutions.h"
#include "core/kinematics/urdf_words.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/promise.h"

namespace takt {
namespace {

using kinematics::Chain;
using kinematics::JointVector;
using kinematics::RobotModel;
using test::demand;

/// Inside the ranges, where there are any.
JointVector some_q(const Chain& chain, Random& random) {
  JointVector q(chain.joint_count());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    q[i] = random.uniform(std::max(chain.lower()[i], -10.0), std::min(chain.upper()[i], 10.0));
    if (!std::isfinite(q[i])) q[i] = 0.0;
  }
  return q;
}

void try_chain(const Chain& chain) {
  Random random(1);
  const JointVector q = some_q(chain, random), dq = some_q(chain, random);
  demand(chain.forward(q).matrix().allFinite(), "the pose of a checked robot is finite");
  const JointVector torque = chain.inverse_dynamics(q, dq, dq, {0, 0, -9.81});
  demand(torque.allFinite(), "the torques of a checked robot are finite");
  demand(chain.mass_matrix(q).allFinite(), "the inertia of a checked robot is finite");
  const auto inverse = kinematics::InverseKinematics::create(chain);
  if (!inverse) return test::expect_reasons(inverse.error());
  JointVector seed = q;
  (void)inverse->solve(chain.forward(q), inverse->held(q), seed);
  kinematics::SolutionOptions options;
  options.reference = q;
  options.most = 8;
  for (const JointVector& solution : inverse_solutions(chain, chain.forward(q), options))
    demand(solution.allFinite(), "solutions are finite");
}

void load(std::string_view text) {
  const auto model = RobotModel::parse(text, "models/lwr4plus");
  if (!model) return test::expect_reasons(model.error());
  demand(model->joints.size() + 1 == model->links.size(), "a tree has one joint less than links");
  demand(std::isfinite(model->total_mass()), "the mass of a checked robot is finite");
  const auto chain = Chain::create(*model, model->root().name, model->links.back().name);
  if (!chain) return test::expect_reasons(chain.error());
  try_chain(*chain);
}

/// Changes of text that keep much of what makes it XML.
class XmlMutator {
 public:
  XmlMutator(std::string text, Random& random) : text_(std::move(text)), random_(random) {}

  std::string changed() {
    switch (random_.bits() % 5) {
      case 0:
        erase_element();
        break;
      case 1:
        double_element();
        break;
      default:
        other_value();
    }
    return std::move(text_);
  }

 private:
  std::size_t below(std::size_t n) { return n == 0 ? 0 : random_.bits() % n; }

  struct Span {
    std::size_t begin = 0, size = 0;
  };
  /// From some '<' to behind the '>' of one of the next tags.
  Span some_tags() {
    const std::size_t begin = text_.find('<', below(text_.size()));
    std::size_t end = begin;
    for (std::size_t left = 1 + below(8); left > 0 && end != std::string::npos; --left) end = text_.find('>', end + 1);
    return end == std::string::npos ? Span{} : Span{begin, end + 1 - begin};
  }
  void erase_element() {
    const Span tags = some_tags();
    text_.erase(tags.begin, tags.size);
  }
  void double_element() {
    const Span tags = some_tags();
    text_.insert(tags.begin + tags.size, text_.substr(tags.begin, tags.size));
  }
  Span some_value() {
    const std::size_t open = text_.find("=\"", below(text_.size()));
    if (open == std::string::npos) return {};
    const std::size_t close = text_.find('"', open + 2);
    return close == std::string::npos ? Span{} : Span{open + 2, close - open - 2};
  }
  /// A value from another place, or one at an edge.
  void other_value() {
    static const std::vector<std::string> kEdges = {
        "0",         "-1",     "nan",      "inf",     "1e308",    "1e-320",      "0 0 0",
        "1 0 0",     "",       "base",     "flange",  "fixed",    "revolute",    "continuous",
        "prismatic", "planar", "floating", "1e9 0 0", "0 0 1e-9", "0.5 0.5 0.5", "x"};
    const Span from = some_value();
    const std::string value = below(2) == 0 ? kEdges[below(kEdges.size())] : text_.substr(from.begin, from.size);
    const Span to = some_value();
    if (to.size > 0) text_.replace(to.begin, to.size, value);
  }

  std::string text_;
  Random& random_;
};

std::vector<std::string> words() {
  std::vector<std::string> words = {"nan",        "inf",       "1e308", "package://", "../",     "revolute",
                                    "continuous", "prismatic", "fixed", "planar",     "floating"};
  for (const char* element : {"robot", "link", "joint", "inertial", "inertia", "visual", "collision", "geometry",
                              "mesh", "material", "origin", "limit", "dynamics", "mimic", "axis"}) {
    const kinematics::UrdfWord* word = kinematics::urdf_word(element);
    words.emplace_back(element);
    if (word != nullptr) words.insert(words.end(), word->attributes.begin(), word->attributes.end());
  }
  return words;
}

}  // namespace
}  // namespace takt

namespace takt::test {

/// Half of the inputs change as elements and values.
const FuzzTarget& fuzz_target() {
  static const FuzzTarget target{.words = words(),
                                 .load = load,
                                 .share = 0.5,
                                 .mutate = [](std::string_view input, Random& random) -> std::optional<std::string> {
                                   if (input.size() <= 20) return std::nullopt;  // no element fits in there
                                   return XmlMutator(std::string(input), random).changed();
                                 }};
  return target;
}

}  // namespace takt::test
