#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "core/kinematics/inverse.h"
#include "core/motion/blend_limits.h"
#include "core/motion/leg.h"
#include "core/motion/path_planner.h"
#include "core/motion/plan_checks.h"

namespace takt::motion {
namespace {

constexpr double kNoUpperBound = std::numeric_limits<double>::infinity();
/// Motions that meet at less than this cosine turn back on themselves: a blend would be a needle.
constexpr double kReversal = -0.985;
constexpr double kLargestBlendTurn = 170.0 * std::numbers::pi / 180.0;
/// Below this cost (s) a motion has no way: rounding of the goals.
constexpr double kNoWay = 1e-9;
constexpr int kSteps = 32;

/// A motion seen from the sequence: its geometry, what it costs, where its blends begin and end.
struct Part {
  Leg leg;
  std::vector<PieceShares> shares;  ///< of its pieces
  std::vector<PieceWalk> walks;     ///< of its pieces, whole
  double cost = 0.0;                ///< s: rough time at its velocity limits
  JointVector q_start, q_goal;
  double begin = 0.0;  ///< share of the motion that the blend before takes
  double end = 1.0;    ///< where the blend after begins
  bool rest_after = true;
};

/// Joints and frame at one place of a motion, by its cost.
struct Place {
  bool cartesian = false;
  Jet<JointVector> joints;
  FrameJet frame;
};

class SequencePlanner {
 public:
  explicit SequencePlanner(const ArmModel& arm) : arm_(arm), planner_(arm) {}

  Result<SequencePlan> plan(const JointVector& q_start, const std::vector<LegMaker>& makers) {
    Diagnostics diagnostics = make_parts(q_start, makers);
    if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
    for (std::size_t i = 0; i + 1 < parts_.size(); ++i) set_corner(i);
    for (std::size_t i = 0; i + 1 < parts_.size(); ++i) stop_where_faster(i);
    return plan_groups(q_start);
  }

  /// Of the part that is left of a motion, and what follows.
  Result<SequencePlan> plan(const Departure& from, const std::vector<LegMaker>& makers) {
    Diagnostics diagnostics = make_first_part(from);
    if (!diagnostics.has_errors()) diagnostics = make_parts(from.motion.q_goal, makers);
    if (!diagnostics.has_errors()) diagnostics = set_first_corner(from);
    if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
    for (std::size_t i = 1; i + 1 < parts_.size(); ++i) set_corner(i);
    return plan_groups(place_at(parts_.front(), parts_.front().begin).joints.value);
  }

 private:
  Result<SequencePlan> plan_groups(const JointVector& q_start) {
    for (std::size_t first = 0; first < parts_.size();) {
      std::size_t last = first;
      while (!parts_[last].rest_after) ++last;
      auto group = plan_group(first, last);
      if (!group) return std::unexpected(std::move(group.error()));
      if (!*group) continue;  // a blend was given up: the group is smaller now
      groups_.push_back(std::move(**group));
      first = last + 1;
    }
    return finish(q_start);
  }

  /// One stretch from rest to rest.
  struct Group {
    Motion motion;
    double cost = 0.0;
    std::vector<double> handed_over;  ///< own s of each corner inside
  };

  static std::string place_of(std::size_t part, const char* key) {
    return pointer_segment(part) + (key[0] == '\0' ? "" : "/") + key;
  }

