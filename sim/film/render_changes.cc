#include "sim/film/render_changes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace takt::sim {
namespace {

using Eigen::AlignedBox3f;
using Eigen::Vector3f;

constexpr float kBeside = 1e-3f;     // w of clip coordinates; less is beside or behind the eye
constexpr float kRim = 2;            // pixels around what is computed, for rounding and the neighbours of a pixel
constexpr int kPieces = 6;           // of the way of a shadow, each with a box of its own
constexpr float kLevelLight = 0.1f;  // share of the light's direction that points down; less: its shadows are endless

}  // namespace

std::optional<PixelBox> pixels_of(const AlignedBox3f& box, const Eigen::Matrix4f& view, int width, int height) {
  PixelBox pixels;
  if (box.isEmpty()) return pixels;
  const Eigen::Array2f half(0.5f * static_cast<float>(width), 0.5f * static_cast<float>(height));
  for (int i = 0; i < 8; ++i) {
    const Vector3f corner = box.corner(static_cast<AlignedBox3f::CornerType>(i));
    const Eigen::Vector4f clip = view * corner.homogeneous();
    if (clip.w() < kBeside) return std::nullopt;
    pixels.extend(Eigen::Vector2f((clip.head<2>() / clip.w()).array() * half + half));
  }
  pixels.min().array() -= kRim;
  pixels.max().array() += kRim;
  return pixels;
}

TileMask::TileMask(int width, int height)
    : width_(width),
      height_(height),
      columns_((width + kSide - 1) / kSide),
      rows_((height + kSide - 1) / kSide),
      marked_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

void TileMask::clear() {
  std::ranges::fill(marked_, std::uint8_t{0});
  count_ = 0;
}

void TileMask::add_all() {
  std::ranges::fill(marked_, std::uint8_t{1});
  count_ = marked_.size();
}

std::optional<TileMask::Tiles> TileMask::tiles_of(const PixelBox& pixels) const {
  if (pixels.isEmpty()) return std::nullopt;
  const auto tile = [](float pixel, int most) {
    return static_cast<int>(std::clamp(std::floor(pixel / kSide), -1.0f, static_cast<float>(most)));
  };
  const int left = tile(pixels.min().x(), columns_), right = tile(pixels.max().x(), columns_);
  const int top = tile(pixels.min().y(), rows_), bottom = tile(pixels.max().y(), rows_);
  if (right < 0 || bottom < 0 || left >= columns_ || top >= rows_) return std::nullopt;
  return Tiles{std::max(left, 0), std::max(top, 0), std::min(right + 1, columns_), std::min(bottom + 1, rows_)};
}

void TileMask::add(const std::optional<PixelBox>& pixels) {
  if (!pixels) return add_all();
  const auto tiles = tiles_of(*pixels);
  if (!tiles) return;
  for (int row = tiles->top; row < tiles->bottom; ++row) {
    for (int column = tiles->left; column < tiles->right; ++column) {
      std::uint8_t& one = marked_[static_cast<std::size_t>(row * columns_ + column)];
      count_ += 1 - one;
      one = 1;
    }
  }
}

bool TileMask::meets(const std::optional<PixelBox>& pixels) const {
  if (!pixels) return !empty();
  const auto tiles = tiles_of(*pixels);
  if (!tiles) return false;
  for (int row = tiles->top; row < tiles->bottom; ++row) {
    const auto first = marked_.begin() + row * columns_;
    if (std::find(first + tiles->left, first + tiles->right, std::uint8_t{1}) != first + tiles->right) return true;
  }
  return false;
}

std::vector<std::array<int, 4>> TileMask::rectangles() const {
  std::vector<Tiles> found;
  for (int row = 0; row < rows_; ++row) {
    const std::size_t before = found.size();
    for (int column = 0; column < columns_;) {
      const auto marked = [&](int at) { return marked_[static_cast<std::size_t>(row * columns_ + at)] != 0; };
      if (!marked(column)) {
        ++column;
        continue;
      }
      const int left = column;
      while (column < columns_ && marked(column)) ++column;
      const auto above =
          std::find_if(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(before),
                       [&](const Tiles& one) { return one.bottom == row && one.left == left && one.right == column; });
      if (above != found.begin() + static_cast<std::ptrdiff_t>(before)) {
        ++above->bottom;
      } else {
        found.push_back({left, row, column, row + 1});
      }
    }
  }
  std::vector<std::array<int, 4>> rectangles;
  for (const Tiles& one : found)
    rectangles.push_back({one.left * kSide, one.top * kSide, std::min(one.right * kSide, width_),
                          std::min(one.bottom * kSide, height_)});
  return rectangles;
}

std::array<int, 4> TileMask::bounds() const {
  std::array<int, 4> bounds{width_, height_, 0, 0};
  for (const auto& [left, top, right, bottom] : rectangles())
    bounds = {std::min(bounds[0], left), std::min(bounds[1], top), std::max(bounds[2], right),
              std::max(bounds[3], bottom)};
  if (empty()) return {0, 0, 0, 0};
  return {bounds[0], bounds[1], bounds[2] - bounds[0], bounds[3] - bounds[1]};
}

std::vector<DrawnGeoms::Geom> DrawnGeoms::replace(std::vector<Geom> geoms) {
  const auto by_look = [](const Geom& a, const Geom& b) { return a.look < b.look; };
  std::ranges::sort(geoms, by_look);
  std::vector<Geom> changed;
  std::ranges::set_symmetric_difference(drawn_, geoms, std::back_inserter(changed), by_look);
  drawn_ = std::move(geoms);
  return changed;
}

void mark(const std::vector<DrawnGeoms::Geom>& changed, const Eigen::Matrix4f& view, int width, int height,
          const std::optional<ShadowReach>& reach, TileMask& mask) {
  for (const DrawnGeoms::Geom& geom : changed) {
    if (geom.is_floor) return mask.add_all();
    mask.add(pixels_of(geom.box, view, width, height));
    if (!reach || !geom.casts_shadow) continue;
    if (!reach->direction || reach->direction->z() > -kLevelLight) return mask.add_all();
    const Vector3f& direction = *reach->direction;
    AlignedBox3f box = geom.box;
    box.min().array() -= reach->margin;
    box.max().array() += reach->margin;
    const float way = std::max(0.0f, box.max().z() - reach->lowest) / -direction.z();
    for (int i = 0; i < kPieces; ++i) {
      const float begin = way * static_cast<float>(i) / kPieces, end = way * static_cast<float>(i + 1) / kPieces;
      AlignedBox3f piece = box.translated(Vector3f(begin * direction));
      piece.extend(box.translated(Vector3f(end * direction)));
      mask.add(pixels_of(piece, view, width, height));
    }
  }
}

}  // namespace takt::sim
