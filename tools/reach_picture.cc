#include "tools/reach_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>

#include <fmt/format.h>

#include "core/base/output_file.h"
#include "core/base/xml_text.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/differential.h"
#include "core/kinematics/lines.h"
#include "core/kinematics/robot_model.h"
#include "core/kinematics/solutions.h"
#include "tools/model_kinematics.h"

namespace takt::tools {
namespace {

using kinematics::Chain;
using kinematics::JointVector;

constexpr int kFields = 72;        ///< across a section
constexpr int kSamples = 300'000;  ///< joint positions for the left section
constexpr int kLevels = 14;        ///< of colour
constexpr double kPanel = 460;     ///< pixels
constexpr double kLeft = 74, kTop = 96, kGap = 86, kBottom = 108;

/// A quadratic section of side 2 * half: x ahead of the base's z axis, z up, each field with its best measure.
struct Section {
  double half = 1.0, middle_z = 0.0;
  std::vector<double> best = std::vector<double>(kFields * kFields, -1.0);

  [[nodiscard]] double field() const { return 2.0 * half / kFields; }
  [[nodiscard]] double x(int column) const { return -half + (column + 0.5) * field(); }
  [[nodiscard]] double z(int row) const { return middle_z - half + (row + 0.5) * field(); }
  void mark(double x_m, double z_m, double measure) {
    const int column = static_cast<int>(std::floor((x_m + half) / field()));
    const int row = static_cast<int>(std::floor((z_m - middle_z + half) / field()));
    if (column < 0 || column >= kFields || row < 0 || row >= kFields) return;
    double& place = best[static_cast<std::size_t>(row * kFields + column)];
    place = std::max(place, measure);
  }
  void mark_block(int column, int row, int size, double measure) {
    for (int i = 0; i < size * size; ++i) mark(x(column + i % size), z(row + i / size), measure);
  }
  [[nodiscard]] double largest() const { return *std::max_element(best.begin(), best.end()); }
};

double measure_at(const Chain& chain, const JointVector& q, Eigen::Isometry3d& X_BF) {
  kinematics::Jacobian J;
  chain.jacobian(q, X_BF, J);
  return kinematics::dexterity(J, chain.reach()).smallest;
}

/// Evenly spread numbers in [0, 1). Source: Halton 1960.
double halton(int index, int base) {
  double result = 0.0;
  double share = 1.0;
  for (int i = index; i > 0; i /= base) {
    share /= base;
    result += share * (i % base);
  }
  return result;
}

constexpr std::array<int, kinematics::kMaxJoints> kPrimes = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37};

/// One turn of a joint is all there is; a sliding joint without limits gets a metre either way.
double spread(const Chain& chain, int joint, double share) {
  const double widest = chain.is_prismatic(joint) ? 1.0 : EIGEN_PI;
  const double low = std::max(chain.lower()[joint], -widest);
  const double high = std::min(chain.upper()[joint], widest);
  return low + (high - low) * share;
}

/// Axis 1 upright: turning it moves a place round the base's z axis, so one position of it is enough.
bool turns_upright(const Chain& chain) {
  const auto lines = kinematics::joint_lines(chain, JointVector::Zero(chain.joint_count()));
  return !chain.is_prismatic(0) && lines[0].axis.head<2>().norm() < kinematics::kAlmost &&
         lines[0].point.head<2>().norm() < kinematics::kAlmost;
}

/// What is done of a drawing, in parts of equal cost as far as that is known, and whether there is time for more.
class Work {
 public:
  explicit Work(const ReachOptions& options) : options_(options) {}
  /// From `begin` on the next part is `length` of the whole.
  void begin(double begin, double length) {
    begin_ = begin;
    length_ = length;
  }
  void done(double share_of_part) const {
    if (options_.progress) options_.progress(begin_ + length_ * share_of_part);
  }
  [[nodiscard]] bool has_time() const {
    return static_cast<double>(std::clock() - started_) < options_.most_seconds * CLOCKS_PER_SEC;
  }