  Diagnostics make_parts(const JointVector& q_start, const std::vector<LegMaker>& makers) {
    Diagnostics diagnostics;
    JointVector q = q_start;
    for (std::size_t i = 0; i < makers.size(); ++i) {
      auto leg = makers[i](q);
      if (!leg) {
        diagnostics.append(leg.error(), pointer_segment(i));
        return diagnostics;
      }
      MotionOptions options{
          .velocity = leg->velocity, .acceleration = leg->acceleration, .linear_velocity = leg->linear_velocity};
      Diagnostics wrong;
      check_options(options, wrong);
      check_blend(leg->blend, wrong);
      if (wrong.has_errors()) {
        diagnostics.append(wrong, pointer_segment(i));
        return diagnostics;
      }
      const PieceShares shares{
          .velocity = leg->velocity,
          .acceleration = leg->acceleration,
          .linear_velocity = leg->linear_velocity.value_or(std::numeric_limits<double>::infinity())};
      Part part{.leg = std::move(*leg), .shares = {}, .walks = {}, .q_start = q, .q_goal = q};
      part.shares.assign(part.leg.pieces.size(), shares);
      if (Diagnostics walked = walk(part, place_of(i, "goal")); walked.has_errors()) return walked;
      q = part.q_goal;
      parts_.push_back(std::move(part));
    }
    return diagnostics;
  }

  /// Fills in what follows from the geometry of a part.
  Diagnostics walk(Part& part, const std::string& pointer) const {
    std::vector<PlannedPiece> pieces;
    for (std::size_t k = 0; k < part.leg.pieces.size(); ++k) pieces.push_back({part.leg.pieces[k], part.shares[k]});
    WalkedPath walked = planner_.walk(pieces, part.q_start, std::vector<int>(pieces.size(), kSteps), pointer);
    if (walked.diagnostics.has_errors()) return std::move(walked.diagnostics);
    part.walks = std::move(walked.walks);
    part.q_goal = part.walks.back().nodes.back().q;
    part.cost = cost_of(part);
    return {};
  }

  /// What is left of a motion, with how it is entered.
  Diagnostics make_first_part(const Departure& from) {
    const Motion& motion = from.motion;
    Part part{.leg = {.pieces = pieces_of(motion.path), .linear_velocity = {}, .blend = from.blend},
              .shares = motion.shares,
              .walks = {},
              .q_start = motion.q_start,
              .q_goal = motion.q_goal};
    part.shares.resize(part.leg.pieces.size(), motion.shares.empty() ? PieceShares{} : motion.shares.back());
    Diagnostics diagnostics;
    check_blend(from.blend, diagnostics);
    if (from.blend.kind == Blend::Kind::kNone) diagnostics.error(Code::kPlanningFailed, "/blend", "none was asked for");
    if (!(from.tau > 0.0 && from.tau + from.lead < motion.duration()))
      diagnostics.error(Code::kOutOfRange, "/tau", fmt::format("{:.4f} s", from.tau),
                        "Take over within the motion, with the lead before its end");
    if (!diagnostics.has_errors()) diagnostics = walk(part, "/motion");
    if (diagnostics.has_errors()) return diagnostics;
    part.begin = motion.law.at(from.tau).s;
    // By cost; the place in the group follows when it is known.
    const LawPoint at = motion.law.at(from.tau);
    start_ = {.begin = {.ds = at.ds * part.cost, .dds = at.dds * part.cost},
              .lead = motion.law.segments_between(from.tau, from.tau + from.lead)};
    for (TimeLaw::Segment& segment : start_->lead) segment.jerk *= part.cost;
    parts_.push_back(std::move(part));
    return {};
  }

  /// The blend out of what is left of a motion: smaller, if the motion is beyond the place where it should begin.
  Diagnostics set_first_corner(const Departure& from) {
    Diagnostics diagnostics;
    Part& a = parts_[0];
    Part& b = parts_[1];
    if (b.cost < kNoWay) {
      diagnostics.error(Code::kPlanningFailed, "/blend", "the next motion has no length");
    } else if (direction(a, 1.0).dot(direction(b, 0.0)) < kReversal) {
      diagnostics.error(Code::kPlanningFailed, "/blend", "the next motion turns straight back");
    }
    const double soonest = from.motion.law.at(from.tau + from.lead).s;
    const double wanted = share_of(0, true);
    const double share = from.shrink * std::min(wanted, 1.0 - soonest);
    constexpr double kLeast = 1e-3;  // of the motion
    if (!(share > kLeast))
      diagnostics.error(Code::kOutOfRange, "/tau", fmt::format("{:.4f} s is too late", from.tau),
                        "Take over before the goal");
    if (diagnostics.has_errors()) return diagnostics;
    a.end = 1.0 - share;
    b.begin = share_of(0, false) * share / wanted;
    a.rest_after = false;
    return diagnostics;
  }

