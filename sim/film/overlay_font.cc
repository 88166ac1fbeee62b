#include "sim/film/overlay_font.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include <fmt/format.h>
#include <ft2build.h>
#include FT_FREETYPE_H

namespace takt::sim {
namespace {

// Where Debian, Fedora and Arch keep DejaVu.
constexpr std::array kFontFolders = {"/usr/share/fonts/truetype/dejavu", "/usr/share/fonts/dejavu-sans-fonts",
                                     "/usr/share/fonts/TTF"};
constexpr char32_t kReplacement = 0xFFFD;
// For what DejaVu Sans lacks, above all Chinese, Japanese and Korean; the first that has a character counts. As Debian
// names them: fonts-droid-fallback, fonts-noto-cjk, fonts-wqy-microhei, fonts-unifont.
constexpr std::array kOtherFonts = {"/usr/share/fonts/truetype/droid/DroidSansFallbackFull.ttf",
                                    "/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc",
                                    "/usr/share/fonts/truetype/wqy/wqy-microhei.ttc",
                                    "/usr/share/fonts/opentype/unifont/unifont.otf"};

std::string find_font(const std::string& file) {
  for (const char* folder : kFontFolders) {
    const auto path = std::filesystem::path(folder) / file;
    std::error_code ignored;
    if (std::filesystem::is_regular_file(path, ignored)) return path.string();
  }
  return {};
}

// Takes the first character off `text`. Malformed bytes become the replacement character, one each.
char32_t next_character(std::string_view& text) {
  const auto first = static_cast<unsigned char>(text.front());
  const std::size_t length = first < 0x80   ? 1
                             : first < 0xC2 ? 0
                             : first < 0xE0 ? 2
                             : first < 0xF0 ? 3
                             : first < 0xF5 ? 4
                                            : 0;
  if (length == 0 || length > text.size()) {
    text.remove_prefix(1);
    return kReplacement;
  }
  char32_t character = length == 1 ? first : first & (0x7F >> length);
  for (std::size_t i = 1; i < length; ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if ((byte & 0xC0) != 0x80) {
      text.remove_prefix(1);
      return kReplacement;
    }
    character = (character << 6) | (byte & 0x3F);
  }
  text.remove_prefix(length);
  return character;
}

void mix(std::uint8_t* pixel, Colour colour, int opacity) {
  const auto blend = [opacity](int under, int over) {
    return static_cast<std::uint8_t>(under + ((over - under) * opacity + 127) / 255);
  };
  pixel[0] = blend(pixel[0], colour.r);
  pixel[1] = blend(pixel[1], colour.g);
  pixel[2] = blend(pixel[2], colour.b);
}

}  // namespace

struct Font::Face {
  FT_Library library = nullptr;
  std::vector<FT_Face> faces;  ///< the font, then those that stand in for it, once they were needed
  int pixels = 0;
  std::vector<std::string> others;  ///< files that have not been opened