 private:
  const ReachOptions& options_;
  std::clock_t started_ = std::clock();
  double begin_ = 0.0, length_ = 0.0;
};

double any_orientation(const Chain& chain, const Work& work, Section& section) {
  constexpr int kTold = kSamples / 100;
  const bool upright = turns_upright(chain);
  double farthest = 0.0;
  JointVector q(chain.joint_count());
  for (int k = 1; k <= kSamples; ++k) {
    for (int i = 0; i < q.size(); ++i) q[i] = spread(chain, i, halton(k, kPrimes[static_cast<std::size_t>(i)]));
    if (upright) q[0] = 0.0;
    Eigen::Isometry3d X_BF;
    const double measure = measure_at(chain, q, X_BF);
    const Eigen::Vector3d p = X_BF.translation();
    const double across = std::copysign(std::hypot(p.x(), p.y()), p.x());
    section.mark(across, p.z(), measure);
    farthest = std::max(farthest, std::hypot(across, p.z() - section.middle_z));
    if (k % kTold == 0) work.done(static_cast<double>(k) / kSamples);
  }
  return farthest;
}

/// Without a closed form a pose takes a hundred times as long: then one answers for a block of fields, and the picture
/// is there after some seconds all the same.
int block_size(const device::ArmDescription& arm) {
  constexpr int kCoarse = 4;
  static_assert(kFields % kCoarse == 0);
  return way_to_solutions(arm).starts_with("closed form") ? 1 : kCoarse;
}

/// @return the share of the section that there was time for, from below
double straight_down(const device::ArmDescription& arm, const Work& work, Section& section) {
  const Chain& chain = *arm.chain;
  const int block = block_size(arm);
  const double off_middle = 0.5 * (block - 1) * section.field();
  Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
  X_BF.linear() = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  kinematics::SolutionOptions options;
  options.turns = false;
  if (chain.joint_count() == 7) {
    const int held = kinematics::redundant_joint(chain);
    for (int k = 0; k < 7; ++k) options.held_values.push_back(spread(chain, held, (k + 0.5) / 7));
  }
  for (int row = 0; row < kFields; row += block) {
    work.done(static_cast<double>(row) / kFields);
    if (!work.has_time()) return static_cast<double>(row) / kFields;
    for (int column = 0; column < kFields; column += block) {
      X_BF.translation() << section.x(column) + off_middle, 0.0, section.z(row) + off_middle;
      // What is out of any reach needs no search.
      if ((X_BF.translation() - Eigen::Vector3d(0, 0, section.middle_z)).norm() > section.half) continue;
      for (const JointVector& q : inverse_solutions(chain, X_BF, options)) {
        Eigen::Isometry3d X;
        section.mark_block(column, row, block, measure_at(chain, q, X));
      }
    }
  }
  work.done(1.0);
  return 1.0;
}

// --- drawing ---------------------------------------------------------------------------------------------------------

/// Dark where the arm is near to singular, bright where it moves well: even steps of lightness, readable in grey.
std::string colour(double share) {
  constexpr std::array<std::array<double, 3>, 5> kStops = {
      {{59, 15, 82}, {64, 71, 136}, {33, 144, 140}, {93, 200, 99}, {250, 230, 80}}};
  const double at = std::clamp(share, 0.0, 1.0) * (kStops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  std::array<int, 3> rgb{};
  for (std::size_t k = 0; k < 3; ++k) {
    rgb[k] =
        static_cast<int>(std::lround(kStops[i][k] + (at - static_cast<double>(i)) * (kStops[i + 1][k] - kStops[i][k])));
  }
  return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

int level(double measure, double largest) {
  return measure < 0.0 ? -1 : std::min(kLevels - 1, static_cast<int>(kLevels * measure / std::max(largest, 1e-12)));
}

class Canvas {
 public:
  void text(double x, double y, std::string_view style, std::string_view words) {
    body_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"{}\">{}</text>\n", x, y, style, xml_text(words));
  }
  void rectangle(double x, double y, double width, double height, std::string_view fill) {
    body_ += fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"/>\n", x, y,
                         width, height, fill);
  }
  void raw(std::string_view svg) { body_ += svg; }
  [[nodiscard]] std::string document(double width, double height) const {
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
        "height=\"{1:.0f}\">\n<style>\ntext {{ font-family: Verdana, 'DejaVu Sans', sans-serif; font-size: 12px; fill: "
        "#334155; }}\n.title {{ font-size: 19px; font-weight: bold; fill: #0f172a; }}\n.panel {{ font-size: 13px; "
        "font-weight: bold; }}\n.middle {{ text-anchor: middle; }}\n.end {{ text-anchor: end; }}\n</style>\n"
        "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{2}</svg>\n",
        width, height, body_);
  }

 private:
  std::string body_;
};