  static void check_blend(const Blend& blend, Diagnostics& diagnostics) {
    const bool fraction = blend.kind == Blend::Kind::kFraction;
    const double least = fraction ? kLeastBlendShare : kLeastBlend_m, most = fraction ? kMostBlendShare : kNoUpperBound;
    if (blend.kind == Blend::Kind::kNone || (blend.value >= least && blend.value <= most)) return;
    diagnostics.error(Code::kOutOfRange, "/blend", fmt::format("{}", blend.value),
                      fraction ? fmt::format("Choose at least {}, at most {}", least, most)
                               : fmt::format("Choose at least {} m", least));
  }

  /// Time of the motion if it ran at its velocity limits all the way.
  [[nodiscard]] double cost_of(const Part& part) const {
    double cost = 0.0;
    for (std::size_t k = 0; k < part.walks.size(); ++k) {
      const PieceWalk& walk = part.walks[k];
      for (const PieceWalk::Node& node : walk.nodes) {
        const double joints = (node.dq.cwiseAbs().cwiseQuotient(arm_.limits.velocity)).maxCoeff();
        const double linear = node.dX.head<3>().norm();
        const double frame = std::max(linear / arm_.cartesian.linear_velocity,
                                      node.dX.tail<3>().norm() / arm_.cartesian.angular_velocity);
        const double share = std::max(joints, frame) / part.shares[k].velocity;
        cost += std::max(share, linear / part.shares[k].linear_velocity) / static_cast<double>(walk.nodes.size());
      }
    }
    return cost;
  }

  /// Decides whether the corner after part i is blended, and where.
  void set_corner(std::size_t i) {
    Part& a = parts_[i];
    Part& b = parts_[i + 1];
    if (a.leg.blend.kind == Blend::Kind::kNone) return;
    if (a.cost < kNoWay || b.cost < kNoWay) return note_rest(i, "a motion without length");
    if (direction(a, 1.0).dot(direction(b, 0.0)) < kReversal)
      return note_rest(i, "the next motion turns straight back");
    a.end = 1.0 - share_of(i, true);
    b.begin = share_of(i, false);
    a.rest_after = false;
  }

  /// Undoes a blend that is so sharp that the arm would nearly stand in it for longer than a stop takes. The two
  /// motions alone are compared, each from rest to rest.
  void stop_where_faster(std::size_t i) {
    constexpr double kSharp = 0.02;  // s: wider blends are kept, as asked for; some take a tenth longer than a stop
    const Part a = parts_[i], b = parts_[i + 1];
    if (a.rest_after || (1.0 - a.end) * a.cost + b.begin * b.cost > kSharp) return;
    const Diagnostics notes = notes_;
    const auto duration = [&](bool blended) {
      parts_[i].begin = 0.0;
      parts_[i + 1].end = 1.0;
      if (!blended) {
        stop_after(i);
        const auto first = plan_group(i, i), second = plan_group(i + 1, i + 1);
        return first && *first && second && *second ? (**first).motion.duration() + (**second).motion.duration()
                                                    : kNoUpperBound;
      }
      const auto both = plan_group(i, i + 1);
      return both && *both ? (**both).motion.duration() : 0.0;  // refused or given up later, with its reason
    };
    const double around = duration(true);
    const bool slower = around > 0.0 && duration(false) < around;
    parts_[i] = a;
    parts_[i + 1] = b;
    notes_ = notes;
    if (!slower) return;
    note_rest(i, "this blend takes longer than a stop, a larger one does not");
    stop_after(i);
  }

