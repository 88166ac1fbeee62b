#include "sim/film/render_image.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <png.h>

#include "core/base/output_file.h"

namespace takt::sim {

Result<void> write_ppm(const Image& image, const std::filesystem::path& path) {
  std::ofstream file(path, std::ios::binary);
  file << fmt::format("P6\n{} {}\n255\n", image.width, image.height);
  std::vector<char> row(static_cast<std::size_t>(3 * image.width));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) std::memcpy(row.data() + 3 * x, image.pixel(x, y), 3);
    file.write(row.data(), static_cast<std::streamsize>(row.size()));
  }
  file.close();
  if (!file) return failure(Code::kFileNotWritable, "", fmt::format("cannot write '{}'", path.string()));
  return {};
}

Result<std::string> png_of(const Image& image, bool fast) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(static_cast<std::size_t>(3) * static_cast<std::size_t>(image.width * image.height));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) rgb.insert(rgb.end(), image.pixel(x, y), image.pixel(x, y) + 3);
  }
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  if (fast) png.flags |= PNG_IMAGE_FLAG_FAST;
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(png), '\0');
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, rgb.data(), 0, nullptr) == 0)
    return failure(Code::kInternal, "", fmt::format("the picture cannot be made: {}", png.message));
  bytes.resize(size);
  return bytes;
}

Result<void> write_png(const Image& image, const std::filesystem::path& path) {
  const auto bytes = png_of(image);
  if (!bytes) return std::unexpected(bytes.error());
  // Not by the library's own file: it removes what it could not write, be it a device.
  if (Diagnostics diagnostics = write_file(path, *bytes); diagnostics.has_errors())
    return std::unexpected(std::move(diagnostics));
  return {};
}

void paste(const Image& source, Image& target, int left, int top, int border) {
  const int x0 = std::max(0, left - border), x1 = std::min(target.width, left + source.width + border);
  for (int y = std::max(0, top - border); y < std::min(target.height, top + source.height + border); ++y)
    if (x1 > x0) std::fill_n(target.pixel(x0, y), 4 * (x1 - x0), std::uint8_t{245});
  for (int y = 0; y < source.height; ++y) {
    const int first = std::max(0, -left), last = std::min(source.width, target.width - left);
    if (top + y < 0 || top + y >= target.height || last <= first) continue;
    std::memcpy(target.pixel(left + first, top + y), source.pixel(first, y),
                static_cast<std::size_t>(4 * (last - first)));
  }
}

}  // namespace takt::sim