/// The ends of the shortest way from one axis to the next, as an engineer draws links; from `start` where the axes are
/// parallel.
std::pair<Eigen::Vector3d, Eigen::Vector3d> shortest(const kinematics::Line& a, const kinematics::Line& b,
                                                     const Eigen::Vector3d& start) {
  const Eigen::Vector3d normal = a.axis.cross(b.axis);
  if (normal.norm() < kinematics::kAlmost) return {start, kinematics::foot(start, b)};
  const double along = (b.point - a.point).cross(b.axis).dot(normal) / normal.squaredNorm();
  const Eigen::Vector3d from = a.point + along * a.axis;
  return {from, kinematics::foot(from, b)};
}

/// The step of the axes' labels: 0.1, 0.2, 0.5, 1 ... m.
double label_step(double half) {
  for (double unit = 1e-3;; unit *= 10.0) {
    for (const double step : {unit, 2 * unit, 5 * unit}) {
      if (2.0 * half / step <= 9.0) return step;
    }
  }
}

/// One section with its axes, at the pixel (left, kTop).
class Panel {
 public:
  Panel(const Section& section, double left) : section_(section), left_(left) {}

  [[nodiscard]] double px(double x) const { return left_ + (x + section_.half) / (2 * section_.half) * kPanel; }
  [[nodiscard]] double py(double z) const {
    return kTop + kPanel - (z - section_.middle_z + section_.half) / (2 * section_.half) * kPanel;
  }

  /// Fields of a row with the same colour are one rectangle.
  void fields(double largest, Canvas& drawing) const {
    const double size = kPanel / kFields;
    for (int row = 0; row < kFields; ++row) {
      int begin = 0;
      for (int column = 1; column <= kFields; ++column) {
        const int here = at(row, begin, largest);
        if (column < kFields && at(row, column, largest) == here) continue;
        if (here >= 0) {
          drawing.rectangle(left_ + begin * size, kTop + kPanel - (row + 1) * size, (column - begin) * size + 0.3,
                            size + 0.3, colour((here + 0.5) / kLevels));
        }
        begin = column;
      }
    }
  }

  void axes(std::string_view title, Canvas& drawing) const {
    drawing.text(left_, kTop - 14, "panel", title);
    drawing.raw(
        fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"none\" "
                    "stroke=\"#94a3b8\"/>\n",
                    left_, kTop, kPanel, kPanel));
    const double step = label_step(section_.half);
    for (double x = std::ceil(-section_.half / step) * step; x <= section_.half; x += step) {
      grid(px(x), kTop, px(x), kTop + kPanel, drawing);
      drawing.text(px(x), kTop + kPanel + 17, "middle", label(x));
    }
    const double low = section_.middle_z - section_.half, high = section_.middle_z + section_.half;
    for (double z = std::ceil(low / step) * step; z <= high; z += step) {
      grid(left_, py(z), left_ + kPanel, py(z), drawing);
      drawing.text(left_ - 6, py(z) + 4, "end", label(z));
    }
    drawing.text(left_ + kPanel / 2, kTop + kPanel + 36, "middle", "ahead of the base's z axis, m");
    drawing.raw(
        fmt::format("<text transform=\"translate({:.1f} {:.1f}) rotate(-90)\" class=\"middle\">height above the "
                    "base, m</text>\n",
                    left_ - 48, kTop + kPanel / 2));
  }

  /// The joints from the base to the flange, at home.
  void skeleton(const device::ArmDescription& arm, Canvas& drawing) const {
    const auto lines = kinematics::joint_lines(*arm.chain, arm.home);
    const Eigen::Vector3d flange = arm.chain->forward(arm.home).translation();
    std::vector<Eigen::Vector3d> points{Eigen::Vector3d::Zero()};
    for (int i = 0; i + 1 < arm.chain->joint_count(); ++i) {
      const auto [from, to] =
          shortest(lines[static_cast<std::size_t>(i)], lines[static_cast<std::size_t>(i) + 1], points.back());
      points.push_back(from);
      points.push_back(to);
    }
    points.push_back(flange);
    std::string path;
    for (const Eigen::Vector3d& p : points) {
      path += fmt::format("{}{:.1f} {:.1f} ", path.empty() ? "M" : "L", px(p.x()), py(p.z()));
    }
    for (const auto& [stroke, width] : {std::pair{"#ffffff", 6.0}, std::pair{"#0f172a", 3.0}}) {
      drawing.raw(
          fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\" "
                      "stroke-linecap=\"round\"/>\n",
                      path, stroke, width));
    }
    drawing.raw(fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5\" fill=\"#dc2626\" stroke=\"#ffffff\"/>\n",
                            px(flange.x()), py(flange.z())));
  }

 private:
  [[nodiscard]] int at(int row, int column, double largest) const {
    return level(section_.best[static_cast<std::size_t>(row * kFields + column)], largest);
  }
  static std::string label(double value) { return fmt::format("{:.3g}", std::abs(value) < 1e-9 ? 0.0 : value); }
  static void grid(double x1, double y1, double x2, double y2, Canvas& drawing) {
    drawing.raw(
        fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"#0f172a\" "
                    "stroke-opacity=\"0.12\"/>\n",
                    x1, y1, x2, y2));
  }

  const Section& section_;
  double left_;
};