  void stop_after(std::size_t corner) {
    parts_[corner].rest_after = true;
    parts_[corner].end = 1.0;
    parts_[corner + 1].begin = 0.0;
  }

  /// Direction of the joints, each over its velocity limit, at an end of a motion.
  [[nodiscard]] Eigen::VectorXd direction(const Part& part, double end) const {
    const PieceWalk& walk = end > 0.5 ? part.walks.back() : part.walks.front();
    const PieceWalk::Node& node = end > 0.5 ? walk.nodes.back() : walk.nodes.front();
    return Eigen::VectorXd(node.dq.cwiseQuotient(arm_.limits.velocity)).normalized();
  }

  /// The share of motion i (before the corner) or i + 1 (after it) that the blend takes.
  double share_of(std::size_t i, bool before) {
    const Blend& blend = parts_[i].leg.blend;
    if (blend.kind == Blend::Kind::kFraction) return std::min(blend.value, kMostBlendShare);
    const Part& part = parts_[before ? i : i + 1];
    const auto position = [&](double share) { return tool_position(part, before ? 1.0 - share : share); };
    const Eigen::Vector3d corner = position(0.0);
    const auto away = [&](double share) { return (position(share) - corner).norm(); };
    double near = 0.0;
    double far = 0.0;
    constexpr int kScan = 16;
    for (int k = 1; k <= kScan && away(far) < blend.value; ++k) {
      near = far;
      far = kMostBlendShare * k / kScan;
    }
    if (away(far) < blend.value) {
      notes_.note(place_of(i, "blend"),
                  fmt::format("a blend of {:.4g} mm is more than half of motion {}: made as large as {:.4g} mm there",
                              1e3 * blend.value, before ? i : i + 1, 1e3 * away(far)));
      return kMostBlendShare;
    }
    for (int k = 0; k < 40; ++k) {
      const double middle = 0.5 * (near + far);
      (away(middle) < blend.value ? near : far) = middle;
    }
    return far;
  }

  /// The piece of a motion that holds `own` in [0, 1]; `t` is where in the piece.
  static std::size_t piece_at(const Part& part, double own, double& t) {
    std::size_t k = 0;
    while (k + 1 < part.leg.pieces.size() && own > part.leg.pieces[k].s_end) ++k;
    const PathPiece& piece = part.leg.pieces[k];
    t = std::clamp((own - piece.s_begin) / (piece.s_end - piece.s_begin), 0.0, 1.0);
    return k;
  }

  /// The geometry's own parameter at t in [0, 1] of a piece, and its derivative if t has this one.
  static PathPoint own_of(const PathPiece& piece, double t, double dt) {
    const double span = piece.own_end - piece.own_begin;
    return {.s = piece.own_begin + t * span, .ds = dt * span};
  }

  [[nodiscard]] Eigen::Vector3d tool_position(const Part& part, double own) const {
    double t = 0.0;
    const PathPiece& piece = part.leg.pieces[piece_at(part, own, t)];
    const PathSample at = sample(piece.geometry, own_of(piece, t, 0.0));
    if (at.cartesian) return at.frame.X_BM.translation();
    return (arm_.chain.forward(at.joints.q) * arm_.X_FM).translation();
  }

  /// The part [from, to] of a piece of a motion, over the cost that it stands for.
  static PathPiece cut(const Part& part, std::size_t k, double from, double to) {
    PathPiece piece = part.leg.pieces[k];
    const double width = piece.s_end - piece.s_begin;
    const double begin = std::max(from, piece.s_begin);
    const double end = std::min(to, piece.s_end);
    const PathPiece& whole = part.leg.pieces[k];
    piece.own_begin = own_of(whole, (begin - whole.s_begin) / width, 0.0).s;
    piece.own_end = own_of(whole, (end - whole.s_begin) / width, 0.0).s;
    piece.s_begin = begin * part.cost;
    piece.s_end = end * part.cost;
    return piece;
  }