  /// False: it cannot be read.
  bool open(const std::string& file) {
    FT_Face face = nullptr;
    if (FT_New_Face(library, file.c_str(), 0, &face) != 0) return false;
    faces.push_back(face);
    return FT_Set_Pixel_Sizes(face, 0, static_cast<FT_UInt>(pixels)) == 0;
  }
  /// The font that has the character, else the first.
  FT_Face face_of(char32_t character) {
    const auto has = [character](FT_Face face) { return FT_Get_Char_Index(face, character) != 0; };
    for (;;) {
      const auto found = std::ranges::find_if(faces, has);
      if (found != faces.end()) return *found;
      if (others.empty()) return faces.front();
      const std::string next = std::move(others.front());
      others.erase(others.begin());
      std::error_code ignored;
      if (std::filesystem::is_regular_file(next, ignored)) (void)open(next);
    }
  }
};

void Font::FaceDeleter::operator()(Face* face) const {
  for (FT_Face one : face->faces) FT_Done_Face(one);
  if (face->library != nullptr) FT_Done_FreeType(face->library);
  delete face;
}

Result<Font> Font::open(Weight weight, int pixels) {
  const std::string file = weight == Weight::kBold ? "DejaVuSans-Bold.ttf" : "DejaVuSans.ttf";
  const std::string path = find_font(file);
  if (path.empty())
    return failure(Code::kNotFound, "", fmt::format("the font {} is missing", file), "Install fonts-dejavu-core");
  Font font;
  font.face_.reset(new Face);
  font.face_->pixels = std::max(6, pixels);
  if (weight == Weight::kBold) font.face_->others.push_back(find_font("DejaVuSans.ttf"));
  font.face_->others.insert(font.face_->others.end(), kOtherFonts.begin(), kOtherFonts.end());
  if (FT_Init_FreeType(&font.face_->library) != 0 || !font.face_->open(path))
    return failure(Code::kFileNotReadable, "", fmt::format("the font {} cannot be read", file),
                   "Reinstall fonts-dejavu-core");
  return font;
}

const Font::Glyph& Font::glyph(char32_t character) {
  auto [found, is_new] = glyphs_.try_emplace(character);
  if (!is_new) return found->second;
  Glyph& glyph = found->second;
  FT_Face face = face_->face_of(character);
  if (FT_Load_Char(face, character, FT_LOAD_RENDER | FT_LOAD_TARGET_LIGHT) != 0) return glyph;
  const FT_GlyphSlot slot = face->glyph;
  glyph = {.left = slot->bitmap_left,
           .top = slot->bitmap_top,
           .width = static_cast<int>(slot->bitmap.width),
           .height = static_cast<int>(slot->bitmap.rows),
           .advance = static_cast<int>(slot->advance.x >> 6),
           .coverage = {}};
  for (int y = 0; y < glyph.height; ++y) {
    const std::uint8_t* row = slot->bitmap.buffer + y * slot->bitmap.pitch;
    glyph.coverage.insert(glyph.coverage.end(), row, row + glyph.width);
  }
  return glyph;
}

int Font::width(std::string_view text) {
  int sum = 0;
  while (!text.empty()) sum += glyph(next_character(text)).advance;
  return sum;
}

std::string Font::fitted(std::string_view text, int most) {
  if (width(text) <= most) return std::string(text);
  const std::string ellipsis = "\u2026";
  int used = width(ellipsis);
  std::string_view rest = text;
  std::size_t kept = 0;
  while (!rest.empty()) {
    used += glyph(next_character(rest)).advance;
    if (used > most) break;
    kept = text.size() - rest.size();
  }
  return std::string(text.substr(0, kept)) + ellipsis;
}

std::string Font::fitted_end(std::string_view text, int most) {
  if (width(text) <= most) return std::string(text);
  const std::string ellipsis = "\u2026";
  const int room = most - width(ellipsis);
  std::string_view rest = text;
  while (!rest.empty() && width(rest) > room) (void)next_character(rest);
  return ellipsis + std::string(rest);
}

void Font::draw(std::string_view text, int left, int base, Colour colour, Image& image) {
  while (!text.empty()) {
    const Glyph& shape = glyph(next_character(text));
    for (int y = 0; y < shape.height; ++y) {
      for (int x = 0; x < shape.width; ++x) {
        const int column = left + shape.left + x, row = base - shape.top + y;
        if (column < 0 || row < 0 || column >= image.width || row >= image.height) continue;
        mix(image.pixel(column, row), colour, shape.coverage[static_cast<std::size_t>(y * shape.width + x)]);
      }
    }
    left += shape.advance;
  }
}

void fill_rectangle(Image& image, int left, int top, int width, int height, Colour colour, int opacity) {
  const int x0 = std::max(0, left), x1 = std::min(image.width, left + width);
  for (int y = std::max(0, top); y < std::min(image.height, top + height); ++y)
    for (int x = x0; x < x1; ++x) mix(image.pixel(x, y), colour, opacity);
}

}  // namespace takt::sim