void legend(double largest, double left, double width, double y, Canvas& drawing) {
  const double step = width / kLevels;
  for (int i = 0; i < kLevels; ++i) {
    drawing.rectangle(left + i * step, y, step + 0.3, 14, colour((i + 0.5) / kLevels));
  }
  drawing.text(left, y + 30, "", "0: singular");
  drawing.text(left + width, y + 30, "end", fmt::format("{:.3f}: moves best", largest));
  drawing.text(left + width / 2, y + 30, "middle", "smallest singular value of the Jacobian (lengths over the reach)");
}

std::string picture(const device::ArmDescription& arm, const Section& any, const Section& down, const Reach& reach) {
  Canvas drawing;
  const double right = kLeft + kPanel + kGap;
  const double largest = std::max(any.largest(), down.largest());
  drawing.text(kLeft - 50, 34, "title", fmt::format("{}: where the flange gets", arm.title));
  drawing.text(
      kLeft - 50, 56, "",
      fmt::format("at most {:.3f} m from the point ({:.0f}, {:.0f}, {:.3f}) m above the base; black: home; red: flange",
                  reach.farthest_m, 0.0, 0.0, any.middle_z));
  std::string title_of_down = "flange straight down, its x ahead";
  if (reach.share < 1.0) title_of_down += fmt::format(" (the lower {:.0f} % only)", 100.0 * reach.share);
  const std::pair<const Section*, std::string_view> panels[] = {{&any, "any orientation"}, {&down, title_of_down}};
  double left = kLeft;
  for (const auto& [section, title] : panels) {
    const Panel panel(*section, left);
    panel.fields(largest, drawing);
    panel.axes(title, drawing);
    panel.skeleton(arm, drawing);
    left = right;
  }
  legend(largest, kLeft, 2 * kPanel + kGap, kTop + kPanel + 56, drawing);
  return drawing.document(right + kPanel + 24, kTop + kPanel + kBottom);
}

}  // namespace

Result<Reach> draw_reach(const device::ArmDescription& arm, const std::filesystem::path& file,
                         const ReachOptions& options) {
  if (file.extension() != ".svg") {
    return failure(Code::kInvalidValue, "--reach", fmt::format("'{}' does not end in .svg", file.string()),
                   "Name a file OUT.svg");
  }
  const Chain& chain = *arm.chain;
  // The middle is the height of the second joint: what turns there sweeps the section.
  const auto lines = kinematics::joint_lines(chain, arm.home);
  Section any;
  any.middle_z = chain.joint_count() > 1 ? kinematics::foot(Eigen::Vector3d::Zero(), lines[1]).z() : 0.0;
  any.half = 1.1 * chain.reach();
  Section down = any;
  Reach reach;
  Work work(options);
  work.begin(0.0, 0.2);
  reach.farthest_m = any_orientation(chain, work, any);
  // Joint offsets often leave the arm far short of the sum of its links: the section fits what was found.
  any = down;
  any.half = down.half = 1.06 * reach.farthest_m;
  work.begin(0.2, 0.2);
  reach.farthest_m = any_orientation(chain, work, any);
  work.begin(0.4, 0.6);
  reach.share = straight_down(arm, work, down);
  reach.best_measure = std::max(any.largest(), down.largest());
  if (Diagnostics diagnostics = write_file(file, picture(arm, any, down, reach), "--reach"); diagnostics.has_errors())
    return std::unexpected(std::move(diagnostics));
  return reach;
}

}  // namespace takt::tools