  /// Joints (always) and frame (Cartesian motions) at a share of a motion, with derivatives by cost.
  [[nodiscard]] Place place_at(const Part& part, double own) const {
    double t = 0.0;
    const std::size_t k = piece_at(part, own, t);
    const PathPiece& piece = part.leg.pieces[k];
    const double rate = 1.0 / ((piece.s_end - piece.s_begin) * part.cost);  // of t by cost
    const PathSample at = sample(piece.geometry, own_of(piece, t, rate));
    Place place{.cartesian = at.cartesian, .joints = {at.joints.q, at.joints.dq, at.joints.ddq}, .frame = {}};
    if (!at.cartesian) return place;
    const FrameSample& f = at.frame;
    place.frame = {.p = {f.X_BM.translation(), f.V_BM_B.head<3>(), f.A_BM_B.head<3>()},
                   .R = f.X_BM.linear(),
                   .turn = {.w = f.V_BM_B.tail<3>(), .alpha = f.A_BM_B.tail<3>()},
                   .held = {at.held.q, at.held.dq, at.held.ddq}};
    // The joints there: a few steps on from the node before.
    const PieceWalk& walk = part.walks[k];
    const auto node = std::min(static_cast<std::size_t>(t * walk.steps), walk.nodes.size() - 1);
    const double t_node = walk.t(node);
    if (t - t_node < 1e-9) {
      const PieceWalk::Node& n = walk.nodes[node];
      place.joints = {n.q, n.dq * rate, n.ddq * (rate * rate)};
      return place;
    }
    PathPiece rest = piece;
    rest.own_begin = own_of(piece, t_node, 0.0).s;
    rest.own_end = own_of(piece, t, 0.0).s;
    const PieceWalk last = walk_piece(arm_.inverse, rest, arm_.X_FM, walk.nodes[node].q, 1);
    const PieceWalk::Node& n = last.nodes.back();
    const double k1 = rate / (t - t_node);
    place.joints = {n.q, n.dq * k1, n.ddq * (k1 * k1)};
    return place;
  }

  template <class T>
  static Jet<T> scaled(const Jet<T>& jet, double width) {
    return {.value = jet.value, .first = width * jet.first, .second = (width * width) * jet.second};
  }
  static FrameJet scaled(FrameJet jet, double width) {
    jet.p = scaled(jet.p, width);
    jet.held = scaled(jet.held, width);
    jet.turn.w *= width;
    jet.turn.alpha *= width * width;
    return jet;
  }

  static MovingStart scaled(MovingStart start, double factor) {
    start.begin = {.ds = factor * start.begin.ds, .dds = factor * start.begin.dds};
    for (TimeLaw::Segment& segment : start.lead) segment.jerk *= factor;
    return start;
  }

  /// The curve over the corner after part i.
  [[nodiscard]] Geometry blend_curve(std::size_t i, double width) const {
    const Place a = place_at(parts_[i], parts_[i].end);
    const Place b = place_at(parts_[i + 1], parts_[i + 1].begin);
    if (a.cartesian && b.cartesian && log_rotation(b.frame.R * a.frame.R.transpose()).norm() < kLargestBlendTurn) {
      return CartesianCurve::between(scaled(a.frame, width), scaled(b.frame, width));
    }
    return JointCurve{Quintic<JointVector>::between(scaled(a.joints, width), scaled(b.joints, width))};
  }

  /// A blend keeps the lower limits of the two motions that it joins.
  static PlannedPiece blend_piece(const Part& a, const Part& b, Geometry curve) {
    const PieceShares& before = a.shares.back();
    const PieceShares& after = b.shares.front();
    return {.piece = {.geometry = std::move(curve)},
            .shares = {.velocity = std::min(before.velocity, after.velocity),
                       .acceleration = std::min(before.acceleration, after.acceleration),
                       .linear_velocity = std::min(before.linear_velocity, after.linear_velocity)}};
  }

  /// From rest to rest over parts first..last. @return nothing if a blend had to be given up.
  Result<std::optional<Group>> plan_group(std::size_t first, std::size_t last) {
    Group group;
    std::vector<PlannedPiece> pieces;
    std::vector<std::size_t> part_of;
    std::vector<double> corners;
    double cost = 0.0;
    const auto add = [&](PlannedPiece piece, std::size_t part, double width) {
      piece.piece.s_begin = cost;
      piece.piece.s_end = cost += width;
      pieces.push_back(std::move(piece));
      part_of.push_back(part);
    };
    for (std::size_t i = first; i <= last; ++i) {
      const Part& part = parts_[i];
      group.cost += part.cost;
      for (std::size_t k = 0; k < part.leg.pieces.size() && part.cost >= kNoWay; ++k) {
        const PathPiece& whole = part.leg.pieces[k];
        if (whole.s_end <= part.begin || whole.s_begin >= part.end) continue;
        PlannedPiece piece{cut(part, k, part.begin, part.end), part.shares[k]};
        const bool uncut = piece.piece.own_begin == whole.own_begin && piece.piece.own_end == whole.own_end;
        if (uncut) piece.known = &part.walks[k];
        const double width = piece.piece.s_end - piece.piece.s_begin;
        if (width > kNoWay) add(std::move(piece), i, width);
      }
      if (i == last) continue;
      const Part& next = parts_[i + 1];
      const double before = (1.0 - part.end) * part.cost;
      const double width = before + next.begin * next.cost;
      corners.push_back(cost + before);
      add(blend_piece(part, next, blend_curve(i, width)), i, width);
    }
    if (pieces.empty()) return std::optional(standing(first, std::move(group)));
    for (PlannedPiece& piece : pieces) {
      piece.piece.s_begin /= cost;
      piece.piece.s_end /= cost;
    }
    pieces.back().piece.s_end = 1.0;
    for (const double corner : corners) group.handed_over.push_back(corner / cost);

    std::size_t failed = 0;
    const bool in_motion = start_ && first == 0;
    auto motion = in_motion ? planner_.plan_in_motion(pieces, place_at(parts_[0], parts_[0].begin).joints.value,
                                                      scaled(*start_, 1.0 / cost), place_of(last, "goal"), failed)
                            : planner_.plan(pieces, parts_[first].q_start, place_of(last, "goal"), failed);
    const auto give_up = [&](std::size_t corner, const std::string& why) -> std::optional<Group> {
      note_rest(corner, why);
      stop_after(corner);
      return std::nullopt;
    };
    if (!motion) {
      const std::size_t part = part_of[failed];
      if (first == last || in_motion) return std::unexpected(std::move(motion.error()));
      const std::size_t corner = std::clamp(part, first, last - 1);
      return give_up(corner, motion.error().list().front().message);
    }
    constexpr double kSame = 1e-6;
    if ((motion->q_goal - parts_[last].q_goal).cwiseAbs().maxCoeff() > kSame) {
      if (in_motion)
        return failure(Code::kPlanningFailed, "/blend", "it would lead to another branch of the inverse kinematics");
      return give_up(last - 1, "the blend would lead to another branch of the inverse kinematics");
    }
    group.motion = std::move(*motion);
    return std::optional(std::move(group));
  }

  Group standing(std::size_t part, Group group) const {
    group.motion = {.path = JointLine{parts_[part].q_start, parts_[part].q_start},
                    .q_start = parts_[part].q_start,
                    .q_goal = parts_[part].q_start};
    return group;
  }

  void note_rest(std::size_t corner, const std::string& why) {
    notes_.note(place_of(corner, "blend"), fmt::format("cannot be blended, the arm stops at the goal: {}", why));
  }

  /// Stretches one after the other: each gets a part of s by its cost, and its law that part of the whole law.
  SequencePlan finish(const JointVector& q_start) {
    SequencePlan plan;
    plan.notes = std::move(notes_);
    plan.motion.q_start = q_start;
    plan.motion.q_goal = parts_.empty() ? q_start : parts_.back().q_goal;
    plan.motion.path = JointLine{q_start, plan.motion.q_goal};
    std::vector<const Group*> moving;
    double tau = 0.0;
    for (const Group& group : groups_) {
      for (const double corner : group.handed_over) plan.handed_over.push_back(tau + time_of(group.motion.law, corner));
      tau += group.motion.duration();
      if (&group != &groups_.back()) plan.handed_over.push_back(tau);
      if (group.motion.duration() > 0.0) moving.push_back(&group);
    }
    if (moving.size() == 1) {
      plan.motion.path = moving.front()->motion.path;
      plan.motion.law = moving.front()->motion.law;
      plan.motion.clock = moving.front()->motion.clock;
      plan.motion.shares = moving.front()->motion.shares;
    } else if (moving.size() > 1) {
      chain(moving, plan.motion);
    }
    return plan;
  }

  static void chain(const std::vector<const Group*>& moving, Motion& motion) {
    double total = 0.0;
    for (const Group* group : moving) total += group->cost;
    CompositePath path;
    std::vector<TimeLaw::Segment> segments;
    TimeLaw::Begin start;
    StopTable stop;
    double begin = 0.0;
    for (const Group* group : moving) {
      const double end = group == moving.back() ? 1.0 : begin + group->cost / total;
      for (PathPiece piece : pieces_of(group->motion.path)) {
        piece.s_begin = path.pieces.empty() ? 0.0 : path.pieces.back().s_end;
        piece.s_end = piece.s_end == 1.0 ? end : begin + piece.s_end * (end - begin);
        path.pieces.push_back(std::move(piece));
      }
      for (const auto& [duration, jerk] : group->motion.law.segments())
        segments.push_back({duration, jerk * (end - begin)});
      motion.shares.insert(motion.shares.end(), group->motion.shares.begin(), group->motion.shares.end());
      if (group == moving.front())
        start = {.ds = group->motion.law.begin().ds * end, .dds = group->motion.law.begin().dds * end};
      motion.clock = group == moving.front() ? group->motion.clock : common(motion.clock, group->motion.clock);
      append(stop, group->motion.clock.stop, end);
      begin = end;
    }
    motion.clock.stop = std::move(stop);
    motion.path = std::move(path);
    motion.law = TimeLaw::create(std::move(segments), start).value();
  }

  /// When the law passes s.
  static double time_of(const TimeLaw& law, double s) {
    double low = 0.0;
    double high = law.duration();
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high);
      (law.at(middle).s < s ? low : high) = middle;
    }
    return high;
  }

  const ArmModel& arm_;
  PathPlanner planner_;
  std::optional<MovingStart> start_;  ///< by cost: how the first part is entered, if in motion
  std::vector<Part> parts_;
  std::vector<Group> groups_;
  Diagnostics notes_;
};

}  // namespace

Result<SequencePlan> plan_sequence(const ArmModel& arm, const JointVector& q_start,
                                   const std::vector<LegMaker>& makers) {
  Diagnostics diagnostics;
  check_limits(arm.chain, arm.limits, diagnostics);
  check_cartesian(arm.cartesian, diagnostics);
  if (!diagnostics.has_errors()) check_configuration(arm.chain, arm.limits, q_start, "/start", diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return SequencePlanner(arm).plan(q_start, makers);
}

Result<SequencePlan> plan_take_over(const ArmModel& arm, const Departure& from, const std::vector<LegMaker>& makers) {
  if (makers.empty()) return failure(Code::kPlanningFailed, "", "no motion to go on with");
  Departure now = from;
  Result<SequencePlan> plan = failure(Code::kPlanningFailed, "", "no blend was tried");
  for (const double shrink : {1.0, 0.5, 0.2}) {
    now.shrink = from.shrink * shrink;
    plan = SequencePlanner(arm).plan(now, makers);
    if (plan) return plan;
  }
  return plan;
}

}  // namespace takt::motion
